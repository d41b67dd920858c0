/* An instance of a container: the FMUs inside, the tables of resources/container.bin, and the loop of loop.c over them.
 * table.py writes the tables; their rows are laid out as here. */
#ifndef CONTAINER_H
#define CONTAINER_H

#include <stdbool.h>

#include "host.h"
#include "loop.h"

typedef enum { KIND_REAL, KIND_INTEGER, KIND_BOOLEAN, KIND_STRING, KINDS } Kind;
#define NO_BLOCK UINT32_MAX /* of the variable that is the time */

typedef struct {
    char magic[8], guid[40];
    uint32_t blocks, variables, starts, inputs, outputs, initial, text, parallel;
    double numerator, denominator; /* of the step, s */
} Head;

/* Places in the text, which has zeros between its parts: of an FMU that stands in a folder of the resources, and whose
 * library has the name of `identifier`. */
typedef struct {
    uint32_t name, guid, folder, identifier;
} BlockRow;

/* What a host may get, and set where `settable`; its value reference is its place among its like. */
typedef struct {
    uint32_t kind, block, reference, settable;
} VariableRow;

typedef struct {
    uint32_t kind, block, reference, text;
    double value;
} StartRow;

/* One end of a wire, by blocks and kinds: of an output, which is a place on the bus, `place` is that of its name in the
 * text; of an input that of its source on the bus. */
typedef struct {
    uint32_t kind, block, reference, place;
} End;

/* factor * source + offset */
typedef struct {
    End end;
    double factor, offset;
} InputRow;

typedef struct Container Container;
typedef fmi2Status (*Plain)(fmi2Component);
typedef fmi2Status (*Access)(fmi2Component, const fmi2ValueReference[], size_t, void *);

/* An FMU inside. */
typedef struct {
    Container *container;
    const char *name;
    void *library;
    fmi2Component instance;
    bool lost; /* it has returned fmi2Fatal, and nothing may be called any more */
    fmi2CallbackFunctions calls;
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                                 fmi2Boolean, fmi2Boolean);
    void (*free)(fmi2Component);
    fmi2Status (*setup)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    Plain enter, leave, terminate, reset;
    fmi2Status (*step)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    Access get[KINDS], set[KINDS];
    fmi2Status (*debug)(fmi2Component, fmi2Boolean, size_t, const fmi2String[]);
    /* NULL where the library lacks them */
    fmi2Status (*get_state)(fmi2Component, fmi2FMUstate *), (*set_state)(fmi2Component, fmi2FMUstate);
    fmi2Status (*free_state)(fmi2Component, fmi2FMUstate *);
    fmi2Status (*state_size)(fmi2Component, fmi2FMUstate, size_t *);
    fmi2Status (*write_state)(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
    fmi2Status (*read_state)(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);
} Inner;

typedef enum { MODE_SETUP, MODE_INITIALIZATION, MODE_STEP, MODE_FAILED, MODE_TERMINATED } Mode;

/* What the container itself remembers of a run, besides the bus: a part of a saved state. */
typedef struct {
    int64_t count;      /* steps of the scenario that are done */
    double begin, time; /* of the host, s */
    uint32_t mode;      /* a Mode */
    uint32_t passed_on; /* in initialization mode: outputs have gone to the inputs since the last Set */
} Kept;

struct Container {
    Host host; /* first */
    Kept kept;
    Head head;
    BlockRow *blocks;
    VariableRow *variables;
    StartRow *starts;
    InputRow *inputs;
    End *outputs;
    uint32_t *initial; /* the inputs to which initialization passes outputs on, in this order */
    char *text;
    Inner *inner;
    double *bus, *values; /* `values` are those of all inputs */
    Loop loop;
    void *taken; /* the last piece of memory, which begins with the address of the one before */
};

/* Memory with zeros until the container is freed; NULL where the host gives none. */
void *container_take(Container *c, size_t count, size_t size);

/* Reads the tables of this GUID, and lays the loop out; else false with a reason. */
bool table_open(Container *c, const char *resources, const char *guid, const char **reason);
bool table_lay_out(Container *c);

/* Tells the host what is put together of these texts, the last of which is followed by NULL. */
void container_say(const Container *c, fmi2Status status, const char *category, ...);

/* The same of an error, which is what it gives. */
#define REFUSE(C, ...) (container_say((C), fmi2Error, "logStatusError", __VA_ARGS__, NULL), fmi2Error)

/* Loads a library and makes the instance. Returns whether it is made; if not, the host has been told why. */
bool inner_open(Inner *inner, const BlockRow *row, const char *resources, fmi2Boolean visible, fmi2Boolean log);
void inner_close(Inner *inner);

/* What the container returns where a call of an FMU inside gave this status; an error is told with its name. */
fmi2Status inner_done(Inner *inner, fmi2Status status, const char *function);

/* Gets or sets n variables of a kind. */
fmi2Status inner_access(Inner *inner, bool sets, uint32_t kind, const fmi2ValueReference[], size_t n, void *values);
extern const char *const GETTERS[KINDS], *const SETTERS[KINDS]; /* their names */

/* A single number, as a double. */
fmi2Status inner_get(Inner *inner, uint32_t kind, fmi2ValueReference reference, double *value);
fmi2Status inner_set(Inner *inner, uint32_t kind, fmi2ValueReference reference, double value);

/* In initialization mode: outputs to inputs, in the order in which they depend on each other. */
fmi2Status container_pass_on(Container *c);

#endif
