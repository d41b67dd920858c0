#include "controller_planned.h"

#include <string.h>

#include "reference.h"
#include "rods_alone.h"

static const double COLLINEAR = 1e-6; /* |r x v|/(|r||v|) below which the orbit has no plane */
static const double CLOSED = 0.999;   /* of the energy that escapes: the orbit's largest */
static const Motion nowhere = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {0.0, 0.0, 0.0}, 0.0}; /* the reference */

/* Whether there is none: a matrix of zeros, as simple masters give before the first value. Once flown, only where a reference
 * is connected: who gives it knows of an attitude that is lost. */
static bool no_attitude(const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    return is_zero_matrix(matrix(u->R_NB)) && (!x->flown || controller_planned_has_R_ref(u));
}

/* Whether the reference to come has numbers and is given in full, or not at all. */
static bool ahead_fits(const ControllerPlannedInputs *u, Fault *f)
{
    static const char *const all =
        "to be connected: connect t_ahead, turn_ahead and Omega_ahead with R_ref, or none of the three";
    const bool times = controller_planned_has_t_ahead(u), turns = controller_planned_has_turn_ahead(u);
    int given_times = AHEAD_TIMES;
    while (given_times > 0 && u->t_ahead[given_times - 1] == 0.0) {
        --given_times;
    }
    for (int k = 0; k < AHEAD_TIMES; ++k) {
        const NamedVector given[] = {{"t_ahead", {u->t_ahead[k], 0.0, 0.0}},
                                     {"turn_ahead", vector(u->turn_ahead[k])},
                                     {"Omega_ahead", vector(u->Omega_ahead[k])}};
        if (!all_finite_vectors(given, COUNT(given), f)) {
            return false;
        }
        if (times && k > 0 && k < given_times && !(u->t_ahead[k] > u->t_ahead[k - 1])) {
            return fault(f, "t_ahead", u->t_ahead[k], "ascending times, zeros at the end where there are fewer");
        }
    }
    if (times != turns || turns != controller_planned_has_Omega_ahead(u) || (times && !controller_planned_has_R_ref(u))) {
        const char *missing = !times                            ? "t_ahead"
                              : !turns                          ? "turn_ahead"
                              : controller_planned_has_R_ref(u) ? "Omega_ahead"
                                                                : "R_ref";
        return fault(f, missing, CONTROLLER_PLANNED_ABSENT_MIN, all);
    }
    return true;
}

static bool inputs_finite(const ControllerPlannedInputs *u, Fault *f)
{
    const NamedVector inputs[] = {{"omega_B", vector(u->omega_B)},
                                  {"r_N", vector(u->r_N)},
                                  {"v_N", vector(u->v_N)},
                                  {"b_B", vector(u->b_B)},
                                  {"R_ref", vector(u->R_ref[0])},
                                  {"R_ref", vector(u->R_ref[1])},
                                  {"R_ref", vector(u->R_ref[2])},
                                  {"Omega_ref", vector(u->Omega_ref)},
                                  {"dOmega_ref", vector(u->dOmega_ref)}};
    if (!all_finite_vectors(inputs, COUNT(inputs), f)) {
        return false;
    }
    const bool attitude = controller_planned_has_R_ref(u), rate = controller_planned_has_Omega_ref(u);
    if (attitude != rate || rate != controller_planned_has_dOmega_ref(u)) {
        return fault(f,
                     !attitude ? "R_ref"
                     : !rate   ? "Omega_ref"
                               : "dOmega_ref",
                     CONTROLLER_PLANNED_ABSENT_MIN,
                     "to be connected: connect R_ref, Omega_ref and dOmega_ref, or none of them");
    }
    if (!ahead_fits(u, f)) {
        return false;
    }
    if (controller_planned_has_b_B(u) && norm(vector(u->b_B)) > ONBOARD_FIELD_MAX) {
        return fault(f, "b_B", norm(vector(u->b_B)), "a field in tesla, |b_B| at most 0.001 (or 1e9: not connected)");
    }
    if (!all_finite(&(Named){"h_w", u->h_w}, 1, f)) {
        return false;
    }
    for (int i = 0; i < CONTROLS; ++i) {
        if (!isfinite(u->u_applied[i])) {
            return fault(f, "u_applied", u->u_applied[i], "finite numbers");
        }
    }
    return true;
}

static bool inputs_fit(const ControllerPlannedInputs *u, double mu, Fault *f)
{
    if (!inputs_finite(u, f)) {
        return false;
    }
    const Vector r_N = vector(u->r_N), v_N = vector(u->v_N);
    const double r = norm(r_N), v = norm(v_N);
    if (!(r >= ONBOARD_R_MIN)) {
        return fault(f, "r_N", r, "at least 1000 km from the Earth's centre");
    }
    if (!(norm(cross(r_N, v_N)) > COLLINEAR * r * v)) {
        return fault(f, "v_N", norm(cross(r_N, v_N)), "a velocity that spans the orbit's plane with r_N, |r x v| above 0");
    }
    if (!(0.5 * v * v < CLOSED * mu / r)) {
        return fault(f, "v_N", v, "the velocity of a closed orbit, below that of escape");
    }
    const Matrix R_ref = matrix(u->R_ref);
    return is_attitude(matrix(u->R_NB), f) &&
           (!controller_planned_has_R_ref(u) || is_zero_matrix(R_ref) ||
            is_rotation(R_ref, REFERENCE_ATTITUDE_TOLERANCE, "R_ref",
                        "a rotation matrix, max |R_ref^T R_ref - I| at most 0.0001, or zeros", f));
}

/* The control acts: x->t is the time of the inputs. */
static void sample(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, bool first)
{
    const double dt = first ? law->p.control_period : x->t - x->t_sample;
    const Around around = controller_planned_take_sample(law, x, u, first);
    const Ahead ahead = controller_planned_ahead_of(law, x, u);
    const Motion now = x->estimate;
    if (!first && is_planned(x->phase)) {
        const Model model = controller_planned_believed(law, x);
        x->reference = controller_planned_advanced(&model, &around, &x->reference, x->u, dt);
    }
    controller_planned_decide(law, x, &ahead, &now, dt, first);
    x->sampled = true;
    controller_planned_command(law, x, u, &now, x->u, &x->held);
}

/* Of the orbit through position and velocity, or of a low one where they give none. */
static Scales scales_of(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u)
{
    const Vector r_N = vector(u->r_N), v_N = vector(u->v_N);
    const double a = 1.0 / (2.0 / norm(r_N) - dot(v_N, v_N) / law->p.gravitational_parameter);
    return controller_planned_scales(&law->p, a >= ONBOARD_R_MIN ? a : LOW_ORBIT);
}

/* What is known before the flight, at the time t. */
static void know(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, double t, ControllerPlannedState *x)
{
    memset(x, 0, sizeof *x);
    x->t = t;
    x->scales = scales_of(law, u);
    x->reference = nowhere;
    controller_planned_identification_start(&law->p, &x->scales, &x->identification);
    controller_planned_friction_start(&law->p, x->scales.time, &x->friction);
    x->rods_alone = controller_planned_is_no_wheel(law->p.wheel_torque_max, law->p.wheel_momentum_max, &x->scales);
}

/* The first sample with an attitude, or the first after one that was lost: what is known of the satellite stays. */
static void begin(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x)
{
    if (x->flown) {
        controller_planned_take_measured(&x->identification);
    } else {
        know(law, u, x->t, x);
    }
    x->waiting = false;
    x->phase = PHASE_STEERING; /* or damping, by the first sample */
    x->settled_since = INFINITY;
    x->until_sample = law->p.control_period;
    x->next_plan = x->next_challenge = x->t;
    sample(law, x, u, true);
}

/* A step without attitude ends at x->t. The motor's torque is all that changes the wheel's momentum where it is not measured. */
static void wait(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, double h, ControllerPlannedState *x)
{
    if (!x->flown) {
        know(law, u, x->t, x);
    } else if (!x->waiting) {
        controller_planned_give_up(x, &nowhere);
    }
    const double limit = law->p.wheel_momentum_max;
    x->l_own = clip(x->l_own + h * x->held.wheel_torque_ff, -limit, limit);
    x->waiting = true;
    x->sampled = false;
    x->held = controller_planned_without_attitude(law, x, u);
}

bool controller_planned_start(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x, Fault *f)
{
    know(law, u, 0.0, x);
    if (no_attitude(x, u)) {
        wait(law, u, 0.0, x);
        return inputs_finite(u, f);
    }
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    begin(law, u, x);
    return true;
}

bool controller_planned_outputs(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, ControllerPlannedOutputs *y, Fault *f)
{
    if (no_attitude(x, u)) {
        *y = controller_planned_without_attitude(law, x, u);
        return inputs_finite(u, f);
    }
    *y = x->held;
    if (!x->sampled) {
        return true;
    }
    double controls[CONTROLS];
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    const double l = controller_planned_has_h_w(u) ? u->h_w : x->l_own;
    const Motion now = controller_planned_corrected(x, attitude_of(x, u), vector(u->omega_B), l);
    controller_planned_command(law, x, u, &now, controls, y);
    return true;
}

bool controller_planned_step(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, double h,
                             ControllerPlannedOutputs *y, Fault *f)
{
    if (no_attitude(x, u)) {
        if (!inputs_finite(u, f)) {
            return false;
        }
        x->t += h;
        wait(law, u, h, x);
        *y = x->held;
        return true;
    }
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    x->t += h;
    if (x->waiting) {
        begin(law, u, x);
        x->flown = true;
        *y = x->held;
        return true;
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
    return true;
}
