/* What the controller believes of the satellite: its motion, its properties, the field round it. */
#include "state.h"

#include <string.h>

static const double MODEL_SHARE = 0.1;                 /* of a change of rate by the model that may be wrong */
static const double MODEL_REST_TIMES = 400.0;          /* 1/(T^2 rad/s^2) by which it may be wrong at rest */
static const double CHANGE_MAX = 250.0;                /* 1/T^2 that rods and wheel may give to a light satellite */
static const double GYROSCOPIC = 2.0;                  /* rad/s^2 per rad^2/s^2 that a body may give to itself */
static const double CHANGE_NOISE = 20.0;               /* standard deviations of the rate by which a difference may be wrong */
static const double BIAS_TIME = 60.0, BIAS_MAX = 2e-5; /* s, T */
static const double RATIO_MAX = 1e3;                   /* of step over noise, from which a measurement counts alone */
static const double NOISE_MIN = 1e-300;                /* keeps a noise of zero from dividing */

/* The rods' dipoles at their limit. */
static void set_rods(const ControllerPlannedLaw *law, double dipole_max, Model *model)
{
    model->rods[0] = scale(dipole_max, law->rod_axes.a);
    model->rods[1] = scale(dipole_max, law->rod_axes.b);
    model->rods[2] = scale(dipole_max, law->rod_axes.c);
}

Model controller_planned_nominal(const ControllerPlannedLaw *law, const Scales *scales)
{
    const ControllerPlannedParameters *p = &law->p;
    Model model = {.J = matrix(p->J_B),
                   .wheel_axis = law->wheel_axis,
                   .wheel_torque_max = p->wheel_torque_max,
                   .wheel_momentum_max = p->wheel_momentum_max,
                   .scales = *scales};
    model.J_inverse = inverse(model.J);
    set_rods(law, p->dipole_max, &model);
    if (controller_planned_has_K0(p)) {
        model.scales.K = vector(p->K0);
    }
    if (controller_planned_has_L0(p)) {
        model.scales.L = matrix(p->L0);
    }
    return model;
}

Model controller_planned_believed(const ControllerPlannedLaw *law, const ControllerPlannedState *x)
{
    const ControllerPlannedParameters *p = &law->p;
    Model model = controller_planned_nominal(law, &x->scales);
    model.J.a.x = x->identification.p[0];
    model.J.b.y = x->identification.p[1];
    model.J.c.z = x->identification.p[2];
    Fault unused;
    if (!is_inertia(model.J, "", &unused)) {
        model.J = matrix(p->J_B); /* large products of inertia, which are not estimated, may not fit what is */
    }
    model.J_inverse = inverse(model.J);
    set_rods(law, p->dipole_max * x->identification.p[GAIN], &model);
    model.disturbance_B = vector(x->identification.p + TORQUE);
    model.residual_B = vector(x->identification.p + DIPOLE);
    return model;
}

static const double STILL = 5e-5; /* rad/s relative to LVLH, below which a reference keeps its attitude to it */

/* Of a given reference, what is known of it, and what comes after: it keeps its attitude to LVLH where it has next to no rate
 * relative to it, else its body rate. */
static void extrapolate(const ControllerPlannedInputs *u, double period, Ahead *ahead)
{
    Knot last = {ahead->orbit.t, {matrix(u->R_ref), vector(u->Omega_ref)}};
    if (is_zero_matrix(last.target.R)) {
        ahead->target_kind = ONBOARD_TARGET_NONE;
        return;
    }
    Vector r = ahead->orbit.r, v = ahead->orbit.v;
    ahead->knot[0] = last;
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
    ahead->target_kind = still ? ONBOARD_TARGET_WITH_LVLH : ONBOARD_TARGET_TURNING;
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
                   .target_kind = law->p.reference,
                   .R_d0 = law->R_d0};
    if (controller_planned_has_R_ref(u)) {
        extrapolate(u, law->p.control_period, &ahead);
    }
    return ahead;
}

/* What rods and wheel gave over the last sample: u_applied, or else what was asked for; the wheel from h_w where connected. */
static void applied(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u,
                    double dt, double given[CONTROLS])
{
    const ControllerPlannedParameters *p = &law->p;
    memcpy(given, x->u, sizeof x->u);
    if (controller_planned_has_u_applied(u)) {
        for (int i = 0; i < 3; ++i) {
            given[i] = u->u_applied[i] / p->dipole_max;
        }
        given[3] = u->u_applied[3] / p->wheel_torque_max;
    }
    if (controller_planned_has_h_w(u)) {
        given[3] = (u->h_w - x->measured.l) / (dt * p->wheel_torque_max);
    }
}

/* Steady gain of a Kalman filter for a random walk, of the walk's step over the measurement's noise. */
static double filter_gain(double step, double noise)
{
    const double ratio = step / larger(noise, NOISE_MIN);
    return ratio > RATIO_MAX ? 1.0 : 0.5 * ratio * (sqrt(ratio * ratio + 4.0) - ratio);
}

/* The estimate of attitude and rate before the measurement, and how far the measurement moves it. */
static void predict(const ControllerPlannedLaw *law, ControllerPlannedState *x, const double given[CONTROLS],
                    const Around *around, double dt)
{
    const ControllerPlannedParameters *p = &law->p;
    const double T = x->scales.time;
    Model model = controller_planned_believed(law, x);
    model.wheel_momentum_max = INFINITY;
    Around then = *around;
    then.B_N = apply(x->estimate.R, x->B_B);
    x->predicted = controller_planned_advanced(&model, &then, &x->estimate, given, dt);

    const Vector Omega = x->predicted.Omega;
    const double change = norm(subtract(Omega, x->estimate.Omega)) + dt * dot(Omega, Omega);
    const double step = MODEL_SHARE * change + dt / (MODEL_REST_TIMES * T * T);
    x->rate_gain = filter_gain(step, p->rate_noise);
    x->attitude_gain = filter_gain((sqrt(x->rate_gain) * p->rate_noise + step) * dt, p->attitude_noise);
}

Motion controller_planned_corrected(const ControllerPlannedState *x, Matrix R, Vector Omega, double l)
{
    const Motion *was = &x->predicted;
    const Vector turn = scale(x->attitude_gain, rotation_log(multiply(transposed(was->R), R)));
    return (Motion){multiply(was->R, rotation_exp(turn)), add(was->Omega, scale(x->rate_gain, subtract(Omega, was->Omega))), l};
}

/* Disturbance, own dipole, inertia and rod gain from the sample that ends now. */
static void learn(const ControllerPlannedLaw *law, ControllerPlannedState *x, const Motion *now, Vector B_B,
                  const double given[CONTROLS], const Around *around, double dt)
{
    const ControllerPlannedParameters *p = &law->p;
    const double T = x->scales.time;
    const Vector change = scale(1.0 / dt, subtract(now->Omega, x->measured.Omega));
    const double slower = smaller(norm(now->Omega), norm(x->measured.Omega));
    if (!(norm(change) < GYROSCOPIC * slower * slower + CHANGE_MAX / (T * T) + CHANGE_NOISE * p->rate_noise / dt)) {
        x->identification.elapsed = 0.0; /* no body changes its rate like that: the window begins anew */
        return;
    }
    Model nominal = controller_planned_believed(law, x);
    set_rods(law, p->dipole_max, &nominal);
    const Vector tau_rods = cross(rods_dipole(&nominal, given), scale(0.5, add(x->B_B, B_B)));
    /* The products of inertia are taken as they are given. */
    Matrix products = matrix(p->J_B);
    products.a.x = products.b.y = products.c.z = 0.0;
    const Vector middle = scale(0.5, add(x->measured.Omega, now->Omega));
    const Vector known = subtract(gravity_gradient(nominal.J, around, now->R),
                                  add(cross(middle, apply(products, middle)), apply(products, change)));
    controller_planned_identify(dt, law->wheel_axis, x->measured.Omega, now->Omega, x->measured.l, now->l, tau_rods, known,
                                scale(0.5, add(x->B_B, B_B)), p->identify, &x->identification);
}

/* The measured field less the onboard model's B_N, smoothed. */
static Vector field_bias(const ControllerPlannedState *x, Matrix R, Vector b_B, Vector B_N, double dt, bool first)
{
    const Vector bias = subtract(apply(R, b_B), B_N);
    const Vector b = first ? bias : add(x->field_bias_N, scale(smaller(dt / BIAS_TIME, 1.0), subtract(bias, x->field_bias_N)));
    const double size = norm(b);
    return size > BIAS_MAX ? scale(BIAS_MAX / size, b) : b;
}

Around controller_planned_take_sample(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                                      const ControllerPlannedInputs *u, bool first)
{
    const ControllerPlannedParameters *p = &law->p;
    const double dt = first ? p->control_period : x->t - x->t_sample;
    const Matrix R = matrix(u->R_NB);
    double given[CONTROLS] = {0.0, 0.0, 0.0, 0.0};
    Ahead ahead = controller_planned_ahead_of(law, x, u);
    ahead.bias_N = (Vector){0.0, 0.0, 0.0};
    Around around = controller_planned_around_at(&ahead, x->t);
    if (has_field(u)) {
        x->field_bias_N = field_bias(x, R, vector(u->b_B), around.B_N, dt, first);
    }
    around.B_N = add(around.B_N, x->field_bias_N);
    const Vector B_B = has_field(u) ? vector(u->b_B) : apply_transposed(R, around.B_N);
    if (!first) {
        applied(law, x, u, dt, given);
        const double l = x->l_own + dt * p->wheel_torque_max * given[3];
        x->l_own = clip(l, -p->wheel_momentum_max, p->wheel_momentum_max);
    }
    if (controller_planned_has_h_w(u)) {
        x->l_own = u->h_w;
    }
    const Motion measured = {R, vector(u->omega_B), x->l_own};
    if (!first) {
        learn(law, x, &measured, B_B, given, &around, dt);
        predict(law, x, given, &around, dt);
    }
    /* Also after a measurement so wrong that nothing follows from it. */
    if (first || !is_finite(apply(x->predicted.R, x->predicted.Omega))) {
        x->predicted = measured;
        x->rate_gain = x->attitude_gain = 1.0;
    }
    x->estimate = controller_planned_corrected(x, R, measured.Omega, measured.l);
    x->t_sample = x->t;
    x->measured = measured;
    x->B_B = B_B;
    return around;
}
