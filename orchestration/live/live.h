/* What tables.py writes of a scenario: its instances, their start values, and how values pass at t = 0. */
#ifndef LIVE_H
#define LIVE_H

#include "loop.h"

/* One Get or Set of one seat. */
typedef struct {
    size_t seat;
    Exchange exchange;
} Move;

/* Start values that are text. */
typedef struct {
    size_t seat;
    const uint32_t *references;
    size_t count;
    const fmi2String *values;
} Texts;

/* From a place on the bus to one among the inputs of a seat. */
typedef struct {
    size_t source;
    size_t seat;
    size_t place;
    double factor;
    double offset;
} Feed;

/* Outputs that depend on no later one, and the inputs that they feed. */
typedef struct {
    const Move *gets;
    size_t get_count;
    const Feed *feeds;
    size_t feed_count;
    const Move *sets;
    size_t set_count;
} Level;

/* The begin or the end of a fault that sets values, or values of the timeline, which lie below those of faults. Its element
 * i is number elements[i] of those that are set. */
typedef struct {
    int64_t count; /* of base steps, from which on it is made between two steps of its block */
    int64_t every; /* the base steps of one of these */
    enum { BEGIN, END, GIVE } kind;
    size_t setting; /* which begins or ends */
    size_t fault;
    size_t seat;
    const size_t *elements;
    const double *values;
    size_t value_count;
    const Exchange *gets; /* into element_before */
    size_t get_count;
    const Exchange *sets; /* from element_given */
    size_t set_count;
} Change;

/* FMI's functions that the step loop does not call. */
typedef struct {
    fmi2String name;
    fmi2String guid;
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                                 fmi2Boolean, fmi2Boolean);
    fmi2Status (*setup)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    fmi2Status (*enter)(fmi2Component);
    fmi2Status (*leave)(fmi2Component);
    fmi2Status (*set_string)(fmi2Component, const fmi2ValueReference[], size_t, const fmi2String[]);
} Instance;

/* The functions of a block in this module, as wasm.py names them. */
#define EXCHANGES(block, verb, type, values)                                                                           \
    fmi2Status block##_fmi2##verb##type(fmi2Component, const fmi2ValueReference[], size_t, values);
#define BLOCK(block)                                                                                                   \
    fmi2Component block##_fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, \
                                          fmi2Boolean, fmi2Boolean);                                                   \
    fmi2Status block##_fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);     \
    fmi2Status block##_fmi2EnterInitializationMode(fmi2Component);                                                     \
    fmi2Status block##_fmi2ExitInitializationMode(fmi2Component);                                                      \
    fmi2Status block##_fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);                                     \
    EXCHANGES(block, Get, Real, fmi2Real[])                                                                            \
    EXCHANGES(block, Set, Real, const fmi2Real[])                                                                      \
    EXCHANGES(block, Get, Integer, fmi2Integer[])                                                                      \
    EXCHANGES(block, Set, Integer, const fmi2Integer[])                                                                \
    EXCHANGES(block, Get, Boolean, fmi2Boolean[])                                                                      \
    EXCHANGES(block, Set, Boolean, const fmi2Boolean[])                                                                \
    EXCHANGES(block, Set, String, const fmi2String[])

extern const Instance instances[];
extern Seat seats[];
extern Loop loop;
extern const int64_t steps;
extern const size_t bus_size;
extern const Move starts[];
extern const size_t start_count;
extern const Texts texts[];
extern const size_t text_count;
extern const Level levels[];
extern const size_t level_count;
extern const Change changes[];
extern const size_t change_count;
extern double element_before[]; /* of each element that faults set: as it stands before a change, */
extern double element_sound[];  /* as it stands without a fault, */
extern double element_given[];  /* and what it is set to */
extern double start_values[];
extern size_t change_order[];    /* the changes in the order in which they are made */
extern int32_t acting[];         /* of each fault, whether it is injected; behind them the timeline, which is */
extern int32_t shifted[];        /* and by how many base steps later than the scenario has it */
extern const size_t fault_of[];  /* of each disturbance, */
extern const int64_t spans[][2]; /* and its first and last in the scenario */

/* Whether a call to a seat failed by its status, and a message of it. */
int failed(size_t seat, int status);

/* Brings the changes into the order of their times. */
void order_changes(void);

/* Once how many base steps are done the change in this place of the order is made. */
int64_t due(size_t place);

/* Makes the change in this place where its fault is injected. Returns 0, or 1 with a message. */
int make_change(size_t place);

#endif
