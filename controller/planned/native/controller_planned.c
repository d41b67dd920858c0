#include "controller_planned.h"

#include <string.h>

static const double ATTITUDE_TOLERANCE = 1e-4;  /* of R_NB: a single-precision plant stays well below it */
static const double REFERENCE_TOLERANCE = 1e-3; /* of R_d0, which may be typed from four printed decimals */
static const double R_MIN = 1e6;                /* m */
static const double COLLINEAR = 1e-6;           /* |r x v|/(|r||v|) below which the orbit has no plane */
static const double RATE_MAX = 0.06;            /* rad/s, from which a plan of all its stages still succeeds */
static const double FIELD_MAX = 1e-3;           /* T; no orbit has more, so a larger field is in another unit */
static const double EARLY = 1e-6;               /* of the control period: a sample is due that much before its time */

static const int ITERATIONS = 5;
static const double CHALLENGE_PERIOD = 30.0;    /* s */
static const double HOLD_COST = 10.0;           /* of a plan that is challenged in the hold too: it has a turn in it */
static const double CHALLENGE_GAIN = 0.97;      /* a challenger is adopted below this share of the plan's cost */
static const double STEERING_DIPOLE = 1.12;     /* of dipole_max: what three rods give across the field */
static const double STEERING_AGAIN = 2.0;       /* of steering_limit: back to steering beyond it */
static const double STEERING_LEFT = 150.0;      /* s of steering, beyond which it goes on down to the next share */
static const double STEERING_DONE = 0.4;        /* of steering_limit */
static const double WHEEL_REST = 10.0;          /* s, over which the wheel is brought to rest while steering */
static const double SETTLED_ANGLE = 0.0174532925, SETTLED_RATE = 1e-3, SETTLED_TIME = 60.0;
static const double LOST_ANGLE = 0.0872664626;
static const double MODEL_SHARE = 0.1;          /* of a change of rate by the model that may be wrong */
static const double MODEL_REST = 1e-6;          /* rad/s^2 that it may be wrong at rest */
static const double CHANGE_MAX = 0.1;           /* rad/s^2 that rods and wheel may give to a light satellite */
static const double BIAS_TIME = 60.0, BIAS_MAX = 2e-5; /* s, T */

/* No orbit has a field of exactly zero. */
static bool has_field(const ControllerPlannedInputs *u)
{
    return controller_planned_has_b_B(u) && (u->b_B[0] != 0.0 || u->b_B[1] != 0.0 || u->b_B[2] != 0.0);
}

bool controller_planned_check(const ControllerPlannedParameters *p, Fault *f)
{
    const Named positive[] = {
        {"control_period", p->control_period},       {"dipole_max", p->dipole_max},
        {"wheel_torque_max", p->wheel_torque_max},   {"wheel_momentum_max", p->wheel_momentum_max},
        {"plan_period", p->plan_period},             {"steering_limit", p->steering_limit},
        {"disturbance_time", p->disturbance_time},   {"gravitational_parameter", p->gravitational_parameter},
    };
    if (!all_positive(positive, sizeof positive / sizeof positive[0], f)) {
        return false;
    }
    if (p->reference != CONTROLLER_PLANNED_REFERENCE_LVLH && p->reference != CONTROLLER_PLANNED_REFERENCE_INERTIAL) {
        return fault(f, "reference", p->reference, "1 (lvlh) or 2 (inertial); the planned controller does not offer 3 (rate)");
    }
    const struct {
        const char *name;
        int32_t value, low, high;
        const char *expected;
    } counts[] = {
        {"field_model", p->field_model, CONTROLLER_PLANNED_FIELD_MODEL_IGRF14, CONTROLLER_PLANNED_FIELD_MODEL_WMM2025, "1 to 5"},
        {"field_degree", p->field_degree, 1, ONBOARD_DEGREE_MAX, "1 to 13"},
        {"search_iterations", p->search_iterations, 1, 1000, "1 to 1000"},
    };
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        if (counts[i].value < counts[i].low || counts[i].value > counts[i].high) {
            return fault(f, counts[i].name, counts[i].value, counts[i].expected);
        }
    }
    if (!is_inertia(matrix(p->J_B), "J_B", f) || !is_positive_definite(matrix(p->L0), "L0", f) || !is_ascending(p->K0, f)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        const double length = norm(vector(p->rod_axes[i]));
        if (!(fabs(length - 1.0) <= 1e-6)) {
            return fault(f, "rod_axes", length, "rows of unit length to 1e-06");
        }
    }
    const double volume = fabs(determinant(matrix(p->rod_axes)));
    if (!(volume > 1e-6)) {
        return fault(f, "rod_axes", volume, "linearly independent axes, |det| above 1e-06");
    }
    Epoch epoch;
    if (!is_epoch(p->epoch, &epoch, f)) {
        return false;
    }
    const GaussModel *model = &gauss_models[p->field_model - 1];
    const double year = year_of_days(days_of_epoch(&epoch));
    if (!(year >= model->years[0] && year <= model->valid_until)) {
        return fault(f, "epoch", year, model->covered);
    }
    return is_rotation(matrix(p->R_d0), REFERENCE_TOLERANCE, "R_d0", "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001", f);
}

void controller_planned_prepare(const ControllerPlannedParameters *p, ControllerPlannedLaw *law)
{
    Epoch epoch = {0, 0, 0, 0};
    law->p = *p;
    law->R_d0 = nearest_rotation(matrix(p->R_d0));
    for (int i = 0; i < 3; ++i) {
        const Vector axis = vector(p->rod_axes[i]);
        law->rod_axes[i] = scale(1.0 / norm(axis), axis);
    }
    (void)epoch_read(p->epoch, &epoch);
    onboard_field(&gauss_models[p->field_model - 1], days_of_epoch(&epoch), p->field_degree, p->field_error, &law->field);
}

static bool inputs_fit(const ControllerPlannedInputs *u, double mu, Fault *f)
{
    const struct {
        const char *name;
        Vector value;
    } inputs[] = {{"omega_B", vector(u->omega_B)}, {"r_N", vector(u->r_N)}, {"v_N", vector(u->v_N)}, {"b_B", vector(u->b_B)}};
    for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; ++i) {
        if (!is_finite(inputs[i].value)) {
            return fault(f, inputs[i].name, NAN, "finite numbers");
        }
    }
    if (controller_planned_has_b_B(u) && norm(vector(u->b_B)) > FIELD_MAX) {
        return fault(f, "b_B", norm(vector(u->b_B)), "a field in tesla, |b_B| at most 0.001 (or 1e9: not connected)");
    }
    if (!isfinite(u->h_w)) {
        return fault(f, "h_w", u->h_w, "a finite number");
    }
    for (int i = 0; i < CONTROLS; ++i) {
        if (!isfinite(u->u_applied[i])) {
            return fault(f, "u_applied", u->u_applied[i], "finite numbers");
        }
    }
    const Vector r_N = vector(u->r_N), v_N = vector(u->v_N);
    const double r = norm(r_N), v = norm(v_N);
    if (!(r >= R_MIN)) {
        return fault(f, "r_N", r, "at least 1000 km from the Earth's centre");
    }
    if (!(norm(cross(r_N, v_N)) > COLLINEAR * r * v)) {
        return fault(f, "v_N", norm(cross(r_N, v_N)), "a velocity that spans the orbit's plane with r_N, |r x v| above 0");
    }
    if (!(0.5 * v * v < 0.999 * mu / r)) {
        return fault(f, "v_N", v, "the velocity of a closed orbit, below that of escape");
    }
    return is_rotation(matrix(u->R_NB), ATTITUDE_TOLERANCE, "R_NB", "a rotation matrix, max |R_NB^T R_NB - I| at most 0.0001", f);
}

/* ---------------------------------------------------------------- what the controller believes */

static Model believed(const ControllerPlannedLaw *law, const ControllerPlannedState *x)
{
    const ControllerPlannedParameters *p = &law->p;
    Model model;
    model.J = matrix(p->J_B);
    model.J.a.x = x->identification.p[0];
    model.J.b.y = x->identification.p[1];
    model.J.c.z = x->identification.p[2];
    Fault unused;
    if (!is_inertia(model.J, "", &unused)) {
        model.J = matrix(p->J_B); /* large products of inertia, which are not estimated, may not fit what is */
    }
    model.J_inverse = inverse(model.J);
    for (int i = 0; i < 3; ++i) {
        model.rods[i] = scale(p->dipole_max * x->identification.p[GAIN], law->rod_axes[i]);
    }
    model.wheel_torque_max = p->wheel_torque_max;
    model.wheel_momentum_max = p->wheel_momentum_max;
    model.disturbance_B = vector(x->identification.p + TORQUE);
    model.residual_B = vector(x->identification.p + DIPOLE);
    return model;
}

static Ahead ahead_of(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    const OnboardOrbit orbit = {x->t, law->p.gravitational_parameter, vector(u->r_N), vector(u->v_N)};
    return (Ahead){&law->field, orbit, x->field_bias_N, x->t, law->p.reference, law->R_d0};
}

/* What was given over the last sample: as told, else as asked for; the wheel by its momentum, where that is measured. */
static void applied(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u, double dt,
                    double given[CONTROLS])
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
    const double ratio = step / larger(noise, 1e-300);
    return ratio > 1e3 ? 1.0 : 0.5 * ratio * (sqrt(ratio * ratio + 4.0) - ratio);
}

/* The estimate of attitude and rate before the measurement, and how far the measurement moves it. */
static void predict(const ControllerPlannedLaw *law, ControllerPlannedState *x, const double given[CONTROLS],
                    const Around *around, double dt)
{
    const ControllerPlannedParameters *p = &law->p;
    Model model = believed(law, x);
    model.wheel_momentum_max = INFINITY;
    Around then = *around;
    then.B_N = apply(x->estimate.R, x->B_B);
    x->predicted = advanced(&model, &then, &x->estimate, given, dt);

    const Vector Omega = x->predicted.Omega;
    const double change = norm(subtract(Omega, x->estimate.Omega)) + dt * dot(Omega, Omega);
    const double step = MODEL_SHARE * change + MODEL_REST * dt;
    x->rate_gain = filter_gain(step, p->rate_noise);
    x->attitude_gain = filter_gain((sqrt(x->rate_gain) * p->rate_noise + step) * dt, p->attitude_noise);
}

/* The estimate after the measurement. */
static Motion corrected(const ControllerPlannedState *x, Matrix R, Vector Omega, double l)
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
    const Vector change = scale(1.0 / dt, subtract(now->Omega, x->measured.Omega));
    const double slower = smaller(norm(now->Omega), norm(x->measured.Omega));
    if (!(norm(change) < 2.0 * slower * slower + CHANGE_MAX + 20.0 * p->rate_noise / dt)) {
        x->identification.elapsed = 0.0; /* no body changes its rate like that: the window begins anew */
        return;
    }
    Model nominal = believed(law, x);
    for (int i = 0; i < 3; ++i) {
        nominal.rods[i] = scale(p->dipole_max, law->rod_axes[i]);
    }
    const Vector tau_rods = cross(rods_dipole(&nominal, given), scale(0.5, add(x->B_B, B_B)));
    /* The products of inertia are taken as they are given. */
    Matrix products = matrix(p->J_B);
    products.a.x = products.b.y = products.c.z = 0.0;
    const Vector middle = scale(0.5, add(x->measured.Omega, now->Omega));
    const Vector known = subtract(gravity_gradient(nominal.J, around, now->R),
                                  add(cross(middle, apply(products, middle)), apply(products, change)));
    identify(dt, x->measured.Omega, now->Omega, x->measured.l, now->l, tau_rods, known, scale(0.5, add(x->B_B, B_B)),
             p->identify, &x->identification);
}

/* ---------------------------------------------------------------- what it decides */

static Vector momentum_to_give(const Model *model, const Motion *now, const Target *target)
{
    Vector Pi = apply(model->J, now->Omega);
    Pi.x += now->l;
    return subtract(apply(target->R, apply(model->J, target->Omega)), apply(now->R, Pi));
}

/* The plan that was, from here and now on. */
static void renew(ControllerPlannedLaw *law, const Model *model, const Ahead *ahead, const Motion *now, double t, const Plan *was,
                  Plan *plan)
{
    lay_stages(model, ahead, now, t, was, plan, &law->workspace);
    improve(model, now, ITERATIONS, plan, &law->workspace);
}

/* At the first sample there is no time to keep, and no motion to go on with: the search is made whole. */
static void decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Motion *now, double dt,
                   bool first)
{
    const ControllerPlannedParameters *p = &law->p;
    const Model model = believed(law, x);
    const Target target = target_at(ahead, x->t);
    const Matrix Q = multiply(transposed(target.R), now->R);
    const double angle = principal_angle(Q), rate = norm(subtract(now->Omega, apply_transposed(Q, target.Omega)));
    const Vector D_N = momentum_to_give(&model, now, &target);
    const double early = EARLY * p->control_period;

    if (!(angle < SETTLED_ANGLE && rate < SETTLED_RATE)) {
        x->settled_since = INFINITY;
    } else if (x->settled_since > x->t) {
        x->settled_since = x->t;
    }
    const double least = smaller(p->J_B[0][0], smaller(p->J_B[1][1], p->J_B[2][2]));
    const double left = norm(D_N) / smaller(p->steering_limit, RATE_MAX * least);
    const bool steering = x->phase == PHASE_STEERING;
    const bool far = x->steering.time > STEERING_LEFT && left > STEERING_DONE;
    const bool lost = steering ? left > 1.0 || far : left > STEERING_AGAIN;

    /* A search for a plan from nothing ends after some samples; until then all goes on as it was. */
    Search *search = &x->search;
    if (lost) {
        search->active = search->ready = false;
    } else if (!search->active && !search->ready &&
               (steering || ((x->phase == PHASE_ACQUISITION || x->plan.cost > HOLD_COST) && x->t >= x->next_challenge - early))) {
        search_begin(now, x->t, search);
    }
    search_on(&model, ahead, first ? INT32_MAX : p->search_iterations, search, &law->workspace);

    bool due = x->t >= x->next_plan - early;
    if (lost) {
        due = due || !steering;
        x->phase = PHASE_STEERING;
    } else if (steering && search->ready) {
        due = true;
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_HOLD && angle > LOST_ANGLE) {
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_ACQUISITION && x->t - x->settled_since >= SETTLED_TIME) {
        x->phase = PHASE_HOLD;
    }

    if (x->phase == PHASE_STEERING) {
        if (due) {
            steer(ahead, x->t, D_N, STEERING_DIPOLE * p->dipole_max * x->identification.p[GAIN], law->steering_field, &x->steering);
            x->next_plan = x->t + p->plan_period;
        } else {
            x->steering.time = larger(x->steering.time - dt, 0.0);
        }
        x->reference = (Motion){target.R, target.Omega, 0.0};
        x->plan.stages = 0;
        x->plan.cost = 0.0;
        return;
    }
    if (!due) {
        return;
    }
    x->next_plan = x->t + p->plan_period;
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
    const bool fresh = x->plan.stages == 0;
    if (!fresh) {
        renew(law, &model, ahead, now, x->t, &x->plan, &law->trial);
        memcpy(&x->plan, &law->trial, sizeof x->plan);
    }
    if (search->ready) {
        renew(law, &model, ahead, now, x->t, &search->best, &law->trial);
        if (fresh || law->trial.cost < CHALLENGE_GAIN * x->plan.cost) {
            memcpy(&x->plan, &law->trial, sizeof x->plan);
        }
        search->ready = false;
        x->next_challenge = x->t + CHALLENGE_PERIOD;
    }
    x->reference = *now;
}

/* ---------------------------------------------------------------- what it commands */

/* All outputs of the inputs as they stand, on what was decided at the sample x->t. */
static void command(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u,
                    const Motion *now, double controls[CONTROLS], ControllerPlannedOutputs *y)
{
    const ControllerPlannedParameters *p = &law->p;
    const Model model = believed(law, x);
    const Ahead ahead = ahead_of(law, x, u);
    const Around around = around_at(&ahead, x->t);
    const Target target = target_at(&ahead, x->t);
    const Matrix R = now->R, J = model.J;
    const Vector Omega = now->Omega;
    const double l = now->l;
    const Vector B_B = has_field(u) ? vector(u->b_B) : apply_transposed(R, around.B_N);
    const Vector M_g = gravity_gradient(J, &around, R);

    const Matrix Q_target = multiply(transposed(target.R), R);
    y->attitude_error = principal_angle(Q_target);
    store(subtract(Omega, apply_transposed(Q_target, target.Omega)), y->rate_error_B);

    /* The law [8] on the reference; Q^T e_i is row i of Q. */
    const Motion *d = &x->reference;
    const bool steering = x->phase == PHASE_STEERING;
    Vector dOmega_d = {0.0, 0.0, 0.0};
    if (!steering) {
        plan_at(&x->plan, x->t + 0.5 * p->control_period, controls);
        dOmega_d = acceleration(&model, &around, d, controls);
    }
    const Matrix Q = multiply(transposed(d->R), R);
    const Vector w = apply_transposed(Q, d->Omega), omega = subtract(Omega, w);
    const Vector K = vector(p->K0);
    const Vector gradient = {K.y * Q.b.z - K.z * Q.c.y, K.z * Q.c.x - K.x * Q.a.z, K.x * Q.a.y - K.y * Q.b.x};
    y->lyapunov = 0.5 * dot(omega, apply(J, omega)) + dot(K, (Vector){1.0 - Q.a.x, 1.0 - Q.b.y, 1.0 - Q.c.z});
    if (steering) {
        steering_rods(&x->steering, R, B_B, model.rods, controls);
        controls[3] = larger(smaller(-l / (WHEEL_REST * p->wheel_torque_max), 1.0), -1.0);
        Vector tau = cross(rods_dipole(&model, controls), B_B);
        tau = subtract(tau, cross(Omega, (Vector){l, 0.0, 0.0}));
        tau.x -= p->wheel_torque_max * controls[3];
        store(tau, y->tau_cmd_B);
    } else {
        Vector tau = add(scale(-1.0, apply(matrix(p->L0), omega)), gradient);
        tau = add(tau, add(apply(J, apply_transposed(Q, dOmega_d)), cross(w, apply(J, w))));
        const Vector unwanted = add(model.disturbance_B, cross(model.residual_B, B_B));
        store(subtract(tau, add(M_g, unwanted)), y->tau_cmd_B);
    }
    for (int i = 0; i < 3; ++i) {
        y->dipole_ff[i] = p->dipole_max * controls[i];
    }
    y->wheel_torque_ff = p->wheel_torque_max * controls[3];
    y->gain_k = 1.0;
    y->gain_l = 1.0;
    store_matrix(d->R, y->R_d);
    store(d->Omega, y->Omega_d);
    store(dOmega_d, y->dOmega_d);
    y->h_w_ref = d->l;
    y->plan_cost = may_be_flown(&x->plan) ? x->plan.cost : -1.0;
    y->phase = x->phase;
    store(model.disturbance_B, y->disturbance_B);
    store(model.residual_B, y->residual_dipole_estimate_B);
    store_matrix(J, y->J_estimate_B);
    y->rod_gain_estimate = x->identification.p[GAIN];
    y->h_w_estimate = l;
}

/* The control acts: x->t is the time of the inputs. */
static void sample(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, bool first)
{
    const ControllerPlannedParameters *p = &law->p;
    const double dt = first ? p->control_period : x->t - x->t_sample;
    const bool measured_field = has_field(u);
    const Matrix R = matrix(u->R_NB);
    double given[CONTROLS] = {0.0, 0.0, 0.0, 0.0};
    Ahead ahead = ahead_of(law, x, u);
    ahead.bias_N = (Vector){0.0, 0.0, 0.0};
    const Around here = around_at(&ahead, x->t);
    if (measured_field) {
        const Vector bias = subtract(apply(R, vector(u->b_B)), here.B_N);
        Vector b = first ? bias : add(x->field_bias_N, scale(smaller(dt / BIAS_TIME, 1.0), subtract(bias, x->field_bias_N)));
        const double size = norm(b);
        x->field_bias_N = size > BIAS_MAX ? scale(BIAS_MAX / size, b) : b;
    }
    ahead = ahead_of(law, x, u);
    const Around around = {add(here.B_N, x->field_bias_N), here.r_hat_N, here.rate_squared};
    const Vector B_B = measured_field ? vector(u->b_B) : apply_transposed(R, around.B_N);
    if (!first) {
        applied(law, x, u, dt, given);
        const double l = x->l_own + dt * p->wheel_torque_max * given[3];
        x->l_own = larger(smaller(l, p->wheel_momentum_max), -p->wheel_momentum_max);
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
    if (first || !is_finite_matrix(x->predicted.R) || !is_finite(x->predicted.Omega)) {
        x->predicted = measured;
        x->rate_gain = x->attitude_gain = 1.0;
    }
    const Motion now = x->estimate = corrected(x, R, measured.Omega, measured.l);
    if (!first && x->phase != PHASE_STEERING) {
        const Model model = believed(law, x);
        x->reference = advanced(&model, &around, &x->reference, x->u, dt);
    }
    decide(law, x, &ahead, &now, dt, first);
    x->t_sample = x->t;
    x->measured = measured;
    x->B_B = B_B;
    x->sampled = true;
    command(law, x, u, &now, x->u, &x->held);
}

bool controller_planned_start(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x, Fault *f)
{
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    memset(x, 0, sizeof *x);
    const double inertia[3] = {law->p.J_B[0][0], law->p.J_B[1][1], law->p.J_B[2][2]};
    identification_start(inertia, law->p.identify_spread, law->p.disturbance_max, law->p.disturbance_time,
                         law->p.residual_dipole_max, law->p.rate_noise, &x->identification);
    x->phase = PHASE_STEERING;
    x->settled_since = INFINITY;
    x->until_sample = law->p.control_period;
    sample(law, x, u, true);
    return true;
}

bool controller_planned_outputs(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, ControllerPlannedOutputs *y, Fault *f)
{
    *y = x->held;
    if (!x->sampled) {
        return true;
    }
    double controls[CONTROLS];
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    const double l = controller_planned_has_h_w(u) ? u->h_w : x->l_own;
    const Motion now = corrected(x, matrix(u->R_NB), vector(u->omega_B), l);
    command(law, x, u, &now, controls, y);
    return true;
}

bool controller_planned_step(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, double h,
                             ControllerPlannedOutputs *y, Fault *f)
{
    if (!inputs_fit(u, law->p.gravitational_parameter, f)) {
        return false;
    }
    const double period = law->p.control_period;
    x->t += h;
    x->until_sample -= h;
    x->sampled = false;
    if (x->until_sample <= EARLY * period) {
        sample(law, x, u, false);
        x->until_sample += period;
        if (x->until_sample <= EARLY * period) {
            x->until_sample = period; /* a step longer than a period: the samples' grid begins anew */
        }
    }
    *y = x->held;
    return true;
}
