/* Saved states of a container: what it remembers itself, its bus, and a state of each FMU inside. */
#include <string.h>

#include "container.h"

typedef struct {
    char mark[8], guid[40];
    Kept kept;
} Beginning;

/* Behind it, in the same piece of memory, the bus and the states of the FMUs inside. */
typedef struct {
    Beginning beginning;
    double *bus;
    fmi2FMUstate *inner;
} Saved;

static const char MARK[8] = "CNTNRst";

static bool ours(const Container *c, const Saved *saved)
{
    return saved != NULL && memcmp(saved->beginning.mark, MARK, sizeof MARK) == 0 &&
           strcmp(saved->beginning.guid, c->head.guid) == 0;
}

/* *state, or a new one where that is NULL; NULL with an error told where there can be none. */
static Saved *place(Container *c, fmi2FMUstate *state, const char *function)
{
    if (state == NULL || (*state != NULL && !ours(c, *state))) {
        (void)REFUSE(c, function, ": ", "expected NULL or a state of this FMU to write over");
        return NULL;
    }
    if (*state == NULL) {
        const size_t bus = c->head.outputs * sizeof(double);
        Saved *made = c->host.calls.allocateMemory(1, sizeof *made + bus + c->head.blocks * sizeof *made->inner);
        if (made == NULL) {
            (void)REFUSE(c, function, ": ", "allocateMemory gave no memory");
            return NULL;
        }
        memset(made, 0, sizeof *made + bus + c->head.blocks * sizeof *made->inner);
        made->bus = (double *)(void *)(made + 1);
        made->inner = (fmi2FMUstate *)(void *)((char *)(made + 1) + bus);
        memcpy(made->beginning.mark, MARK, sizeof MARK);
        memcpy(made->beginning.guid, c->head.guid, sizeof made->beginning.guid);
        *state = made;
    }
    return *state;
}

/* The FMU inside where it can be asked for a state. */
static Inner *able(Container *c, uint32_t i, const char *function, fmi2Status *status)
{
    Inner *inner = &c->inner[i];
    const bool can = inner->get_state != NULL && inner->set_state != NULL && inner->free_state != NULL &&
                     inner->state_size != NULL && inner->write_state != NULL && inner->read_state != NULL;
    *status = inner->lost ? fmi2Fatal : can ? fmi2OK : REFUSE(c, function, ": ", "a library inside has no states");
    return *status == fmi2OK ? inner : NULL;
}

/* Of a call that has failed: no half of a state is left where there was none before. */
static fmi2Status without(Container *c, fmi2FMUstate *state, bool made, fmi2Status status)
{
    if (made && status != fmi2OK) {
        fmi2FreeFMUstate(c, state);
    }
    return status;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Container *c = component;
    fmi2Status status = fmi2OK;
    const bool made = state != NULL && *state == NULL;
    Saved *saved = place(c, state, "fmi2GetFMUstate");
    for (uint32_t i = 0; saved != NULL && i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = able(c, i, "fmi2GetFMUstate", &status);
        if (inner != NULL) {
            status = inner_done(inner, inner->get_state(inner->instance, &saved->inner[i]), "fmi2GetFMUstate");
        }
    }
    if (saved == NULL) {
        return fmi2Error;
    }
    saved->beginning.kept = c->kept;
    memcpy(saved->bus, c->bus, c->head.outputs * sizeof *c->bus);
    return without(c, state, made, status);
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    Container *c = component;
    const Saved *saved = state;
    fmi2Status status = fmi2OK;
    if (!ours(c, saved)) {
        return REFUSE(c, "fmi2SetFMUstate", ": ", "expected a state that fmi2GetFMUstate of this FMU gave");
    }
    for (uint32_t i = 0; i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = able(c, i, "fmi2SetFMUstate", &status);
        if (inner != NULL) {
            status = inner_done(inner, inner->set_state(inner->instance, saved->inner[i]), "fmi2SetFMUstate");
        }
    }
    c->kept = saved->beginning.kept;
    memcpy(c->bus, saved->bus, c->head.outputs * sizeof *c->bus);
    c->kept.mode = status == fmi2OK ? c->kept.mode : MODE_FAILED;
    return status;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    Container *c = component;
    if (state == NULL || *state == NULL) {
        return fmi2OK;
    }
    Saved *saved = *state;
    fmi2Status status = fmi2OK;
    if (!ours(c, saved)) {
        return REFUSE(c, "fmi2FreeFMUstate", ": ", "expected a state that fmi2GetFMUstate of this FMU gave");
    }
    for (uint32_t i = 0; i < c->head.blocks; ++i) {
        Inner *inner = &c->inner[i];
        if (saved->inner[i] != NULL && !inner->lost) {
            const fmi2Status now =
                inner_done(inner, inner->free_state(inner->instance, &saved->inner[i]), "fmi2FreeFMUstate");
            status = now > status ? now : status;
        }
    }
    memset(saved->beginning.mark, 0, sizeof saved->beginning.mark);
    c->host.calls.freeMemory(saved);
    *state = NULL;
    return status;
}

/* Bytes: the beginning, the bus, and of each FMU inside how many it has, with these. */
fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    static const char *const function = "fmi2SerializedFMUstateSize";
    Container *c = component;
    Saved *saved = state;
    fmi2Status status = fmi2OK;
    if (!ours(c, saved) || size == NULL) {
        return REFUSE(c, function, ": ", "expected a state of this FMU and a place for its size");
    }
    *size = sizeof(Beginning) + c->head.outputs * sizeof(double);
    for (uint32_t i = 0; i < c->head.blocks && status == fmi2OK; ++i) {
        size_t one = 0;
        Inner *inner = able(c, i, function, &status);
        if (inner != NULL) {
            status = inner_done(inner, inner->state_size(inner->instance, saved->inner[i], &one), function);
        }
        *size += sizeof(uint64_t) + one;
    }
    return status;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    static const char *const function = "fmi2SerializeFMUstate";
    Container *c = component;
    Saved *saved = state;
    size_t needed = 0, at = sizeof(Beginning), one = 0;
    fmi2Status status = fmi2SerializedFMUstateSize(c, state, &needed);
    if (status == fmi2OK && (bytes == NULL || size < needed)) {
        return REFUSE(c, function, ": ", "expected a buffer of fmi2SerializedFMUstateSize bytes");
    }
    if (status != fmi2OK) {
        return status;
    }
    memcpy(bytes, &saved->beginning, sizeof(Beginning));
    memcpy(bytes + at, saved->bus, c->head.outputs * sizeof(double));
    at += c->head.outputs * sizeof(double);
    for (uint32_t i = 0; i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = &c->inner[i];
        status = inner_done(inner, inner->state_size(inner->instance, saved->inner[i], &one), function);
        const uint64_t length = one;
        memcpy(bytes + at, &length, sizeof length);
        at += sizeof length;
        if (status == fmi2OK) {
            status = inner_done(inner, inner->write_state(inner->instance, saved->inner[i], bytes + at, one), function);
        }
        at += one;
    }
    return status;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    static const char *const function = "fmi2DeSerializeFMUstate";
    static const char *const expected = "expected the bytes that fmi2SerializeFMUstate of this FMU wrote";
    Container *c = component;
    Beginning beginning;
    size_t at = sizeof beginning + c->head.outputs * sizeof(double);
    if (bytes == NULL || size < at) {
        return REFUSE(c, function, ": ", expected);
    }
    memcpy(&beginning, bytes, sizeof beginning);
    beginning.guid[sizeof beginning.guid - 1] = '\0';
    if (memcmp(beginning.mark, MARK, sizeof MARK) != 0 || strcmp(beginning.guid, c->head.guid) != 0 ||
        beginning.kept.mode > MODE_TERMINATED || beginning.kept.count < 0) {
        return REFUSE(c, function, ": ", expected);
    }
    const bool made = state != NULL && *state == NULL;
    Saved *saved = place(c, state, function);
    if (saved == NULL) {
        return fmi2Error;
    }
    saved->beginning = beginning;
    memcpy(saved->bus, bytes + sizeof beginning, c->head.outputs * sizeof(double));
    fmi2Status status = fmi2OK;
    for (uint32_t i = 0; i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = able(c, i, function, &status);
        uint64_t length = UINT64_MAX;
        if (size - at >= sizeof length) {
            memcpy(&length, bytes + at, sizeof length);
            at += sizeof length;
        }
        if (inner != NULL && length > size - at) {
            status = REFUSE(c, function, ": ", expected);
        } else if (inner != NULL) {
            const fmi2Status now = inner->read_state(inner->instance, bytes + at, (size_t)length, &saved->inner[i]);
            status = inner_done(inner, now, function);
            at += (size_t)length;
        }
    }
    return without(c, state, made, status);
}
