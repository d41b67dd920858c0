/* fmi2Get... and fmi2Set... of a container: they go to the FMU inside whose variable it is. */
#include "container.h"

enum { TOGETHER = 64 };

static const size_t SIZES[KINDS] = {sizeof(fmi2Real), sizeof(fmi2Integer), sizeof(fmi2Boolean), sizeof(fmi2String)};

/* Neighbours of one FMU go in one call. */
static fmi2Status pass_values(Container *c, bool sets, Kind kind, const fmi2ValueReference r[], size_t n, char *values)
{
    fmi2Status status = fmi2OK;
    if (c->kept.mode == MODE_INITIALIZATION && !sets) {
        status = container_pass_on(c);
    }
    c->kept.passed_on = c->kept.passed_on && !sets;
    for (size_t i = 0; i < n && status == fmi2OK;) {
        fmi2ValueReference inside[TOGETHER];
        size_t count = 0;
        uint32_t block = 0;
        for (; i + count < n && count < TOGETHER; ++count) {
            const VariableRow *row = r[i + count] < c->head.variables ? &c->variables[r[i + count]] : NULL;
            if (row == NULL || row->kind != (uint32_t)kind || (sets && !row->settable)) {
                return REFUSE(c, sets ? SETTERS[kind] : GETTERS[kind],
                              sets ? ": there is no parameter or free input with this value reference"
                                   : ": there is no variable of this type with this value reference");
            }
            if (count > 0 && row->block != block) {
                break;
            }
            block = row->block;
            inside[count] = row->reference;
        }
        if (block == NO_BLOCK) {
            for (size_t k = 0; k < count; ++k) {
                ((fmi2Real *)(void *)values)[i + k] = c->kept.time;
            }
        } else {
            status = inner_access(&c->inner[block], sets, kind, inside, count, values + i * SIZES[kind]);
        }
        i += count;
    }
    return status;
}

#define ACCESS(NAME, TYPE, KIND)                                                                                       \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, TYPE v[])                        \
    {                                                                                                                  \
        return pass_values(c, false, KIND, r, n, (char *)v);                                                           \
    }                                                                                                                  \
    fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference r[], size_t n, const TYPE v[])                  \
    {                                                                                                                  \
        return pass_values(c, true, KIND, r, n, (char *)(size_t)v); /* whose values stay as they are */                \
    }

ACCESS(Real, fmi2Real, KIND_REAL)
ACCESS(Integer, fmi2Integer, KIND_INTEGER)
ACCESS(Boolean, fmi2Boolean, KIND_BOOLEAN)
ACCESS(String, fmi2String, KIND_STRING)
