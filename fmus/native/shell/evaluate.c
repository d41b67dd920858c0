/* The block's functions on an instance: its law, its state at the start, its outputs.
 * Tests: tests/native/test_calls.py. */
#include "instance.h"

#include <math.h>

const State *state_of(const Instance *c)
{
    return &c->states[c->current];
}

State *other_state(Instance *c)
{
    return &c->states[1 - c->current];
}

void commit_state(Instance *c)
{
    c->current = 1 - c->current;
}

fmi2Status make_law_current(Instance *c, const char *function)
{
    Fault f = {"parameters", "", NULL, 0.0};
    if (!c->law_current) {
        if (!block_check(&c->memory.ports.p, &f)) {
            return refuse_fault(c, function, &f);
        }
        block_prepare(&c->memory.ports.p, &c->law);
        c->law_current = true;
    }
    return fmi2OK;
}

/* All outputs of a run at once: x - x has no bit set where x is finite, and no value decides on a branch. */
static bool run_finite(const unsigned char *bytes, size_t n)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < n; ++i) {
        double value;
        uint64_t difference;
        memcpy(&value, bytes + i * sizeof value, sizeof value);
        value -= value;
        memcpy(&difference, &value, sizeof difference);
        bits |= difference;
    }
    return bits == 0;
}

bool outputs_finite(const Instance *c, const char *function, const Outputs *y)
{
    for (size_t i = 0; i < BLOCK_REAL_OUTPUTS; ++i) {
        const Variable *v = &variables[real_outputs[i]];
        const unsigned char *bytes = (const unsigned char *)y + (v->offset - offsetof(Ports, y));
        for (uint32_t k = 0; !run_finite(bytes, v->followers + 1) && k <= v->followers; ++k) {
            double value;
            memcpy(&value, bytes + k * sizeof value, sizeof value);
            if (!isfinite(value)) {
                refuse_fault(c, function, &(Fault){v[k].name, "a finite number for this output", NULL, value});
                return false;
            }
        }
    }
    return true;
}

fmi2Status evaluate(Instance *c, const char *function, const State *x)
{
    Fault f = {"inputs", "", NULL, 0.0};
    Outputs y;
    memset(&y, 0, sizeof y);
    if (!block_outputs(&c->law, x, &c->memory.ports.u, &y, &f)) {
        return refuse_fault(c, function, &f);
    }
    if (!outputs_finite(c, function, &y)) {
        return fmi2Error;
    }
    memcpy(&c->memory.ports.y, &y, sizeof y);
    c->memory.fresh = true;
    return fmi2OK;
}

fmi2Status start(Instance *c, const char *function)
{
    Fault f = {"inputs", "", NULL, 0.0};
    State *x = other_state(c);
    memset(x, 0, sizeof *x);
    return block_start(&c->law, &c->memory.ports.u, x, &f) ? fmi2OK : refuse_fault(c, function, &f);
}

fmi2Status make_outputs_fresh(Instance *c, const char *function)
{
    if (c->memory.fresh || c->memory.held) {
        return fmi2OK;
    }
    if (make_law_current(c, function) != fmi2OK) {
        return fmi2Error;
    }
    const bool running = c->memory.mode == MODE_STEP || c->memory.mode == MODE_TERMINATED;
    if (!running && start(c, function) != fmi2OK) {
        return fmi2Error;
    }
    return evaluate(c, function, running ? state_of(c) : other_state(c));
}
