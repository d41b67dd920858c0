/* The outputs: the law [8] on the plan, or the steering. */
#include "state.h"

static const double WHEEL_REST = 10.0; /* s, over which the wheel is brought to rest while steering */

/* What rods and wheel give while the momentum is steered: N m, and their controls. */
static Vector steering_torque(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const Model *model,
                              const Motion *now, Vector B_B, double controls[CONTROLS])
{
    const double torque_max = law->p.wheel_torque_max;
    controller_planned_steering_rods(&x->steering, now->R, B_B, model->rods, controls);
    controls[3] = clip(-now->l / (WHEEL_REST * torque_max), -1.0, 1.0);
    Vector tau = cross(rods_dipole(model, controls), B_B);
    tau = subtract(tau, cross(now->Omega, (Vector){now->l, 0.0, 0.0}));
    tau.x -= torque_max * controls[3];
    return tau;
}

/* What the law [8] knows of the errors from the reference. */
typedef struct {
    Matrix Q;
    Vector omega, Omega_d_B; /* Omega_d_B = Q^T Omega_d */
} Errors;

/* The law [8] on the reference, less the torques that are known. Q^T e_i is row i of Q. */
static Vector tracking_torque(const ControllerPlannedParameters *p, const Model *model, const Errors *e, Vector dOmega_d,
                              Vector B_B, Vector M_g)
{
    const Matrix Q = e->Q, J = model->J;
    const Vector K = vector(p->K0), w = e->Omega_d_B;
    const Vector gradient = {K.y * Q.b.z - K.z * Q.c.y, K.z * Q.c.x - K.x * Q.a.z, K.x * Q.a.y - K.y * Q.b.x};
    Vector tau = add(scale(-1.0, apply(matrix(p->L0), e->omega)), gradient);
    tau = add(tau, add(apply(J, apply_transposed(Q, dOmega_d)), cross(w, apply(J, w))));
    const Vector unwanted = add(model->disturbance_B, cross(model->residual_B, B_B));
    return subtract(tau, add(M_g, unwanted));
}

/* What is estimated, and the reference. */
static void store_estimates(const ControllerPlannedState *x, const Model *model, const Motion *now, ControllerPlannedOutputs *y)
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
    y->rod_gain_estimate = x->identification.p[GAIN];
    y->h_w_estimate = now->l;
}

void controller_planned_command(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, const Motion *now, double controls[CONTROLS],
                                ControllerPlannedOutputs *y)
{
    const ControllerPlannedParameters *p = &law->p;
    const Model model = controller_planned_believed(law, x);
    const Ahead ahead = controller_planned_ahead_of(law, x, u);
    const Around around = controller_planned_around_at(&ahead, x->t);
    const Target target = controller_planned_target_at(&ahead, x->t);
    const Vector B_B = has_field(u) ? vector(u->b_B) : apply_transposed(now->R, around.B_N);

    const Matrix Q_target = multiply(transposed(target.R), now->R);
    y->attitude_error = principal_angle(Q_target);
    store(subtract(now->Omega, apply_transposed(Q_target, target.Omega)), y->rate_error_B);

    const Matrix Q = multiply(transposed(x->reference.R), now->R);
    const Vector w = apply_transposed(Q, x->reference.Omega);
    const Errors e = {Q, subtract(now->Omega, w), w};
    const Vector slack = {1.0 - Q.a.x, 1.0 - Q.b.y, 1.0 - Q.c.z};
    y->lyapunov = 0.5 * dot(e.omega, apply(model.J, e.omega)) + dot(vector(p->K0), slack);

    Vector dOmega_d = {0.0, 0.0, 0.0}, tau;
    if (x->phase == PHASE_STEERING) {
        tau = steering_torque(law, x, &model, now, B_B, controls);
    } else {
        controller_planned_plan_at(&x->plan, x->t + 0.5 * p->control_period, controls);
        dOmega_d = controller_planned_acceleration(&model, &around, &x->reference, controls);
        tau = tracking_torque(p, &model, &e, dOmega_d, B_B, gravity_gradient(model.J, &around, now->R));
    }
    store(tau, y->tau_cmd_B);
    store(dOmega_d, y->dOmega_d);
    for (int i = 0; i < 3; ++i) {
        y->dipole_ff[i] = p->dipole_max * controls[i];
    }
    y->wheel_torque_ff = p->wheel_torque_max * controls[3];
    store_estimates(x, &model, now, y);
}
