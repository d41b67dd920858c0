/* A run in a page: initialization as in master.py, then the loop of loop.c with the faults that set values.
 *
 * The page calls the exported functions: it writes start values and faults, then `begin`, then `advance` up to the end.
 *
 * Longer than 250 lines: what the page calls and what initialization calls in turn share what is static here. */
#include "live.h"

#include <math.h>
#include <string.h>

#define EXPORT(name) __attribute__((export_name(#name)))
enum { PAGE = 65536, TEXT_SIZE = 640 };

extern unsigned char __heap_base;
static size_t next_free;
static size_t next_change;
static char message[TEXT_SIZE];

static void *allocate(size_t count, size_t size)
{
    const size_t bytes = (count * size + 15u) / 16u * 16u, end = next_free + bytes;
    const size_t now = __builtin_wasm_memory_size(0) * PAGE;
    if (end > now && __builtin_wasm_memory_grow(0, (end - now + PAGE - 1) / PAGE) == (size_t)-1) {
        return NULL;
    }
    void *memory = (void *)next_free;
    memset(memory, 0, bytes);
    next_free = end;
    return memory;
}

static void release(void *memory)
{
    (void)memory;
}

static void put(const char *text)
{
    const size_t n = strlen(message), room = sizeof message - 1 - n, m = strlen(text);
    memcpy(message + n, text, m < room ? m : room);
}

/* Keeps the last message that is none of an event. */
static void logger(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                   fmi2String text, ...)
{
    (void)environment, (void)category;
    if (status > fmi2OK) {
        memset(message, 0, sizeof message);
        put(instance);
        put(": ");
        put(text);
    }
}

static const fmi2CallbackFunctions callbacks = {logger, allocate, release, NULL, NULL};

int failed(size_t seat, int status)
{
    if (message[0] == '\0' && (status > WARNING || status == BEYOND)) {
        put(instances[seat].name);
        put(status == BEYOND ? ": was given a value that its type cannot hold" : ": failed");
    }
    return status > WARNING || status == BEYOND;
}

EXPORT(starts) double *start_place(void)
{
    return start_values;
}

EXPORT(faults) int32_t *fault_place(void)
{
    return acting;
}

EXPORT(shifts) int32_t *shift_place(void)
{
    return shifted;
}

EXPORT(observed) double *observed_place(void)
{
    return loop.observed_rows;
}

EXPORT(rows) double *row_place(void)
{
    return loop.rows;
}

EXPORT(message) const char *message_place(void)
{
    return message;
}

EXPORT(done) double steps_done(void)
{
    return (double)loop.count;
}

static int set_starts(void)
{
    for (size_t i = 0; i < start_count; i++) {
        if (failed(starts[i].seat, set_values(&seats[starts[i].seat], &starts[i].exchange))) {
            return 1;
        }
    }
    for (size_t i = 0; i < text_count; i++) {
        const Texts *it = &texts[i];
        if (failed(it->seat, (int)instances[it->seat].set_string(seats[it->seat].component, it->references, it->count,
                                                                 it->values))) {
            return 1;
        }
    }
    return 0;
}

/* What an input is given at t = 0. */
static double at_start(const Feed *feed)
{
    double value = feed->factor * loop.bus[feed->source] + feed->offset;
    for (size_t i = 0; i < loop.disturbance_count; i++) {
        const Disturbance *fault = &loop.disturbances[i];
        if (fault->acts && (size_t)fault->seat == feed->seat && (size_t)fault->place == feed->place &&
            fault->first == 0) {
            value = disturbed(fault, value);
        }
    }
    return value;
}

static int pass_values(const Level *level)
{
    for (size_t i = 0; i < level->get_count; i++) {
        const Move *get = &level->gets[i];
        if (failed(get->seat, get_values(&seats[get->seat], &get->exchange, &get->exchange.all))) {
            return 1;
        }
    }
    for (size_t i = 0; i < level->feed_count; i++) {
        const Feed *feed = &level->feeds[i];
        seats[feed->seat].inputs[feed->place] = at_start(feed);
    }
    for (size_t i = 0; i < level->set_count; i++) {
        const Move *set = &level->sets[i];
        if (failed(set->seat, set_values(&seats[set->seat], &set->exchange))) {
            return 1;
        }
    }
    return 0;
}

/* All outputs as they stand, into a row. */
static int record(size_t row)
{
    for (size_t i = 0; i < loop.seat_count; i++) {
        for (size_t k = 0; k < seats[i].getter_count; k++) {
            if (failed(i, get_values(&seats[i], &seats[i].getters[k], &seats[i].getters[k].all))) {
                return 1;
            }
        }
    }
    for (size_t i = 0; i < loop.column_count; i++) {
        loop.rows[row * loop.column_count + i] = loop.bus[loop.columns[i]];
    }
    return 0;
}

static int initialize(double stop)
{
    for (size_t i = 0; i < loop.seat_count; i++) {
        const Instance *it = &instances[i];
        seats[i].component =
            it->instantiate(it->name, fmi2CoSimulation, it->guid, "", &callbacks, fmi2False, fmi2False);
        if (seats[i].component == NULL) {
            return failed(i, fmi2Error);
        }
    }
    if (set_starts()) {
        return 1;
    }
    for (size_t i = 0; i < loop.seat_count; i++) {
        const Instance *it = &instances[i];
        if (failed(i, (int)it->setup(seats[i].component, fmi2False, 0.0, 0.0, fmi2True, stop)) ||
            failed(i, (int)it->enter(seats[i].component))) {
            return 1;
        }
    }
    for (size_t i = 0; i < level_count; i++) {
        if (pass_values(&levels[i])) {
            return 1;
        }
    }
    for (size_t i = 0; i < loop.seat_count; i++) {
        if (failed(i, (int)instances[i].leave(seats[i].component))) {
            return 1;
        }
    }
    const int bad = record(0);
    for (size_t i = 0; i < loop.observed_count; i++) {
        loop.observed_rows[i] = loop.bus[loop.observed[i]];
    }
    return bad;
}

/* Makes new instances and the values at t = 0, in the first row. Returns 0, or 1 with a message. */
EXPORT(begin) int begin(void)
{
    next_free = ((size_t)&__heap_base + 15u) / 16u * 16u;
    next_change = 0;
    memset(message, 0, sizeof message);
    memset(loop.bus, 0, bus_size * sizeof loop.bus[0]);
    loop.count = 0;
    for (size_t i = 0; i < loop.disturbance_count; i++) {
        Disturbance *it = &loop.disturbances[i];
        it->acts = acting[fault_of[i]];
        it->held = 0;
        it->first = spans[i][0] + shifted[fault_of[i]];
        it->last = spans[i][1] == INT64_MAX ? INT64_MAX : spans[i][1] + shifted[fault_of[i]];
    }
    order_changes();
    loop.rows = allocate((size_t)(steps / loop.interval) + 2, loop.column_count * sizeof(double));
    if (loop.rows == NULL) {
        put("the recording takes more memory than this browser gives");
        return 1;
    }
    return initialize((double)steps * loop.numerator / loop.denominator);
}

/* Runs up to so many base steps, at most OBSERVED more; what is observed after each lies in the rows for it from the first
 * on. Returns 0, or 1 with a message. */
EXPORT(advance) int advance(double until)
{
    const int64_t end = (int64_t)until < steps ? (int64_t)until : steps;
    loop.observed_first = loop.count + 1;
    while (loop.count < end) {
        int64_t stretch = end;
        for (; next_change < change_count && due(next_change) <= loop.count; next_change++) {
            if (make_change(next_change)) {
                return 1;
            }
        }
        if (next_change < change_count && due(next_change) < end) {
            stretch = due(next_change);
        }
        if (run_loop(&loop, stretch)) {
            if (message[0] == '\0') {
                put(instances[loop.seat].name);
                put(loop.call == CALL_CHECK ? ": an output is not finite" : ": a call failed");
            }
            return 1;
        }
    }
    const int between = end == steps && steps % loop.interval != 0; /* the run ends between two samples */
    return between ? record((size_t)(steps / loop.interval) + 1) : 0;
}
