/* One FMU instance, and what the shell's files share. The block itself comes from the generated block.h. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "block.h"
#include "fmi2.h"

/* Nothing of this is a host's concern. */
#if defined(__ELF__)
#pragma GCC visibility push(hidden)
#endif

enum { NAME_SIZE = 256, MESSAGE_SIZE = 512, TEXT_SIZE = 128 };

typedef enum { KIND_REAL, KIND_INTEGER, KIND_BOOLEAN, KIND_STRING } Kind;
typedef enum { CAUSALITY_PARAMETER, CAUSALITY_INPUT, CAUSALITY_OUTPUT } Causality;
typedef enum { FIXED, TUNABLE, MOVING } Variability;

/* A scalar FMI variable; its value reference is its place in `variables`. */
typedef struct {
    const char *name;
    const char *text;       /* start of a string */
    double start, min, max; /* without a limit of its own: -DBL_MAX and DBL_MAX, which NaN and infinity are beyond */
    uint32_t offset;        /* in Ports */
    Kind kind;
    Causality causality;
    Variability variability;
    uint32_t followers; /* how many after this one differ in name, text and start only, and lie side by side: a run */
} Variable;

typedef struct {
    Parameters p;
    Inputs u;
    Outputs y;
    struct {
        double sample_period; /* s; 0: the block acts in each step */
    } sampling;
} Ports;

extern const Variable variables[BLOCK_VARIABLES];

typedef enum { MODE_SETUP, MODE_INITIALIZATION, MODE_STEP, MODE_TERMINATED } Mode;

/* All that an instance remembers but for the block's state: what fmi2GetFMUstate saves, with that. */
typedef struct {
    Ports ports;
    double time;       /* of the master, s */
    double begin;      /* startTime, from which the block's own instants count, s */
    double stop;       /* beyond which no step may end, s; infinite where the master gave none */
    uint64_t instants; /* of the block's own: how many it has acted at */
    Mode mode;
    bool held;   /* ports.y are those of the last own instant, whatever the inputs are by now */
    bool set_up; /* fmi2SetupExperiment was called */
    bool fresh;  /* ports.y fit the state and the inputs */
} Memory;

typedef struct {
    Memory memory;
    State states[2];  /* the block's state, and room to work on the next one: a state may be too large for the stack */
    int current;      /* which is the state */
    Law law;          /* what follows from memory.ports.p */
    bool law_current; /* law fits memory.ports.p, which has passed its check */
    bool log_events;  /* errors are always logged */
    fmi2CallbackFunctions callbacks;
    char name[NAME_SIZE];
    const char *called; /* the function of FMI 3.0 that the host called; NULL with FMI 2.0 */
} Instance;

/* A message under construction; what does not fit is cut. */
typedef struct {
    char text[MESSAGE_SIZE];
    size_t length;
} Message;

Message message(const char *text);
void put(Message *m, const char *text);

/* A message that begins with the name of the function: the host's, where it is not the one that gives it. */
Message about(const Instance *c, const char *function);
void put_number(Message *m, double x);

/* Each logs and returns fmi2Error, so that a function can end with `return refuse(...)`. */
fmi2Status refuse(const Instance *c, const Message *m);
fmi2Status refuse_text(const Instance *c, const char *function, const char *text);
fmi2Status refuse_fault(const Instance *c, const char *function, const Fault *f);
fmi2Status refuse_variable(const Instance *c, const char *function, const Variable *v, const char *text);
void log_event(const Instance *c, const char *text);

fmi2Status refuse_value(const Instance *c, const char *function, const Variable *v, double value);

/* Logs why a reference is wrong and returns false; apart from the check, which is made in every step. */
bool refuse_reference(const Instance *c, const char *function, fmi2ValueReference reference, Kind kind);

/* Every function of the interface begins with this: the instance, or NULL (and *status an error) where the handle is
 * NULL or the mode is none of `modes`, a sum of 1 << Mode. */
Instance *enter(fmi2Component component, const char *function, unsigned modes, fmi2Status *status);

enum { IN_SETUP = 1, IN_INITIALIZATION = 2, IN_STEP = 4, IN_TERMINATED = 8, IN_ANY = 15 };

/* The block's state. */
const State *state_of(const Instance *c);

/* Room for a state that is tried; commit_state makes it the block's. */
State *other_state(Instance *c);
void commit_state(Instance *c);

/* Start values of all parameters and inputs; the mode is then MODE_SETUP. */
void restore_starts(Instance *c);

/* Checks the parameters where they have changed; fmi2Error with a message where they do not fit each other. */
fmi2Status make_law_current(Instance *c, const char *function);

/* The state that the inputs give at the start, in other_state. */
fmi2Status start(Instance *c, const char *function);

/* The outputs of x, written only where all is well. */
fmi2Status evaluate(Instance *c, const char *function, const State *x);

/* Evaluates the outputs where they do not fit the inputs. Changes no memory of the block. */
fmi2Status make_outputs_fresh(Instance *c, const char *function);

#if defined(__ELF__)
#pragma GCC visibility pop
#endif

#endif
