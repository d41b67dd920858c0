/* The step loop of master.py in C, for blocks whose FMI functions can be called through pointers.
 *
 * master.py's loop is the readable one; this does the same calls in the same order on the same arrays, so that
 * both give the same bits. compiled.py fills the structures. Nothing is allocated here and nothing is kept. */
#include <stddef.h>
#include <stdint.h>

#include "fmi2.h"

/* fmi2Get<Type> or fmi2Set<Type>; which type, and whether the values are const, makes no difference to the call. */
typedef fmi2Status ExchangeFunction(fmi2Component, const fmi2ValueReference[], size_t, void *);
typedef fmi2Status StepFunction(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);

/* One such call: Reals are exchanged in place, other types through `whole`. */
typedef struct {
    ExchangeFunction *function;
    const fmi2ValueReference *references;
    double *values;
    int32_t *whole; /* NULL for Reals */
    size_t all;     /* how many values, */
    size_t live;    /* and how many of them, the first, others need in every step */
} Exchange;

typedef struct {
    fmi2Component component;
    StepFunction *do_step;
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
} Seat;

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
    const int64_t *watched; /* what is kept after every base step, */
    size_t watched_count;
    double *watched_rows;  /* and where: */
    int64_t watched_first; /* the base step of the first row */
    double numerator;      /* of the base step, s */
    double denominator;
    /* where the loop stopped */
    int64_t count; /* whole base steps done */
    int64_t begun; /* the step in which a call failed began here */
    int32_t seat;
    int32_t call; /* one of Call, */
    int32_t part; /* and which of the setters or getters */
    int32_t status;
} Loop;

enum Call { CALL_SET, CALL_STEP, CALL_GET, CALL_CHECK };

static int stop(Loop *loop, size_t seat, enum Call call, size_t part, fmi2Status status, int64_t begun)
{
    loop->seat = (int32_t)seat;
    loop->call = (int32_t)call;
    loop->part = (int32_t)part;
    loop->status = (int32_t)status;
    loop->begun = begun;
    return 1;
}

static int set_inputs(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    for (size_t i = 0; i < seat->input_count; i++) {
        const double value = loop->bus[seat->sources[i]];
        seat->inputs[i] = seat->factors == NULL ? value : value * seat->factors[i] + seat->offsets[i];
    }
    for (size_t k = 0; k < seat->setter_count; k++) {
        const Exchange *setter = &seat->setters[k];
        if (setter->whole != NULL) {
            for (size_t i = 0; i < setter->all; i++) {
                setter->whole[i] = (int32_t)setter->values[i];
            }
        }
        void *values = setter->whole != NULL ? (void *)setter->whole : (void *)setter->values;
        const fmi2Status status = setter->function(seat->component, setter->references, setter->all, values);
        if (status > fmi2Warning) {
            return stop(loop, index, CALL_SET, k, status, begun);
        }
    }
    return 0;
}

static int do_step(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    const double time = (double)begun * loop->numerator / loop->denominator;
    const fmi2Status status = seat->do_step(seat->component, time, seat->step, fmi2True);
    return status > fmi2Warning ? stop(loop, index, CALL_STEP, 0, status, begun) : 0;
}

static int get_outputs(Loop *loop, size_t index, int64_t begun, int all)
{
    const Seat *seat = &loop->seats[index];
    for (size_t k = 0; k < seat->getter_count; k++) {
        const Exchange *getter = &seat->getters[k];
        const size_t n = all ? getter->all : getter->live;
        if (n == 0) {
            continue;
        }
        void *values = getter->whole != NULL ? (void *)getter->whole : (void *)getter->values;
        const fmi2Status status = getter->function(seat->component, getter->references, n, values);
        if (status > fmi2Warning) {
            return stop(loop, index, CALL_GET, k, status, begun);
        }
        if (getter->whole != NULL) {
            for (size_t i = 0; i < n; i++) {
                getter->values[i] = (double)getter->whole[i];
            }
        }
    }
    return 0;
}

static int check(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    for (size_t i = 0; i < seat->output_count; i++) {
        const double difference = seat->outputs[i] - seat->outputs[i];
        if (!(difference == 0.0)) {
            return stop(loop, index, CALL_CHECK, i, fmi2OK, begun);
        }
    }
    return 0;
}

static int sequential_step(Loop *loop, int64_t count)
{
    const int recorded = count % loop->interval == 0;
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (count % every != 0) {
            continue;
        }
        const int64_t begun = count - every;
        if (set_inputs(loop, i, begun) || do_step(loop, i, begun) || get_outputs(loop, i, begun, recorded || every > 1) ||
            check(loop, i, begun)) {
            return 1;
        }
    }
    return 0;
}

static int parallel_step(Loop *loop, int64_t count)
{
    const int recorded = count % loop->interval == 0;
    for (size_t i = 0; i < loop->seat_count; i++) {
        if (count % loop->seats[i].every == 0 && set_inputs(loop, i, count - 1)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (count % every == 0 && do_step(loop, i, count - every)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (count % every == 0 && get_outputs(loop, i, count - every, recorded || every > 1)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        if (count % loop->seats[i].every == 0 && check(loop, i, count - 1)) {
            return 1;
        }
    }
    return 0;
}

/* Runs from loop->count to `until` base steps. Returns 0, or 1 with where a call failed or an output is not finite. */
#if defined(_WIN32)
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
int run_loop(Loop *loop, int64_t until)
{
    while (loop->count < until) {
        const int64_t count = loop->count + 1;
        for (size_t i = 0; i < loop->delayed_count; i++) {
            loop->held[i] = loop->bus[loop->delayed[i]];
        }
        if (loop->parallel ? parallel_step(loop, count) : sequential_step(loop, count)) {
            return 1;
        }
        loop->count = count;
        if (count % loop->interval == 0) {
            double *row = loop->rows + (size_t)(count / loop->interval) * loop->column_count;
            for (size_t i = 0; i < loop->column_count; i++) {
                row[i] = loop->bus[loop->columns[i]];
            }
        }
        double *watched = loop->watched_rows + (size_t)(count - loop->watched_first) * loop->watched_count;
        for (size_t i = 0; i < loop->watched_count; i++) {
            watched[i] = loop->bus[loop->watched[i]];
        }
    }
    return 0;
}
