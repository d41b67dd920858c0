/* The planned controller's timers of phases, of a state with nothing in it, for tests: flat arrays in, flat arrays out. */
#include "decide/phases.h"
#include "probe_flat.h"

static ControllerPlannedState *nothing(const ControllerPlannedParameters *p)
{
    static ControllerPlannedState x;
    memset(&x, 0, sizeof x);
    x.scales = controller_planned_scales(p, 6.971e6);
    x.settled_since = x.loaded_since = x.least_rate = INFINITY;
    return &x;
}

/* Bounds of the attitude's error, rates and those wanted (n,3), and whether it holds and whether the field is lost (n,2):
 * whether the attitude is doubted, and drives (n,2). Returns T, s. */
PROBE double probe_doubt(const ControllerPlannedParameters *p, int n, const double *given, const unsigned char *is,
                         unsigned char *found)
{
    ControllerPlannedState *x = nothing(p);
    for (int i = 0; i < n; ++i) {
        x->phase = is[2 * i] ? PHASE_HOLD : PHASE_ACQUISITION;
        controller_planned_doubt(x, is[2 * i + 1], given[3 * i], given[3 * i + 1], given[3 * i + 2]);
        found[2 * i] = x->doubted;
        found[2 * i + 1] = x->drives;
    }
    return x->scales.time;
}

/* Angles, rates and disturbances (n,3), and whether the hold is loaded (n), at every dt of a hold: whether it has settled,
 * is turned away, and is strained (n,3). scales: T and the period of the orbit, s, and the largest disturbance, N m. */
PROBE void probe_hold(const ControllerPlannedParameters *p, double dt, int n, const double *given,
                      const unsigned char *loaded, unsigned char *found, double scales[3])
{
    ControllerPlannedState *x = nothing(p);
    x->phase = PHASE_HOLD;
    for (int i = 0; i < n; ++i, x->t += dt) {
        const Standing s = {.angle = given[3 * i], .rate = given[3 * i + 1], .loaded = loaded[i]};
        x->identification.p[TORQUE + 1] = given[3 * i + 2];
        const unsigned events = controller_planned_events(x, &s, 0.0);
        found[3 * i] = (events & EVENT_SETTLED) != 0;
        found[3 * i + 1] = (events & EVENT_TURNED_AWAY) != 0;
        controller_planned_update_strain(x, &s);
        found[3 * i + 2] = x->strained;
    }
    scales[0] = x->scales.time;
    scales[1] = x->scales.period;
    scales[2] = x->scales.disturbance_max;
}

/* The phase to which events lead from another one; negative where a plan or a steering is due. */
PROBE int probe_change(const ControllerPlannedParameters *p, int from, unsigned events)
{
    ControllerPlannedState *x = nothing(p);
    const Motion now = {identity, {0.0, 0.0, 0.0}, 0.0};
    x->phase = from;
    const bool due = controller_planned_change_phase(x, events, &now);
    return due ? -x->phase : x->phase;
}

/* The standing of a motion against the target of a plan, in a phase: angle, rate, share of lost, near and loaded. */
PROBE void probe_standing(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, int phase, double found[5])
{
    static ControllerPlannedState state;
    OnboardField field;
    const Model model = model_of(m);
    const Ahead ahead = ahead_of_flat(a, &field);
    const Motion now = motion_of(x);
    memset(&state, 0, sizeof state);
    state.scales = model.scales;
    state.phase = phase;
    state.t = a->t;
    const Standing s = controller_planned_standing(&state, &model, &ahead, &now, 0.0);
    const double all[5] = {s.angle, s.rate, s.lost, s.near, s.loaded};
    memcpy(found, all, sizeof all);
}

/* The controls of a sample at the start, on a plan of which each stage of 0.1 s has a tenth more for the first rod. */
PROBE int probe_commanded(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                          double controls[CONTROLS])
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState x;
    ControllerPlannedOutputs y;
    Fault f;
    bool well = controller_planned_check(p, &f);
    controller_planned_prepare(p, &law);
    well = well && controller_planned_start(&law, u, &x, &f);
    memset(&x.plan, 0, sizeof x.plan);
    x.phase = PHASE_ACQUISITION;
    x.plan.start = x.t;
    x.plan.stages = 10;
    for (int i = 0; i < x.plan.stages; ++i) {
        x.plan.h[i] = 0.1;
        x.plan.u[i][0] = 0.1 * i;
    }
    controller_planned_command(&law, &x, u, &x.estimate, controls, &y);
    return well;
}

/* The wheel's momentum at the instant of a search that begins during an acquisition, above that of now, N m s, on a plan
 * of stages of a control period with these torques, N m. Returns the instant, s; negative where none begins. */
PROBE double probe_foreseen(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u, int n,
                            const double *torque, double *momentum)
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState x;
    Fault f;
    if (!controller_planned_check(p, &f)) {
        return -1.0;
    }
    controller_planned_prepare(p, &law);
    if (!controller_planned_start(&law, u, &x, &f)) {
        return -1.0;
    }
    x.phase = PHASE_ACQUISITION;
    x.search.active = x.search.ready = x.challenged = x.provisional = false;
    x.next_challenge = 0.0;
    x.next_plan = INFINITY;
    memset(&x.plan, 0, sizeof x.plan);
    x.plan.start = x.t;
    x.plan.stages = n;
    for (int i = 0; i < n; ++i) {
        x.plan.h[i] = p->control_period;
        x.plan.u[i][3] = torque[i] / p->wheel_torque_max;
    }
    const Ahead ahead = controller_planned_ahead_of(&law, &x, u);
    const Motion now = x.estimate;
    controller_planned_decide(&law, &x, &ahead, &now, p->control_period, false);
    *momentum = x.search.x.l - now.l;
    return x.search.active ? x.search.t - x.t : -1.0;
}
