/* The outputs of a silent device with the policy zero; those that are not finite. */
#include "instance.h"

#include <math.h>

void link_zero_outputs(Outputs *y)
{
    memset(y, 0, sizeof *y);
    for (size_t i = 0; i < BLOCK_VARIABLES; ++i) {
        const Variable *v = &variables[i];
        if (v->causality == CAUSALITY_OUTPUT && v->kind == KIND_INTEGER && v->min > 0.0) {
            const int32_t least = (int32_t)v->min;
            memcpy((unsigned char *)y + (v->offset - offsetof(Ports, y)), &least, sizeof least);
        }
    }
}

const char *link_not_finite(const Outputs *y)
{
    for (size_t i = 0; i < BLOCK_VARIABLES; ++i) {
        const Variable *v = &variables[i];
        double value = 0.0;
        if (v->causality == CAUSALITY_OUTPUT && v->kind == KIND_REAL) {
            memcpy(&value, (const unsigned char *)y + (v->offset - offsetof(Ports, y)), sizeof value);
        }
        if (!isfinite(value)) {
            return v->name;
        }
    }
    return NULL;
}
