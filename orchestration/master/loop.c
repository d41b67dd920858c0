/* The step loop of master.py in C, for blocks whose FMI functions can be called through pointers.
 *
 * master.py's loop is the readable one; this does the same calls in the same order on the same arrays, so that
 * both give the same bits. compiled.py fills the structures. Nothing is allocated here and nothing is kept.
 *
 * Longer than 250 lines: both exchanges and the faults of inputs share what is static here. */
#include "loop.h"

#include <string.h>

/* The types of C in which FMI exchanges numbers, in the order of CODES in types.py. */
#define TYPES(X)                                                                                                       \
    X(FLOAT64, double)                                                                                                 \
    X(FLOAT32, float)                                                                                                  \
    X(INT8, int8_t)                                                                                                    \
    X(UINT8, uint8_t)                                                                                                  \
    X(INT16, int16_t)                                                                                                  \
    X(UINT16, uint16_t)                                                                                                \
    X(INT32, int32_t)                                                                                                  \
    X(UINT32, uint32_t)                                                                                                \
    X(INT64, int64_t)                                                                                                  \
    X(UINT64, uint64_t)                                                                                                \
    X(BOOLEAN, bool)
#define NAME(name, ctype) name,
enum Type { TYPES(NAME) };

/* Into FMI's buffer. Returns 0, or 1 where the type cannot hold a value. */
static int store(const Exchange *it)
{
    for (size_t i = 0; i < it->all.elements; i++) {
        const double value = it->values[it->places[i]];
        if (!(value >= it->low && value < it->beyond)) {
            return 1;
        }
    }
#define STORE(name, ctype)                                                                                             \
    case name:                                                                                                         \
        for (size_t i = 0; i < it->all.elements; i++) {                                                                \
            ((ctype *)it->buffer)[it->slots[i]] = (ctype)it->values[it->places[i]];                                    \
        }                                                                                                              \
        break;
    switch ((enum Type)it->type) {
        TYPES(STORE)
    }
    return 0;
}

/* Out of FMI's buffer. */
static void fetch(const Exchange *it, size_t count)
{
#define FETCH(name, ctype)                                                                                             \
    case name:                                                                                                         \
        for (size_t i = 0; i < count; i++) {                                                                           \
            it->values[it->places[i]] = (double)((const ctype *)it->buffer)[it->slots[i]];                             \
        }                                                                                                              \
        break;
    switch ((enum Type)it->type) {
        TYPES(FETCH)
    }
}

static int exchange(const Seat *seat, const Exchange *it, const Part *part)
{
    if (seat->version == 2) {
        return (int)it->function.two(seat->component, it->references, part->references, it->buffer);
    }
    return it->function.three(seat->component, it->references, part->references, it->buffer, part->values);
}

int set_values(const Seat *seat, const Exchange *it)
{
    return it->places != NULL && store(it) ? BEYOND : exchange(seat, it, &it->all);
}

int get_values(const Seat *seat, const Exchange *it, const Part *part)
{
    const int status = exchange(seat, it, part);
    if (status <= WARNING && it->places != NULL) {
        fetch(it, part->elements);
    }
    return status;
}

double disturbed(const Disturbance *fault, double value)
{
    return fault->kind == FAULT_CUT ? fault->value : fault->kind == FAULT_BIAS ? value + fault->value : value;
}

/* The inputs of a seat as its faults leave them. */
static void disturb(Loop *loop, size_t index)
{
    for (size_t i = 0; i < loop->disturbance_count; i++) {
        Disturbance *fault = &loop->disturbances[i];
        const int64_t now = loop->count + 1 - fault->behind;
        if ((size_t)fault->seat != index || !fault->acts || now < fault->first || now >= fault->last) {
            continue;
        }
        double *value = &loop->seats[index].inputs[fault->place];
        if (fault->kind == FAULT_FREEZE && !fault->held) {
            fault->frozen = *value;
            fault->held = 1;
        }
        *value = fault->kind == FAULT_FREEZE ? fault->frozen : disturbed(fault, *value);
    }
}

static int stop(Loop *loop, size_t seat, enum Call call, size_t part, int status, int64_t begun)
{
    loop->seat = (int32_t)seat;
    loop->call = (int32_t)call;
    loop->part = (int32_t)part;
    loop->status = status;
    loop->begun = begun;
    return 1;
}

static int set_inputs(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    for (size_t i = 0; i < seat->input_count; i++) {
        seat->inputs[i] = loop->bus[seat->sources[i]];
    }
    for (size_t i = 0; seat->factors != NULL && i < seat->input_count; i++) {
        seat->inputs[i] = seat->inputs[i] * seat->factors[i] + seat->offsets[i];
    }
    disturb(loop, index);
    for (size_t k = 0; k < seat->setter_count; k++) {
        const int status = set_values(seat, &seat->setters[k]);
        if (status > WARNING || status == BEYOND) {
            return stop(loop, index, CALL_SET, k, status, begun);
        }
    }
    return 0;
}

static int do_step(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    const double time = (double)begun * loop->numerator / loop->denominator;
    int status;
    if (seat->version == 2) {
        status = (int)seat->do_step.two(seat->component, time, seat->step, fmi2True);
    } else {
        bool event = false, end = false, early = false;
        double last = time;
        status = seat->do_step.three(seat->component, time, seat->step, true, &event, &end, &early, &last);
        if (status <= WARNING && (event || end || early)) {
            return stop(loop, index, CALL_STEP, 0, -(event + 2 * end + 4 * early), begun);
        }
    }
    return status > WARNING ? stop(loop, index, CALL_STEP, 0, status, begun) : 0;
}

static int get_outputs(Loop *loop, size_t index, int64_t begun, int all)
{
    const Seat *seat = &loop->seats[index];
    for (size_t k = 0; k < seat->getter_count; k++) {
        const Exchange *getter = &seat->getters[k];
        const Part *part = all ? &getter->all : &getter->live;
        if (part->references == 0) {
            continue;
        }
        const int status = get_values(seat, getter, part);
        if (status > WARNING) {
            return stop(loop, index, CALL_GET, k, status, begun);
        }
    }
    return 0;
}

/* A call of a seat; what a guest may change for the others is looked at behind it. */
static int make(Loop *loop, size_t index, enum Call call, int64_t begun, int all)
{
    Guest *guest = loop->seats[index].guest;
    if (guest != NULL) {
        guest->begun = begun;
        guest->active = call + 1;
    }
    const int failed = call == CALL_SET    ? set_inputs(loop, index, begun)
                       : call == CALL_STEP ? do_step(loop, index, begun)
                                           : get_outputs(loop, index, begun, all);
    if (guest != NULL) {
        guest->active = 0;
        if (guest->get_round != NULL && guest->get_round() != guest->mode) {
            guest->set_round(guest->mode);
            guest->turned[call] = 1;
        }
    }
    return failed;
}

static int check(Loop *loop, size_t index, int64_t begun)
{
    const Seat *seat = &loop->seats[index];
    uint64_t sum = 0; /* of the bits of x - x, which has none where x is finite: so no value decides on a branch */
    for (size_t i = 0; i < seat->output_count; i++) {
        const double difference = seat->outputs[i] - seat->outputs[i];
        uint64_t bits;
        memcpy(&bits, &difference, sizeof bits);
        sum |= bits;
    }
    return sum == 0 ? 0 : stop(loop, index, CALL_CHECK, 0, 0, begun);
}

/* Whether a seat's step ends at this base step. A division takes as long as the rest of the loop's work on a seat. */
static int due(const Loop *loop, size_t index, int64_t count)
{
    const int64_t every = loop->seats[index].every;
    return every == 1 || count % every == 0;
}

static int sequential_step(Loop *loop, int64_t count, int recorded)
{
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (!due(loop, i, count)) {
            continue;
        }
        const int64_t begun = count - every;
        if (make(loop, i, CALL_SET, begun, 0) || make(loop, i, CALL_STEP, begun, 0) ||
            make(loop, i, CALL_GET, begun, recorded || every > 1) || check(loop, i, begun)) {
            return 1;
        }
    }
    return 0;
}

static int parallel_step(Loop *loop, int64_t count, int recorded)
{
    for (size_t i = 0; i < loop->seat_count; i++) {
        if (due(loop, i, count) && make(loop, i, CALL_SET, count - 1, 0)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (due(loop, i, count) && make(loop, i, CALL_STEP, count - every, 0)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        const int64_t every = loop->seats[i].every;
        if (due(loop, i, count) && make(loop, i, CALL_GET, count - every, recorded || every > 1)) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop->seat_count; i++) {
        if (due(loop, i, count) && check(loop, i, count - 1)) {
            return 1;
        }
    }
    return 0;
}

int run_loop(Loop *loop, int64_t until)
{
    while (loop->count < until) {
        const int64_t count = loop->count + 1;
        for (size_t i = 0; i < loop->delayed_count; i++) {
            loop->held[i] = loop->bus[loop->delayed[i]];
        }
        const int recorded = count % loop->interval == 0;
        if (loop->parallel ? parallel_step(loop, count, recorded) : sequential_step(loop, count, recorded)) {
            return 1;
        }
        loop->count = count;
        if (recorded) {
            double *row = loop->rows + (size_t)(count / loop->interval) * loop->column_count;
            for (size_t i = 0; i < loop->column_count; i++) {
                row[i] = loop->bus[loop->columns[i]];
            }
        }
        double *observed = loop->observed_rows + (size_t)(count - loop->observed_first) * loop->observed_count;
        for (size_t i = 0; i < loop->observed_count; i++) {
            observed[i] = loop->bus[loop->observed[i]];
        }
    }
    return 0;
}
