/* Motion, properties and field as they are estimated: docs/how/planned-estimates.md, Estimates.
 * Tests: test_identification.py, test_optional_inputs.py. */
#include "../plan/rods_alone.h"
#include "../state.h"
#include "../plan/strained.h"

#include <string.h>

static const double TURNED = 0.03;   /* rad: a field off by more changes torques more than the rods do */
static const double GAIN_MIN = 1e-3; /* of a dead rod: it keeps its direction */
static const double BIAS_TIME = 60.0, BIAS_MAX = 2e-5; /* s, T */

/* The rods' dipoles at their limit. */
static void set_rods(const ControllerPlannedLaw *law, Model *model)
{
    const Vector limit = controller_planned_rod_dipoles(&law->p);
    model->rods[0] = scale(limit.x, law->rod_axes.a);
    model->rods[1] = scale(limit.y, law->rod_axes.b);
    model->rods[2] = scale(limit.z, law->rod_axes.c);
}

Model controller_planned_nominal(const ControllerPlannedLaw *law, const Scales *scales)
{
    const ControllerPlannedParameters *p = &law->p;
    Model model = {.J = matrix(p->J_B),
                   .wheel_axis = law->wheel_axis,
                   .wheel_torque_max = p->wheel_torque_max,
                   .wheel_momentum_max = p->wheel_momentum_max,
                   .beside_B = law->beside_B,
                   .scales = *scales};
    model.horizon = controller_planned_horizon(scales->time);
    model.J_inverse = inverse(model.J);
    set_rods(law, &model);
    if (controller_planned_has_K0(p)) {
        model.scales.K = vector(p->K0);
    }
    if (controller_planned_has_L0(p)) {
        model.scales.L = matrix(p->L0);
    }
    return model;
}

Model controller_planned_estimated(const ControllerPlannedLaw *law, const ControllerPlannedState *x)
{
    const double *p = x->identification.p;
    Model model = controller_planned_nominal(law, &x->scales);
    model.J = controller_planned_estimated_inertia(&x->identification);
    model.J_inverse = inverse(model.J);
    for (int i = 0; i < 3; ++i) {
        model.rods[i] = scale(fabs(p[GAINS + i]) > GAIN_MIN ? p[GAINS + i] : GAIN_MIN, model.rods[i]);
    }
    model.disturbance_B = vector(p + TORQUE);
    model.residual_B = vector(p + DIPOLE);
    if (x->rods_alone) {
        controller_planned_plan_by_rods(&model, &x->plan);
    }
    if (x->strained) {
        controller_planned_plan_strained(&model);
    } else if (!x->rods_alone && controller_planned_stuck_on(&x->identification)) {
        controller_planned_plan_gently(&model);
    }
    return model;
}

static const double STILL = 5e-5; /* rad/s relative to LVLH, below which a reference keeps its attitude to it */

/* Of a given reference, what is known of it, and what comes after: it keeps its attitude to LVLH where it has next
 * to no rate relative to it, else its body rate. */
static void extrapolate(const ControllerPlannedInputs *u, double period, Ahead *ahead)
{
    Knot last = {ahead->orbit.t, {matrix(u->R_ref), vector(u->Omega_ref)}};
    if (is_zero_matrix(last.target.R)) {
        ahead->target_kind = ONBOARD_TARGET_NONE;
        return;
    }
    Vector r = ahead->orbit.r, v = ahead->orbit.v;
    ahead->knot[0] = last;
    //@ loop unroll AHEAD_TIMES;
    for (int k = 0; controller_planned_has_t_ahead(u) && k < AHEAD_TIMES; ++k) {
        const double t = ahead->orbit.t + u->t_ahead[k];
        if (t > last.t + period) {
            last = (Knot){t, {rotation_exp(vector(u->turn_ahead[k])), vector(u->Omega_ahead[k])}};
            ahead->knot[++ahead->knots] = last;
        }
    }
    if (ahead->knots > 0) {
        two_body_at(&ahead->orbit, last.t, &r, &v);
    }
    const Target lvlh = controller_planned_lvlh(r, v);
    const Matrix Q = multiply(transposed(lvlh.R), last.target.R);
    const bool still = norm(subtract(last.target.Omega, apply_transposed(Q, lvlh.Omega))) < STILL;
    ahead->target_kind = still ? ONBOARD_TARGET_LVLH : ONBOARD_TARGET_TURNING;
    ahead->R_d0 = still ? Q : last.target.R;
    ahead->Omega_d0 = last.target.Omega;
    ahead->dOmega_d0 = ahead->knots > 0 ? (Vector){0.0, 0.0, 0.0} : vector(u->dOmega_ref);
    ahead->given_t = last.t;
}

Ahead controller_planned_ahead_of(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                  const ControllerPlannedInputs *u)
{
    const TwoBody orbit = {x->t, law->p.gravitational_parameter, vector(u->r_N), vector(u->v_N)};
    Ahead ahead = {.field = &law->field,
                   .orbit = orbit,
                   .bias_N = x->field_bias_N,
                   .bias_t = x->t,
                   .profile = x->strained ? &x->profile : NULL,
                   .target_kind = law->p.reference,
                   .R_d0 = law->R_d0};
    if (controller_planned_has_R_ref(u)) {
        extrapolate(u, law->p.control_period, &ahead);
    }
    return ahead;
}

Motion controller_planned_corrected(const ControllerPlannedState *x, Matrix R, Vector Omega, double l)
{
    const Motion *was = &x->predicted;
    double innovation[MOTION], correction[MOTION] = {0.0};
    store(rotation_log(multiply(transposed(was->R), R)), innovation);
    store(subtract(subtract(Omega, x->identification.bias), was->Omega), innovation + RATE_STATE);
    for (int i = 0; i < MOTION; ++i) {
        for (int j = 0; j < MOTION; ++j) {
            correction[i] += x->identification.gain[i][j] * innovation[j];
        }
    }
    return (Motion){multiply(was->R, rotation_exp(vector(correction))),
                    add(was->Omega, vector(correction + RATE_STATE)), l};
}

/* Whether the rods can be watched: the field is a magnetometer's, or turned by an attitude that is known well. */
static bool shows_rods(const ControllerPlannedInputs *u)
{
    return !is_lost(u->field_health) || norm(vector(u->attitude_sigma_B)) < TURNED;
}

/* The motion before the measurement, its covariance, and what the measurement tells. */
static void filter(const ControllerPlannedLaw *law, ControllerPlannedState *x, const Motion *measured, Vector B_B,
                   const double given[CONTROLS], const Around *around, double dt, bool watched)
{
    Model model = controller_planned_estimated(law, x), nominal = controller_planned_nominal(law, &x->scales);
    Around then = *around;
    then.B_N = apply(x->estimate.R, x->B_B);
    model.wheel_torque_max = nominal.wheel_torque_max;
    model.wheel_momentum_max = nominal.wheel_momentum_max = INFINITY;
    nominal.disturbance_B = model.disturbance_B;
    nominal.residual_B = model.residual_B;
    x->predicted = controller_planned_advanced(&model, &then, &x->estimate, given, dt);
    Vector rods[3];
    for (int i = 0; i < 3; ++i) {
        rods[i] = scale(given[i], nominal.rods[i]);
        nominal.rods[i] = scale(law->p.rod_gains0[i], nominal.rods[i]);
    }
    const Motion by_start = controller_planned_advanced(&nominal, &then, &x->estimate, given, dt);
    const Passed passed = {dt, &model, &then, x->estimate, x->predicted, scale(0.5, add(x->B_B, B_B)), rods};
    controller_planned_propagate(&passed, &x->identification);
    const Vector Omega = subtract(measured->Omega, vector(x->identification.p + BIAS));
    controller_planned_learn(dt, rotation_log(multiply(transposed(x->predicted.R), measured->R)),
                             subtract(Omega, x->predicted.Omega), subtract(Omega, by_start.Omega), watched,
                             &x->identification);
}

/* The measured field less the onboard model's B_N, smoothed. */
static Vector field_bias(const ControllerPlannedState *x, Matrix R, Vector b_B, Vector B_N, double dt, bool first)
{
    const Vector bias = subtract(apply(R, b_B), B_N);
    const Vector b =
        first ? bias : add(x->field_bias_N, scale(smaller(dt / BIAS_TIME, 1.0), subtract(bias, x->field_bias_N)));
    const double size = norm(b);
    return size > BIAS_MAX ? scale(BIAS_MAX / size, b) : b;
}

Around controller_planned_take_sample(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                                      const ControllerPlannedInputs *u, bool first)
{
    const ControllerPlannedParameters *p = &law->p;
    const double dt = first ? p->control_period : x->t - x->t_sample;
    controller_planned_set_noise(p, u, &x->identification);
    controller_planned_set_taught(!is_lost(u->rate_health), &x->identification);
    controller_planned_set_disturbance(&x->scales, x->strained, &x->identification);
    const Vector bias = vector(x->identification.p + BIAS);
    if (p->find_failures) {
        controller_planned_watch_attitude(dt, x->scales.time, p->attitude_noise, matrix(u->R_NB), x->estimate.Omega,
                                          subtract(vector(u->omega_B), bias), &x->sensors);
    }
    const Matrix R = attitude_of(x, u);
    double given[CONTROLS] = {0.0, 0.0, 0.0, 0.0};
    const TwoBody orbit = {x->t, p->gravitational_parameter, vector(u->r_N), vector(u->v_N)};
    Around around = controller_planned_around_of(&law->field, &orbit, x->t);
    if (p->find_failures && has_field(u)) {
        controller_planned_watch_field(dt, x->scales.time, law->field_tolerance, vector(u->b_B),
                                       apply_transposed(R, around.B_N), &x->sensors);
    }
    if (uses_field(x, u)) {
        x->field_bias_N = field_bias(x, R, vector(u->b_B), around.B_N, dt, first);
    }
    if (x->sensors.field_failed) {
        x->field_bias_N = (Vector){0.0, 0.0, 0.0};
    }
    around.B_N = add(around.B_N, x->field_bias_N);
    const Vector B_B = uses_field(x, u) ? vector(u->b_B) : apply_transposed(R, around.B_N);
    if (!first) {
        controller_planned_given(law, x, u, dt, given);
        const double l = x->l_own + dt * p->wheel_torque_max * given[3];
        x->l_own = clip(l, -p->wheel_momentum_max, p->wheel_momentum_max);
    }
    x->l_own = wheel_momentum(x, u);
    const Motion measured = {R, vector(u->omega_B), x->l_own};
    if (!first) {
        /* What rods give shows only where their commands and the field are known. */
        const bool watched = p->find_failures && x->identification.spread > 0.0 &&
                             controller_planned_has_u_applied(u) && has_field(u) && shows_rods(u);
        filter(law, x, &measured, B_B, given, &around, dt, watched);
        if (controller_planned_has_h_w(u) && controller_planned_has_u_applied(u) && !x->momentum.blind) {
            controller_planned_friction_learn(dt, u->u_applied[3], x->measured.l, measured.l, &x->friction);
        }
    }
    /* Also after a measurement so wrong that nothing follows from it. */
    if (first || !is_finite(apply(x->predicted.R, x->predicted.Omega))) {
        x->predicted = measured;
    }
    x->estimate = controller_planned_corrected(x, R, measured.Omega, measured.l);
    controller_planned_profile_keep(x->t, x->scales.period, vector(x->identification.p + TORQUE), x->strained,
                                    &x->profile);
    x->t_sample = x->t;
    x->measured = measured;
    x->B_B = B_B;
    return around;
}
