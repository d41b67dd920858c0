/* docs/how/planned.md, Phases. Tests: test_block.py. */
#include "controller_planned.h"

#include <string.h>

#include "decide/guard.h"
#include "decide/phases.h"
#include "plan/rods_alone.h"
#include "reference.h"

static const Motion NO_REFERENCE = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {0.0, 0.0, 0.0}, 0.0};

/* Whether there is none: a matrix of zeros, as simple masters give before the first value. Once flown, only where a
 * reference is connected: who gives it knows of an attitude that is lost. */
static bool no_attitude(const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    return is_zero_matrix(matrix(u->R_NB)) && (!x->flown || controller_planned_has_R_ref(u));
}

/* The control acts: x->t is the time of the inputs. */
static void sample(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, bool first)
{
    const double dt = first ? law->p.control_period : x->t - x->t_sample;
    const Around around = controller_planned_take_sample(law, x, u, first);
    const Ahead ahead = controller_planned_ahead_of(law, x, u);
    const Motion now = x->estimate;
    if (!first && is_planned(x->phase)) {
        const Model model = controller_planned_estimated(law, x);
        x->reference = controller_planned_advanced(&model, &around, &x->reference, x->u, dt);
    }
    if (controller_planned_has_attitude_bound(u) && ahead.target_kind != ONBOARD_TARGET_NONE) {
        const Target target = controller_planned_target_at(&ahead, x->t);
        const bool field_lost = is_lost(u->field_health);
        controller_planned_doubt(x, field_lost, u->attitude_bound, norm(now.Omega), norm(target.Omega));
    }
    controller_planned_decide(law, x, &ahead, &now, dt, first);
    x->sampled = true;
    controller_planned_command(law, x, u, &now, x->u, &x->held);
}

/* What leaves the block. */
/*@ requires \separated(law, y, f);
    assigns y->dipole_ff[0 .. 2], y->wheel_torque_ff, *f;
    CONTROLLER_PLANNED_FINITE
    COMMANDS_WITHIN(&law->p) */
static bool give(const ControllerPlannedLaw *law, ControllerPlannedOutputs *y, Fault *f)
{
    return controller_planned_give(&law->p, y, f);
}

/* Of the orbit through position and velocity, or of a low one where they give none. */
static Scales scales_of(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u)
{
    const Vector r_N = vector(u->r_N), v_N = vector(u->v_N);
    const double a = 1.0 / (2.0 / norm(r_N) - dot(v_N, v_N) / law->p.gravitational_parameter);
    return controller_planned_scales(&law->p, a >= ONBOARD_R_MIN ? a : LOW_ORBIT);
}

/* The state before the flight, at the time t: the parameters' values, and nothing planned. */
static void initialise(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, double t,
                       ControllerPlannedState *x)
{
    memset(x, 0, sizeof *x);
    x->t = t;
    x->scales = scales_of(law, u);
    x->phase = PHASE_DAMPING;
    x->settled_since = x->loaded_since = x->least_rate = INFINITY;
    x->reference = NO_REFERENCE;
    controller_planned_identification_start(&law->p, u, &x->scales, &x->identification);
    controller_planned_friction_start(&law->p, x->scales.time, &x->friction);
    x->rods_alone = controller_planned_is_no_wheel(law->p.wheel_torque_max, law->p.wheel_momentum_max, &x->scales);
}

/* The same, but for what is known of the wheel's telemetry. */
static void initialise_again(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u,
                             ControllerPlannedState *x)
{
    const MomentumWatch momentum = x->momentum;
    const double l = x->l_own;
    initialise(law, u, x->t, x);
    x->momentum = momentum;
    x->l_own = momentum.frozen ? l : 0.0;
}

/* The first sample with an attitude, or the first after one that was lost: what is known of the satellite stays. */
static bool begin(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x, Fault *f)
{
    if (x->flown) {
        controller_planned_take_measured(&x->identification);
    } else {
        initialise_again(law, u, x);
    }
    if (!controller_planned_gains_fit(law, &x->scales, f)) {
        return false;
    }
    x->waiting = false;
    x->until_sample = law->p.control_period;
    x->next_challenge = x->t;
    sample(law, x, u, true);
    return true;
}

/* A step without a sample: whether h_w is frozen, and the wheel's momentum where it is. */
static void watch_telemetry(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, double h,
                            ControllerPlannedState *x)
{
    const double limit = law->p.wheel_momentum_max;
    if (h > 0.0) {
        controller_planned_watch_h_w(law, x, u, h);
    }
    if (x->momentum.frozen) {
        x->l_own = clip(x->l_own + h * u->u_applied[3], -limit, limit);
    }
}

/* A step without attitude ends at x->t. The motor's torque is all that changes the wheel's momentum where it is not
 * measured. */
static void step_without_attitude(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, double h,
                                  ControllerPlannedState *x)
{
    if (!x->flown) {
        initialise_again(law, u, x);
    } else {
        controller_planned_change_phase(x, EVENT_NO_ATTITUDE, &NO_REFERENCE);
    }
    const double limit = law->p.wheel_momentum_max;
    watch_telemetry(law, u, h, x);
    if (!x->momentum.frozen) {
        x->l_own = clip(x->l_own + h * x->held.wheel_torque_ff, -limit, limit);
    }
    x->waiting = true;
    x->sampled = false;
    x->held = controller_planned_without_attitude(law, x, u);
}

bool controller_planned_start(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x,
                              Fault *f)
{
    initialise(law, u, 0.0, x);
    if (no_attitude(x, u)) {
        step_without_attitude(law, u, 0.0, x);
        return controller_planned_inputs_finite(u, f);
    }
    return controller_planned_inputs_fit(u, law->p.gravitational_parameter, f) && begin(law, u, x, f);
}

/*@ requires \separated(law, x, y, f);
    CONTROLLER_PLANNED_FINITE
    COMMANDS_WITHIN(&law->p) */
bool controller_planned_outputs(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, ControllerPlannedOutputs *y, Fault *f)
{
    if (no_attitude(x, u)) {
        *y = controller_planned_without_attitude(law, x, u);
        return controller_planned_inputs_finite(u, f) && give(law, y, f);
    }
    *y = x->held;
    if (!x->sampled) {
        return give(law, y, f);
    }
    double controls[CONTROLS];
    if (!controller_planned_inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    const Motion now = controller_planned_corrected(x, attitude_of(x, u), vector(u->omega_B), wheel_momentum(x, u));
    controller_planned_command(law, x, u, &now, controls, y);
    return give(law, y, f);
}

/*@ requires \separated(law, x, y, f);
    CONTROLLER_PLANNED_FINITE
    COMMANDS_WITHIN(&law->p) */
bool controller_planned_step(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u,
                             double h, ControllerPlannedOutputs *y, Fault *f)
{
    if (no_attitude(x, u)) {
        if (!controller_planned_inputs_finite(u, f)) {
            return false;
        }
        x->t += h;
        step_without_attitude(law, u, h, x);
        *y = x->held;
        return give(law, y, f);
    }
    if (!controller_planned_inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    x->t += h;
    if (x->waiting) {
        watch_telemetry(law, u, h, x);
        const bool begun = begin(law, u, x, f);
        x->flown = true;
        *y = x->held;
        return begun && give(law, y, f);
    }
    if (!controller_planned_gains_fit(law, &x->scales, f)) {
        return false;
    }
    x->flown = true;
    const double period = law->p.control_period;
    x->until_sample -= h;
    x->sampled = false;
    if (x->until_sample <= SAMPLE_EARLY * period) {
        sample(law, x, u, false);
        x->until_sample += period;
        if (x->until_sample <= SAMPLE_EARLY * period) {
            x->until_sample = period; /* a step longer than a period: the samples' grid begins anew */
        }
    }
    *y = x->held;
    return give(law, y, f);
}
