/* A step of the estimate: orbit, rate and attitude forward, then what is measured.
 * Tests: tests/native/test_flavours.py. */
#include "estimator.h"
#include "onboard.h"
#include "rates.h"

#include <string.h>

static const double PI = 3.14159265358979323846;
static const Matrix ZERO = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
static const double LIGHT_MIN = 0.5;     /* of the Sun that must be seen for its direction to count */
static const double FIELD_LASTS = 300.0; /* s, for which the last field is one still: it turns by 36 deg in N */
static const double TORQUE_OFF = 1.0;    /* s^(1/2): the momentum's walk, over torques that are not exactly known */

static bool is_zero(const double v[3])
{
    return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
}

void estimator_blank(const EstimatorLaw *law, const EstimatorInputs *u, Estimate *x)
{
    memset(x, 0, sizeof *x);
    x->by_gyro = law->p.rate_source == ESTIMATOR_RATE_SOURCE_GYRO;
    if (x->by_gyro) {
        x->rate = vector(u->omega_B_measured);
    }
    x->field_calm = ESTIMATOR_CALM;
    for (int i = 0; i < SENSORS; ++i) {
        x->watch[i].jumped = ESTIMATOR_CALM;
    }
    estimator_covariance_at_start(PI, law->p.rate_bias_sigma, law->p.field_bias_sigma, &x->P);
}

static void forward_by_gyro(const EstimatorLaw *law, const EstimatorInputs *u, bool fresh, double h, Estimate *x)
{
    const double square = law->p.rate_random_walk * law->p.rate_random_walk;
    const Matrix walk = {scale(square, identity.a), scale(square, identity.b), scale(square, identity.c)};
    const Vector now = fresh ? vector(u->omega_B_measured) : x->rate;
    x->since_rate += h;
    const Vector turn = estimator_turn_by_gyro(subtract(x->rate, x->rate_bias), subtract(now, x->rate_bias), h,
                                               fresh ? x->since_rate : 0.0);
    x->R = multiply(x->R, rotation_exp(turn));
    x->anchor_B = apply_transposed(rotation_exp(turn), x->anchor_B);
    x->anchor_age += h;
    x->rate = now;
    x->since_rate = fresh ? 0.0 : x->since_rate;
    const double angle = law->p.angle_random_walk;
    estimator_spread(law, turn, -1.0, ZERO, walk, angle * angle, h, x);
}

static void forward_by_dynamics(const EstimatorLaw *law, const Given *given, Vector field_N, double h, Estimate *x)
{
    const Vector before = x->momentum_B;
    Vector wheel_B = {0.0, 0.0, 0.0};
    if (given->has_wheel_torque) {
        wheel_B = given->wheel_torque_B;
    } else if (given->has_h_w && h > 0.0) {
        wheel_B = changed(given->momentum_B, before, h);
    }
    x->momentum_B = given->has_h_w ? given->momentum_B : add(before, scale(h, wheel_B));
    if (!x->known || !(h > 0.0)) {
        if (h > 0.0 && estimator_gyro_lost(law, x)) {
            estimator_go_on_turning(law, given, wheel_B, before, h, x);
        }
        return;
    }
    const double r = norm(x->r_N);
    const Torques torques = {
        .J = law->J,
        .J_inverse = law->J_inverse,
        .dipole_B = apply_transposed(law->rod_axes, given->dipole),
        .field_N = field_N,
        .nadir_N = scale(sqrt(3.0 * law->p.gravitational_parameter / (r * r * r)) / r, x->r_N),
        .wheel_B = wheel_B,
        .disturbance_B = x->disturbance_B,
    };
    Vector omega = subtract(x->rate, x->rate_bias);
    const Matrix growth = estimator_rate_growth(&torques, omega, before);
    const Vector turning = cross(omega, apply(law->J, omega));
    const Vector turn = estimator_turn_by_dynamics(&torques, before, h, &x->R, &omega);
    const Vector rods = cross(torques.dipole_B, apply_transposed(x->R, field_N));
    const double unknown =
        estimator_gyro_lost(law, x) ? TORQUE_OFF * (norm(turning) + norm(rods)) : law->p.momentum_random_walk;
    Matrix walk = multiply(law->J_inverse, transposed(law->J_inverse));
    const double square = unknown * unknown;
    walk = (Matrix){scale(square, walk.a), scale(square, walk.b), scale(square, walk.c)};
    x->rate = add(omega, x->rate_bias);
    x->disturbance_B = scale(exp(-h / ESTIMATOR_LASTS), x->disturbance_B);
    estimator_spread(law, turn, 1.0, growth, walk, 0.0, h, x);
}

static Directions directions(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Given *given,
                             const Estimate *x)
{
    const EstimatorParameters *p = &law->p;
    const Vector rods = apply(law->rod_field, given->dipole);
    Directions seen;
    memset(&seen, 0, sizeof seen);
    seen.field_N = onboard_field_at(&law->field, x->t, x->r_N);
    seen.sun_N = estimator_sun_direction(law->days + x->t / 86400.0);
    seen.has_field = fresh->field && !is_zero(u->b_B_measured) && largest(given->dipole) <= p->dipole_limit;
    seen.b_B = subtract(vector(u->b_B_measured), rods);
    seen.field_variance = p->field_noise * p->field_noise + p->rod_field_error * p->rod_field_error * dot(rods, rods);
    seen.R_NB = matrix(u->R_NB_measured);
    seen.has_tracker = fresh->attitude && estimator_has_R_NB_measured(u) && !is_zero_matrix(seen.R_NB);
    if (fresh->sun && estimator_has_sun_B_measured(u) && !is_zero(u->sun_B_measured)) {
        const Vector sun = vector(u->sun_B_measured);
        seen.sun_B = scale(1.0 / norm(sun), sun);
        seen.has_sun = estimator_sunlight(x->r_N, seen.sun_N) > LIGHT_MIN;
    }
    return seen;
}

/* R (3 - R^T R)/2: nearer to SO(3); rounding is all that it removes. */
static Matrix orthonormalised(Matrix R)
{
    Matrix left = multiply(transposed(R), R);
    left = (Matrix){subtract(scale(1.5, identity.a), scale(0.5, left.a)),
                    subtract(scale(1.5, identity.b), scale(0.5, left.b)),
                    subtract(scale(1.5, identity.c), scale(0.5, left.c))};
    return multiply(R, left);
}

/* Looks at each new measurement for itself. */
static void notice(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Directions *seen,
                   const Given *given, double h, Estimate *x)
{
    for (int i = 0; i < SENSORS; ++i) {
        x->watch[i].since += h;
        x->watch[i].jumped += h;
    }
    if (fresh->rate) {
        if (!law->p.bank) {
            estimator_follow_rate(law, given, vector(u->omega_B_measured), h, x);
        }
        estimator_notice(u->omega_B_measured, false, &x->watch[SENSOR_RATE]);
    }
    if (fresh->field && !is_zero(u->b_B_measured)) {
        if (seen->has_field && !law->p.bank) {
            estimator_follow_field(seen, x->b_age, x);
        }
        estimator_notice(u->b_B_measured, false, &x->watch[SENSOR_FIELD]);
    }
    estimator_undo_jumps(x);
    if (seen->has_tracker) {
        const double turns[3] = {u->R_NB_measured[0][1], u->R_NB_measured[1][2], u->R_NB_measured[2][0]};
        estimator_notice(turns, true, &x->watch[SENSOR_ATTITUDE]);
    }
    if (seen->has_sun) {
        const double sun[3] = {seen->sun_B.x, seen->sun_B.y, seen->sun_B.z};
        estimator_notice(sun, true, &x->watch[SENSOR_SUN]);
    }
}

/* Rate, attitude and covariance h s later. */
static void forward(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Given *given,
                    const Directions *seen, double h, Estimate *x)
{
    estimator_choose_rate(law, x);
    if (x->by_gyro) {
        forward_by_gyro(law, u, fresh->rate, h, x);
        x->momentum_B = given->has_h_w ? given->momentum_B : add(x->momentum_B, scale(h, given->wheel_torque_B));
    } else {
        forward_by_dynamics(law, given, seen->field_N, h, x);
        if (fresh->rate && law->p.rate_source == ESTIMATOR_RATE_SOURCE_GYRO) {
            estimator_weigh_gyro(law, vector(u->omega_B_measured), x);
        }
    }
    x->since_start += h;
}

/* From now on count the times from the last measurements. */
static void settle(const Fresh *fresh, const Directions *seen, Estimate *x)
{
    const bool measured[SENSORS] = {fresh->rate, seen->has_field, false, seen->has_tracker, seen->has_sun};
    for (int i = 0; i < SENSORS; ++i) {
        x->watch[i].since = measured[i] ? 0.0 : x->watch[i].since;
    }
}

void estimator_advance(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Given *given,
                       double h, Estimate *x, Bank *bank)
{
    x->t += h;
    estimator_take_orbit(law, u, fresh->orbit, h, x);
    if (!x->oriented) {
        x->rate = x->by_gyro && fresh->rate ? vector(u->omega_B_measured) : x->rate;
        x->b_B = fresh->field ? vector(u->b_B_measured) : x->b_B;
        if (law->p.bank) {
            bank->rate = x->rate;
        }
        return;
    }
    const Directions seen = directions(law, u, fresh, given, x);
    notice(law, u, fresh, &seen, given, h, x);
    if (law->p.bank) {
        estimator_by_bank(law, u, fresh, &seen, h, x, bank);
    } else {
        forward(law, u, fresh, given, &seen, h, x);
        if (!x->tracking) {
            estimator_begin(law, &seen, x);
        }
        estimator_take(law, &seen, x);
        settle(fresh, &seen, x);
    }
    x->R = orthonormalised(x->R);
    x->b_age += h;
    if (seen.has_field && estimator_trusted(&x->watch[SENSOR_FIELD])) {
        x->b_B = subtract(seen.b_B, x->field_bias);
        x->b_age = 0.0;
    } else if (x->known) {
        x->b_B = apply_transposed(x->R, seen.field_N);
    } else if (x->b_age > FIELD_LASTS) {
        x->b_B = (Vector){0.0, 0.0, 0.0};
    } else {
        x->b_B = apply(rotation_exp(scale(-h, subtract(x->rate, x->rate_bias))), x->b_B);
    }
}
