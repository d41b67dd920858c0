/* A container: FMUs that stand in its resources, which it steps as the scenario does. The host sees one FMU.
 *
 * It makes as many steps of the scenario as end with the host's step or before; a host may ask for any step. Inside,
 * time begins at 0, wherever that of the host does.
 *
 * Longer than 250 lines: these are all functions of FMI 2.0 that a host calls, in the order of its calls. */
#include <math.h>
#include <string.h>

#include "container.h"

enum { SETUP = 1, INITIALIZATION = 2, STEP = 4, FAILED = 8, TERMINATED = 16 };

/* Whether the mode is one of `modes`; else the host is told, and *status is an error. */
static bool may(const Container *c, unsigned modes, const char *function, fmi2Status *status)
{
    static const char *const now[] = {"before fmi2EnterInitializationMode", "in initialization mode", "in step mode",
                                      "after an error", "after fmi2Terminate"};
    *status = fmi2OK;
    if ((modes & (1u << c->kept.mode)) == 0u) {
        *status = REFUSE(c, function, ": not allowed ", now[c->kept.mode]);
    }
    return *status == fmi2OK;
}

/* The same of all, in their order, up to the first that fails; `all`: the others, too. */
static fmi2Status each(Container *c, size_t function, const char *name, bool all)
{
    fmi2Status status = fmi2OK;
    for (uint32_t i = 0; i < c->head.blocks && (all || status == fmi2OK); ++i) {
        Inner *inner = &c->inner[i];
        Plain call;
        memcpy(&call, (char *)inner + function, sizeof call);
        const fmi2Status now = inner->lost    ? fmi2Fatal
                               : call == NULL ? REFUSE(c, "fmi2Reset: a library inside lacks it")
                                              : inner_done(inner, call(inner->instance), name);
        status = now > status ? now : status;
    }
    c->kept.mode = status == fmi2OK ? c->kept.mode : MODE_FAILED;
    return status;
}
#define EACH(C, FIELD, NAME, ALL) each(C, offsetof(Inner, FIELD), NAME, ALL)

static fmi2Status set_starts(Container *c)
{
    fmi2Status status = fmi2OK;
    for (uint32_t i = 0; i < c->head.starts && status == fmi2OK; ++i) {
        const StartRow *row = &c->starts[i];
        fmi2String text = c->text + row->text;
        Inner *inner = &c->inner[row->block];
        status = row->kind == KIND_STRING ? inner_access(inner, true, KIND_STRING, &row->reference, 1, &text)
                                          : inner_set(inner, row->kind, row->reference, row->value);
    }
    return status;
}

static void release(Container *c)
{
    for (uint32_t i = 0; c->inner != NULL && i < c->head.blocks; ++i) {
        inner_close(&c->inner[i]);
    }
    while (c->taken != NULL) {
        void *const piece = c->taken;
        memcpy(&c->taken, piece, sizeof c->taken);
        c->host.calls.freeMemory(piece);
    }
    c->host.calls.freeMemory(c);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean log)
{
    Container *c = host_instance(sizeof *c, name, type, guid, resources, calls);
    if (c == NULL) {
        return NULL;
    }
    const char *reason;
    bool good = table_open(c, resources, guid, &reason);
    if (!good) {
        (void)REFUSE(c, reason);
    }
    c->inner = good ? container_take(c, c->head.blocks, sizeof *c->inner) : NULL;
    good = c->inner != NULL;
    for (uint32_t i = 0; good && i < c->head.blocks; ++i) {
        c->inner[i].container = c;
        good = inner_open(&c->inner[i], &c->blocks[i], resources, visible, log);
    }
    if (good && !table_lay_out(c)) {
        (void)REFUSE(c, "fmi2Instantiate: no memory, or a library inside lacks a function");
        good = false;
    }
    if (!good || set_starts(c) != fmi2OK) {
        release(c);
        return NULL;
    }
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    if (component != NULL) {
        release(component);
    }
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    Container *c = component;
    bool events = n == 0;
    fmi2Status status = fmi2OK;
    for (size_t i = 0; categories != NULL && i < n; ++i) {
        events = events || (categories[i] != NULL && strcmp(categories[i], "logAll") == 0);
    }
    for (uint32_t i = 0; events && i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = &c->inner[i];
        if (inner->debug != NULL && !inner->lost) {
            status = inner_done(inner, inner->debug(inner->instance, on, 0, NULL), "fmi2SetDebugLogging");
        }
    }
    return status;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    Container *c = component;
    fmi2Status status;
    if (!may(c, SETUP, "fmi2SetupExperiment", &status)) {
        return status;
    }
    if (!isfinite(start)) {
        return REFUSE(c, "fmi2SetupExperiment: startTime: expected a finite number");
    }
    c->kept.begin = c->kept.time = start;
    for (uint32_t i = 0; i < c->head.blocks && status == fmi2OK; ++i) {
        Inner *inner = &c->inner[i];
        const fmi2Status now =
            inner->setup(inner->instance, tolerance_defined, tolerance, 0.0, stop_defined, stop - start);
        status = inner_done(inner, now, "fmi2SetupExperiment");
    }
    return status;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    Container *c = component;
    fmi2Status status;
    if (may(c, SETUP, "fmi2EnterInitializationMode", &status)) {
        c->kept.mode = MODE_INITIALIZATION;
        status = EACH(c, enter, "fmi2EnterInitializationMode", false);
    }
    return status;
}

fmi2Status container_pass_on(Container *c)
{
    fmi2Status status = fmi2OK;
    for (uint32_t i = 0; i < c->head.initial && status == fmi2OK && !c->kept.passed_on; ++i) {
        const InputRow *to = &c->inputs[c->initial[i]];
        const End *from = &c->outputs[to->end.place];
        double value;
        status = inner_get(&c->inner[from->block], from->kind, from->reference, &value);
        if (status == fmi2OK) {
            status =
                inner_set(&c->inner[to->end.block], to->end.kind, to->end.reference, to->factor * value + to->offset);
        }
    }
    c->kept.passed_on = status == fmi2OK;
    return status;
}

/* Whether the first `count` outputs from this place of the bus on are finite; the host is told of one that is not. */
static fmi2Status check_bus(const Container *c, size_t first, size_t count)
{
    for (size_t i = first; i < first + count; ++i) {
        if (!isfinite(c->bus[i])) {
            return REFUSE(c, c->inner[c->outputs[i].block].name, ".", c->text + c->outputs[i].place,
                          ": expected a finite number, found another");
        }
    }
    return fmi2OK;
}

/* What loop.c says of where it stopped. */
static fmi2Status stopped(Container *c)
{
    const Loop *loop = &c->loop;
    const Seat *seat = &loop->seats[loop->seat];
    Inner *inner = &c->inner[loop->seat];
    c->kept.mode = MODE_FAILED;
    if (loop->call == CALL_STEP) {
        return inner_done(inner, (fmi2Status)loop->status, "fmi2DoStep");
    }
    if (loop->call == CALL_CHECK) {
        return check_bus(c, (size_t)(seat->outputs - c->bus), seat->output_count);
    }
    const bool sets = loop->call == CALL_SET;
    const Exchange *it = sets ? &seat->setters[loop->part] : &seat->getters[loop->part];
    const Access *functions = sets ? inner->set : inner->get;
    uint32_t kind = KIND_REAL;
    while (kind < KIND_BOOLEAN && memcmp(&functions[kind], &it->function, sizeof functions[kind]) != 0) {
        ++kind;
    }
    const char *name = (sets ? SETTERS : GETTERS)[kind];
    if (loop->status == BEYOND) {
        return REFUSE(c, inner->name, ": ", name, ": found a value that its type cannot hold");
    }
    return inner_done(inner, (fmi2Status)loop->status, name);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    Container *c = component;
    fmi2Status status;
    if (!may(c, INITIALIZATION, "fmi2ExitInitializationMode", &status)) {
        return status;
    }
    status = container_pass_on(c);
    status = status == fmi2OK ? EACH(c, leave, "fmi2ExitInitializationMode", false) : status;
    for (uint32_t i = 0; i < c->head.outputs && status == fmi2OK; ++i) {
        const End *from = &c->outputs[i];
        status = inner_get(&c->inner[from->block], from->kind, from->reference, &c->bus[i]);
    }
    status = status == fmi2OK ? check_bus(c, 0, c->head.outputs) : status;
    c->kept.mode = status == fmi2OK ? MODE_STEP : MODE_FAILED;
    return status;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state_before)
{
    static const double SHORT = 0.01; /* of a step: how much before its end a host may end, which adds up times */
    Container *c = component;
    fmi2Status status;
    (void)no_set_state_before;
    if (!may(c, STEP, "fmi2DoStep", &status)) {
        return status;
    }
    if (!(h > 0.0 && isfinite(h) && fabs(t - c->kept.time) <= 1e-6 * h + 1e-12 * fabs(c->kept.time))) {
        return REFUSE(c, "fmi2DoStep: expected a step above 0 that begins where the last one ended");
    }
    const double steps = (t + h - c->kept.begin) / (c->head.numerator / c->head.denominator) + SHORT;
    if (!(steps < 9007199254740992.0)) {
        return REFUSE(c, "fmi2DoStep: expected a time that is less than 2^53 steps");
    }
    c->loop.count = c->kept.count;
    if (run_loop(&c->loop, (int64_t)steps)) {
        return stopped(c);
    }
    c->kept.count = c->loop.count;
    c->kept.time = t + h;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    Container *c = component;
    fmi2Status status;
    if (may(c, STEP | FAILED, "fmi2Terminate", &status)) {
        status = EACH(c, terminate, "fmi2Terminate", true);
        c->kept.mode = MODE_TERMINATED;
    }
    return status;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    Container *c = component;
    fmi2Status status = EACH(c, reset, "fmi2Reset", false);
    if (status == fmi2OK) {
        memset(&c->kept, 0, sizeof c->kept);
        memset(c->bus, 0, c->head.outputs * sizeof *c->bus);
        status = set_starts(c);
    }
    return status;
}
