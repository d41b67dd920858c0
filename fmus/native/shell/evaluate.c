/* The block's functions on an instance: its law, its state at the start, its outputs.
 * Requirement: FC-4. Tests: tests/native/test_calls.py. */
#include "instance.h"

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

fmi2Status evaluate(Instance *c, const char *function, const State *x)
{
    Fault f = {"inputs", "", NULL, 0.0};
    Outputs y;
    memset(&y, 0, sizeof y);
    if (!block_outputs(&c->law, x, &c->memory.ports.u, &y, &f) || !block_guard(&y, &f)) {
        return refuse_fault(c, function, &f);
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
