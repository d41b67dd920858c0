/* The outputs: docs/how/planned.md, The law on the plan. Tests: test_outputs.py. */
#include "reference.h"
#include "../state.h"

#include <string.h>

static const double PROBE =
    0.02; /* of the wheel's limit: torque, to and fro, by which a stuck wheel shows that it works */
static const double PROBE_SAMPLES = 4.0; /* to either side */
static const double TURNS_MAX = 9e15;    /* for which a double has halves, and an integer room */
static const double TINY = 1e-300;       /* keeps a rod that gives nothing from dividing */

/* The feed-forward. */
static void store_controls(const ControllerPlannedParameters *p, const double controls[CONTROLS],
                           ControllerPlannedOutputs *y)
{
    const Vector limit = controller_planned_rod_dipoles(p);
    store((Vector){limit.x * controls[0], limit.y * controls[1], limit.z * controls[2]}, y->dipole_ff);
    y->wheel_torque_ff = p->wheel_torque_max * controls[3];
}

/* What rods and wheel give under their controls: N m. */
static Vector torque_of_controls(const Model *model, Vector Omega, double l, Vector B_B,
                                 const double controls[CONTROLS])
{
    Vector tau = cross(rods_dipole(model, controls), B_B);
    tau = subtract(tau, cross(Omega, momentum_of_wheels(model, l)));
    return subtract(tau, scale(model->wheel_torque_max * controls[3], model->wheel_axis));
}

/* The same, while the wheel comes to rest. */
static Vector torque_of_rods(const Model *model, Vector Omega, double l, Vector B_B, double controls[CONTROLS])
{
    controls[3] = wheel_to_rest(model, l, PLAN_PERIOD * model->scales.time);
    return torque_of_controls(model, Omega, l, B_B, controls);
}

/* The wheel's control that takes up the body's momentum along its axis, as far as it can hold that. */
static double wheel_against(const Model *model, Vector omega, double l, double time)
{
    const double most = model->wheel_momentum_max;
    const double wanted = clip(l + dot(model->wheel_axis, apply(model->J, omega)), -most, most);
    return has_wheel(model) ? clip((wanted - l) / (time * model->wheel_torque_max), -1.0, 1.0) : 0.0;
}

/* Dipoles omega x B L/|B|^2, which give -L omega across the field, by their parts along the rods, each within its
 * limit: no rod gives energy to the motion omega. */
static void damping_rods(const Model *model, double L, Vector omega, Vector B_B, double controls[CONTROLS])
{
    const double square = dot(B_B, B_B);
    const Vector m = square > 0.0 ? scale(L / square, cross(omega, B_B)) : (Vector){0.0, 0.0, 0.0};
    for (int i = 0; i < 3; ++i) {
        controls[i] = clip(dot(model->rods[i], m) / larger(dot(model->rods[i], model->rods[i]), TINY), -1.0, 1.0);
    }
}

/* The outputs where there is no attitude to plan with, of the rate Omega, the wheel's momentum l and the field B_B,
 * zero where unknown: the rate is brought to Omega_ref where R_ref is a matrix of zeros, else to rest. Where the field
 * is `doubted`, the wheel does not give its momentum to a body that rods may not damp, but takes up what it can. */
static void damp(const ControllerPlannedLaw *law, const ControllerPlannedInputs *u, const Model *model, Vector Omega,
                 double l, Vector B_B, bool doubted, double controls[CONTROLS], ControllerPlannedOutputs *y)
{
    const ControllerPlannedParameters *p = &law->p;
    const Matrix L = model->scales.L;
    const Vector omega = is_zero_matrix(matrix(u->R_ref)) ? subtract(Omega, vector(u->Omega_ref)) : Omega;
    damping_rods(model, (L.a.x + L.b.y + L.c.z) / 3.0, omega, B_B, controls);
    const double time = PLAN_PERIOD * model->scales.time;
    controls[3] = doubted ? wheel_against(model, omega, l, time) : wheel_to_rest(model, l, time);
    store(torque_of_controls(model, Omega, l, B_B, controls), y->tau_cmd_B);
    store((Vector){0.0, 0.0, 0.0}, y->dOmega_d);
    y->attitude_error = REFERENCE_NO_ATTITUDE;
    store(omega, y->rate_error_B);
    y->lyapunov = 0.5 * dot(omega, apply(model->J, omega));
    y->phase = PHASE_DAMPING;
    store_controls(p, controls, y);
}

/* The errors from the reference, as the law [8] takes them. */
typedef struct {
    Matrix Q;
    Vector omega, Omega_d_B; /* Omega_d_B = Q^T Omega_d */
} Errors;

/* The law [8] on the reference, less the torques that are known. Q^T e_i is row i of Q. */
static Vector tracking_torque(const Model *model, const Errors *e, Vector dOmega_d, Vector B_B, Vector M_g)
{
    const Matrix Q = e->Q, J = model->J;
    const Vector K = model->scales.K, w = e->Omega_d_B;
    const Vector gradient = {K.y * Q.b.z - K.z * Q.c.y, K.z * Q.c.x - K.x * Q.a.z, K.x * Q.a.y - K.y * Q.b.x};
    Vector tau = add(scale(-1.0, apply(model->scales.L, e->omega)), gradient);
    tau = add(tau, add(apply(J, apply_transposed(Q, dOmega_d)), cross(w, apply(J, w))));
    const Vector unwanted = add(model->disturbance_B, cross(model->residual_B, B_B));
    return subtract(tau, add(M_g, unwanted));
}

/* What is estimated, and the reference. */
static void store_estimates(const ControllerPlannedState *x, const Model *model, const Motion *now,
                            ControllerPlannedOutputs *y)
{
    y->gain_k = 1.0;
    y->gain_l = 1.0;
    store_matrix(x->reference.R, y->R_d);
    store(x->reference.Omega, y->Omega_d);
    y->h_w_ref = x->reference.l;
    y->plan_cost = may_be_flown(&x->plan) ? x->plan.cost : -1.0;
    y->phase = x->phase;
    store(model->disturbance_B, y->disturbance_B);
    store(model->residual_B, y->residual_dipole_estimate_B);
    store_matrix(model->J, y->J_estimate_B);
    store_matrix(controller_planned_inertia_sigma(&x->identification), y->J_estimate_sigma_B);
    y->rod_gain_estimate = controller_planned_rods_gain(&x->identification);
    y->failed_rod = controller_planned_failed_rod(&x->identification);
    y->rod_failed = y->failed_rod > 0;
    y->wheel_failed = controller_planned_wheel_failed(&x->friction);
    y->attitude_frozen = x->sensors.attitude_frozen;
    y->field_failed = x->sensors.field_failed;
    y->h_w_frozen = x->momentum.frozen;
    store(vector(x->identification.p + GAINS), y->rod_gains_estimate);
    store(vector(x->identification.p + BIAS), y->rate_bias_estimate_B);
    y->wheel_friction_estimate = x->friction.p[0];
    y->wheel_decay_estimate = x->friction.p[1];
    y->h_w_estimate = now->l;
}

ControllerPlannedOutputs controller_planned_without_attitude(const ControllerPlannedLaw *law,
                                                             const ControllerPlannedState *x,
                                                             const ControllerPlannedInputs *u)
{
    ControllerPlannedOutputs y;
    memset(&y, 0, sizeof y);
    y.no_attitude = true;
    const Model model = controller_planned_estimated(law, x);
    const Vector Omega = subtract(vector(u->omega_B), vector(x->identification.p + BIAS));
    const Motion now = {identity, Omega, wheel_momentum(x, u)};
    const bool measured =
        has_field(u) && !x->sensors.field_failed; /* one that repeats, too: no model can stand in for it */
    const Vector B_B = measured ? vector(u->b_B) : (Vector){0.0, 0.0, 0.0};
    double controls[CONTROLS];
    store(B_B, y.b_used_B);
    store_estimates(x, &model, &now, &y);
    damp(law, u, &model, now.Omega, now.l, B_B, !measured, controls, &y);
    return y;
}

void controller_planned_command(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, const Motion *now, double controls[CONTROLS],
                                ControllerPlannedOutputs *y)
{
    const ControllerPlannedParameters *p = &law->p;
    const Model model = controller_planned_estimated(law, x);
    const Ahead ahead = controller_planned_ahead_of(law, x, u);
    const Around around = controller_planned_around_at(&ahead, x->t);
    const Vector B_B = uses_field(x, u) ? vector(u->b_B) : apply_transposed(now->R, around.B_N);
    y->no_attitude = false;
    store(B_B, y->b_used_B);
    store_estimates(x, &model, now, y);
    if (x->phase == PHASE_DAMPING) {
        damp(law, u, &model, now->Omega, now->l, x->drives ? (Vector){0.0, 0.0, 0.0} : B_B, x->doubted, controls, y);
        return;
    }

    const Target target = controller_planned_target_at(&ahead, x->t);
    const Matrix Q_target = multiply(transposed(target.R), now->R);
    y->attitude_error = principal_angle(Q_target);
    store(subtract(now->Omega, apply_transposed(Q_target, target.Omega)), y->rate_error_B);

    const Matrix Q = multiply(transposed(x->reference.R), now->R);
    const Vector w = apply_transposed(Q, x->reference.Omega);
    const Errors e = {Q, subtract(now->Omega, w), w};
    const Vector slack = {1.0 - Q.a.x, 1.0 - Q.b.y, 1.0 - Q.c.z};
    y->lyapunov = 0.5 * dot(e.omega, apply(model.J, e.omega)) + dot(model.scales.K, slack);

    Vector dOmega_d = {0.0, 0.0, 0.0}, tau;
    if (x->phase == PHASE_STEERING) {
        controller_planned_steering_rods(&x->steering, now->R, B_B, model.rods, model.scales.time, controls);
        tau = torque_of_rods(&model, now->Omega, now->l, B_B, controls);
    } else {
        controller_planned_plan_at(&x->plan, x->t + 0.5 * p->control_period, controls);
        dOmega_d = controller_planned_acceleration(&model, &around, &x->reference, controls);
        tau = has_wheel(&model) ? tracking_torque(&model, &e, dOmega_d, B_B, gravity_gradient(model.J, &around, now->R))
                                : torque_of_rods(&model, now->Omega, now->l, B_B, controls);
    }
    store_controls(p, controls, y);
    store(dOmega_d, y->dOmega_d);
    if (!has_wheel(&model)) {
        if (x->friction.stuck) {
            const double turns = clip(0.5 * x->t / (PROBE_SAMPLES * p->control_period), 0.0, TURNS_MAX);
            //@ assert \is_finite(turns);
            y->wheel_torque_ff = (turns - (double)(int64_t)turns < 0.5 ? PROBE : -PROBE) * p->wheel_torque_max;
            tau = subtract(tau, scale(y->wheel_torque_ff, model.wheel_axis));
        }
        store(tau, y->tau_cmd_B);
        return;
    }
    /* The motor gives that against friction too. */
    const double rate = y->wheel_torque_ff;
    y->wheel_torque_ff += controller_planned_friction_torque(&x->friction, now->l, rate, p->control_period);
    y->wheel_torque_ff = clip(y->wheel_torque_ff, -p->wheel_torque_max, p->wheel_torque_max);
    store(subtract(tau, scale(y->wheel_torque_ff - rate, model.wheel_axis)), y->tau_cmd_B);
}
