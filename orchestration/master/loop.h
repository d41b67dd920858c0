/* The structures of the step loop in C: what an instance is asked, in which order, and where the values lie.
 *
 * compiled.py fills them for the loop in this process, and a live page has them as tables. */
#ifndef LOOP_H
#define LOOP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fmi2.h"

/* FMI's functions in its versions 2 and 3. Which type a Get or Set exchanges, and whether the values are const, makes no
 * difference to the call; in FMI 3.0 it is told how many values there are, since one reference may be that of an array. */
typedef union {
    fmi2Status (*two)(fmi2Component, const fmi2ValueReference[], size_t, void *);
    int (*three)(void *, const uint32_t[], size_t, void *, size_t);
} ExchangeFunction;
typedef union {
    fmi2Status (*two)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    int (*three)(void *, double, double, bool, bool *, bool *, bool *, double *);
} StepFunction;

/* How much of an exchange is made, counted from its first. */
typedef struct {
    size_t references;
    size_t values; /* in FMI's buffer */
    size_t elements;
} Part;

/* One Get or Set. Element i lies at values[places[i]] and, as a number of `type`, at slot slots[i] of FMI's buffer. */
typedef struct {
    ExchangeFunction function;
    const uint32_t *references;
    double *values;
    const int64_t *places; /* NULL where FMI reads or writes the values themselves */
    const int64_t *slots;
    void *buffer;
    double low;    /* a number of the type is at least this */
    double beyond; /* and below this */
    Part live;     /* what others need in every step */
    Part all;
    int32_t type; /* one of Type */
} Exchange;

/* An FMU of others in this process: where it is, for who waits for the process; and the rounding mode, which it must leave. */
typedef struct {
    int64_t begun;  /* the step that runs began at this count of base steps */
    int64_t active; /* the call that runs, from 1 on as in Call; 0 between two */
    int (*get_round)(void);
    int (*set_round)(int);
    int32_t mode;      /* that is kept */
    int32_t turned[3]; /* whether a call of this kind has left another */
} Guest;

typedef struct {
    fmi2Component component;
    StepFunction do_step;
    int32_t version; /* of FMI: 2 or 3 */
    int64_t every;
    double step;
    const int64_t *sources; /* where its inputs lie on the bus */
    const double *factors;  /* NULL where no unit changes */
    const double *offsets;
    double *inputs;
    size_t input_count;
    const Exchange *setters;
    size_t setter_count;
    const Exchange *getters;
    size_t getter_count;
    const double *outputs; /* its stretch of the bus */
    size_t output_count;
    Guest *guest; /* NULL for an FMU of this project */
} Seat;

/* A fault of one input: what a receiver is given, as injection.py has it. */
typedef struct {
    int64_t first; /* the counts of base steps at which it acts first, */
    int64_t last;  /* and no more */
    int64_t behind;
    double value; /* what is added or given instead */
    double frozen;
    int32_t seat;
    int32_t place; /* among the inputs of its seat */
    int32_t kind;  /* one of Kind of fault */
    int32_t acts;  /* whether it is injected at all */
    int32_t held;  /* whether frozen is known */
} Disturbance;
enum { FAULT_CUT, FAULT_BIAS, FAULT_FREEZE };

typedef struct {
    const Seat *seats;
    size_t seat_count;
    int32_t parallel;
    double *bus;
    const int64_t *delayed; /* what is kept of the step before, and where */
    double *held;
    size_t delayed_count;
    const int64_t *columns;
    size_t column_count;
    double *rows;
    int64_t interval;
    const int64_t *observed; /* what is kept after every base step, */
    size_t observed_count;
    double *observed_rows;  /* and where: */
    int64_t observed_first; /* the base step of the first row */
    double numerator;       /* of the base step, s */
    double denominator;
    Disturbance *disturbances;
    size_t disturbance_count;
    /* where the loop stopped */
    int64_t count; /* whole base steps done */
    int64_t begun; /* the step in which a call failed began here */
    int32_t seat;
    int32_t call; /* one of Call, */
    int32_t part; /* and which of the setters or getters */
    int32_t status;
} Loop;

enum Call { CALL_SET, CALL_STEP, CALL_GET, CALL_CHECK };
enum { WARNING = 1, BEYOND = -8 }; /* the last status that is no failure; what stands in place of one, as in calls.py */

/* One Set of what lies at its values. Returns the status, or BEYOND where the type cannot hold a value. */
int set_values(const Seat *seat, const Exchange *it);

/* One Get of a part, into its values. Returns the status. */
int get_values(const Seat *seat, const Exchange *it, const Part *part);

/* What is given instead of a value. */
double disturbed(const Disturbance *fault, double value);

/* Runs from loop->count to `until` base steps. Returns 0, or 1 with where a call failed or an output is not finite. */
#if defined(_WIN32)
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
int run_loop(Loop *loop, int64_t until);

#endif
