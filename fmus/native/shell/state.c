/* Saving and restoring all that an instance remembers: a copy of it behind a header that tells whose it is.
 * Tests: tests/native/test_states.py. */
#include "instance.h"

typedef struct {
    char mark[8];
    char guid[48];
    uint64_t size;
    uint64_t checksum; /* of content, in serialized bytes only */
} Header;

typedef struct {
    Memory memory;
    State state;
} Content;

typedef struct {
    Header header;
    Content content;
} Saved;

static const char MARK[8] = {'F', 'M', 'U', 's', 't', 'a', 't', '1'};

/* Of the bytes of a content. */
static uint64_t checksum(const void *content)
{
    const unsigned char *bytes = content;
    uint64_t hash = 14695981039346656037u; /* FNV-1a */
    for (size_t i = 0; i < sizeof(Content); ++i) {
        hash = (hash ^ bytes[i]) * 1099511628211u;
    }
    return hash;
}

static bool is_ours(const Header *header)
{
    return memcmp(header->mark, MARK, sizeof MARK) == 0 && strcmp(header->guid, BLOCK_GUID) == 0 &&
           header->size == sizeof(Saved);
}

static Saved *allocate(const Instance *c)
{
    Saved *saved = c->callbacks.allocateMemory(1, sizeof *saved);
    if (saved != NULL) {
        memset(saved, 0, sizeof *saved);
        memcpy(saved->header.mark, MARK, sizeof MARK);
        memcpy(saved->header.guid, BLOCK_GUID, sizeof BLOCK_GUID);
        saved->header.size = sizeof *saved;
    }
    return saved;
}

/* The instance where `state` is one of this FMU's. */
static Instance *enter_with(fmi2Component component, const char *function, const Saved *state, fmi2Status *status)
{
    Instance *c = enter(component, function, IN_ANY, status);
    if (c != NULL && (state == NULL || !is_ours(&state->header))) {
        *status = refuse_text(c, function, "expected a state that fmi2GetFMUstate of this FMU gave");
        return NULL;
    }
    return c;
}

/* The one allocation after instantiation: FMI lets the master own any number of states. */
fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2GetFMUstate", IN_ANY, &status);
    if (c == NULL) {
        return status;
    }
    if (state == NULL) {
        return refuse_text(c, "fmi2GetFMUstate", "state is NULL");
    }
    if (*state != NULL && !is_ours(*state)) {
        return refuse_text(c, "fmi2GetFMUstate", "expected NULL or a state of this FMU to write over");
    }
    Saved *saved = *state != NULL ? *state : allocate(c);
    if (saved == NULL) {
        return refuse_text(c, "fmi2GetFMUstate", "allocateMemory gave no memory");
    }
    memcpy(&saved->content.memory, &c->memory, sizeof c->memory);
    memcpy(&saved->content.state, state_of(c), sizeof(State));
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    fmi2Status status;
    const Saved *saved = state;
    Instance *c = enter_with(component, "fmi2SetFMUstate", saved, &status);
    if (c != NULL) {
        const Parameters *p = &saved->content.memory.ports.p;
        c->law_current = c->law_current && memcmp(p, &c->memory.ports.p, sizeof *p) == 0;
        memcpy(&c->memory, &saved->content.memory, sizeof c->memory);
        memcpy(other_state(c), &saved->content.state, sizeof(State));
        commit_state(c);
    }
    return status;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    fmi2Status status;
    if (state == NULL || *state == NULL) {
        return enter(component, "fmi2FreeFMUstate", IN_ANY, &status) == NULL ? status : fmi2OK;
    }
    Saved *saved = *state;
    Instance *c = enter_with(component, "fmi2FreeFMUstate", saved, &status);
    if (c != NULL) {
        memset(saved->header.mark, 0, sizeof saved->header.mark);
        c->callbacks.freeMemory(saved);
        *state = NULL;
    }
    return status;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    fmi2Status status;
    Instance *c = enter_with(component, "fmi2SerializedFMUstateSize", state, &status);
    if (c == NULL) {
        return status;
    }
    if (size == NULL) {
        return refuse_text(c, "fmi2SerializedFMUstateSize", "size is NULL");
    }
    *size = sizeof(Saved);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    fmi2Status status;
    Saved *saved = state;
    Instance *c = enter_with(component, "fmi2SerializeFMUstate", saved, &status);
    if (c == NULL) {
        return status;
    }
    if (bytes == NULL || size < sizeof *saved) {
        return refuse_text(c, "fmi2SerializeFMUstate", "expected a buffer of fmi2SerializedFMUstateSize bytes");
    }
    saved->header.checksum = checksum(&saved->content);
    memcpy(bytes, saved, sizeof *saved);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    static const char *const function = "fmi2DeSerializeFMUstate";
    fmi2Status status;
    Instance *c = enter(component, function, IN_ANY, &status);
    if (c == NULL) {
        return status;
    }
    if (bytes == NULL || state == NULL) {
        return refuse_text(c, function, "an argument is NULL");
    }
    Header header;
    if (size == sizeof(Saved)) {
        memcpy(&header, bytes, sizeof header);
        header.guid[sizeof header.guid - 1] = '\0';
    }
    if (size != sizeof(Saved) || !is_ours(&header) || header.checksum != checksum(bytes + offsetof(Saved, content))) {
        return refuse_text(c, function, "expected the unchanged bytes that fmi2SerializeFMUstate of this FMU wrote");
    }
    if (*state != NULL && !is_ours(*state)) {
        return refuse_text(c, function, "expected NULL or a state of this FMU to write over");
    }
    Saved *saved = *state != NULL ? *state : allocate(c);
    if (saved == NULL) {
        return refuse_text(c, function, "allocateMemory gave no memory");
    }
    memcpy(saved, bytes, sizeof *saved);
    *state = saved;
    return fmi2OK;
}
