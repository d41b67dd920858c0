/* fmi2DoStep, its status, and what a simple co-simulation FMU does not offer. Tests: tests/native/test_calls.py. */
#include "instance.h"

#include <math.h>

static const double BEYOND_STOP =
    0.01; /* of a step: by how much it may end beyond stopTime, for masters that add up times */
static const double ROUNDING = 1e-12; /* of a time */
static const double SHORT = 0.01;     /* of a step: how much before an own instant it may end to reach it, likewise */

/* Whether a step to `end` reaches the block's next own instant: a count of periods, so no error adds up. */
static bool acts(const Memory *memory, double end, double h)
{
    const double period = memory->ports.sampling.sample_period;
    return !(period > 0.0) || end >= memory->begin + (double)(memory->instants + 1u) * period - SHORT * h;
}

/* A step that fails changes nothing: the block works on a copy of its state, which then takes the place of it, and the
 * outputs are evaluated anew where they are read. */
fmi2Status fmi2DoStep(fmi2Component component, fmi2Real t, fmi2Real h, fmi2Boolean no_set_state_before)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2DoStep", IN_STEP, &status);
    (void)no_set_state_before;
    if (c == NULL) {
        return status;
    }
    Memory *memory = &c->memory;
    if (!(h > 0.0 && isfinite(h))) {
        return refuse_fault(c, "fmi2DoStep", &(Fault){"communicationStepSize", "a finite number above 0", NULL, h});
    }
    if (!(fabs(t - memory->time) <= 1e-6 * h + ROUNDING * fabs(memory->time))) {
        Message m = message("fmi2DoStep: currentCommunicationPoint: expected ");
        put_number(&m, memory->time);
        put(&m, ", where the last step ended, found ");
        put_number(&m, t);
        return refuse(c, &m);
    }
    if (t + h > memory->stop + BEYOND_STOP * h + ROUNDING * fabs(memory->stop)) {
        Message m = message("fmi2DoStep: expected a step that ends at stopTime = ");
        put_number(&m, memory->stop);
        put(&m, " or before (to a hundredth of the step), found one that ends at ");
        put_number(&m, t + h);
        return refuse(c, &m);
    }
    const double period = memory->ports.sampling.sample_period;
    if (period > 0.0 && h > period + 1e-6 * period) {
        return refuse_fault(c, "fmi2DoStep", &(Fault){"communicationStepSize", "at most sample_period", NULL, h});
    }
    if (make_law_current(c, "fmi2DoStep") != fmi2OK) {
        return fmi2Error;
    }
    if (!acts(memory, t + h, h)) {
        memory->time = t + h;
        memory->held = true;
        return fmi2OK;
    }
    Fault f = {"inputs", "", NULL, 0.0};
    State *x = other_state(c);
    memcpy(x, state_of(c), block_state_used(state_of(c)));
    if (!block_step(&c->law, x, &memory->ports.u, period > 0.0 ? period : h, &memory->ports.y, &f) ||
        !block_guard(&memory->ports.y, &f)) {
        memory->fresh = memory->held = false;
        return refuse_fault(c, "fmi2DoStep", &f);
    }
    commit_state(c);
    memory->time = t + h;
    memory->fresh = true;
    memory->held = false;
    ++memory->instants;
    return fmi2OK;
}

static fmi2Status not_offered(fmi2Component component, const char *function)
{
    fmi2Status status;
    Instance *c = enter(component, function, IN_ANY, &status);
    return c == NULL ? status : refuse_text(c, function, "not offered; see the capability flags");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[], size_t n,
                                       const fmi2Integer order[], const fmi2Real values[])
{
    (void)references, (void)n, (void)order, (void)values;
    return not_offered(component, "fmi2SetRealInputDerivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[], size_t n,
                                        const fmi2Integer order[], fmi2Real values[])
{
    (void)references, (void)n, (void)order, (void)values;
    return not_offered(component, "fmi2GetRealOutputDerivatives");
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)sensitivity;
    return not_offered(component, "fmi2GetDirectionalDerivative");
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return not_offered(component, "fmi2CancelStep");
}

/* A step is over when fmi2DoStep returns, so the only status to be asked for is the time reached. */
fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real *value)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2GetRealStatus", IN_STEP | IN_TERMINATED, &status);
    if (c == NULL) {
        return status;
    }
    if (value == NULL) {
        return refuse_text(c, "fmi2GetRealStatus", "value is NULL");
    }
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = c->memory.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean *value)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2GetBooleanStatus", IN_STEP | IN_TERMINATED, &status);
    if (c == NULL) {
        return status;
    }
    if (value == NULL) {
        return refuse_text(c, "fmi2GetBooleanStatus", "value is NULL");
    }
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind kind, fmi2Status *value)
{
    fmi2Status status;
    (void)kind, (void)value;
    return enter(component, "fmi2GetStatus", IN_STEP | IN_TERMINATED, &status) == NULL ? status : fmi2Discard;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind kind, fmi2Integer *value)
{
    fmi2Status status;
    (void)kind, (void)value;
    return enter(component, "fmi2GetIntegerStatus", IN_STEP | IN_TERMINATED, &status) == NULL ? status : fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind kind, fmi2String *value)
{
    fmi2Status status;
    (void)kind, (void)value;
    return enter(component, "fmi2GetStringStatus", IN_STEP | IN_TERMINATED, &status) == NULL ? status : fmi2Discard;
}
