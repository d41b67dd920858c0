/* A gyro or magnetometer whose measurement jumps by more than the satellite can turn: its bias has changed by that.
 * docs/how/health.md, Jumps. Tests: tests/estimator/test_jumps.py, tests/native/test_flavours.py. */
#include "state.h"

static const double RATE_JUMP = 2e-3;  /* rad/s, least jump of a gyro */
static const double FIELD_JUMP = 5e-6; /* T, of a magnetometer */
static const double FIELD_NOISE = 2.0; /* deviations of its stated noise: the same */
static const double UNCERTAIN = 4.0;   /* of the usual mean square: variance of a jump in each axis */

/* Three errors of the covariance grow. */
static void doubt(int first, double variance, Covariance *P)
{
    for (int i = first; i < first + 3; ++i) {
        P->m[i][i] += variance;
    }
}

void estimator_follow_rate(const EstimatorLaw *law, const Given *given, Vector measured, double h, Estimate *x)
{
    Watch *w = &x->watch[SENSOR_RATE];
    const double dt = w->since;
    if (!x->by_gyro || !(dt > 0.0) || !(given->has_h_w || given->has_wheel_torque)) {
        return;
    }
    /* What turns it but for the rods, which turn it little in a sample, and their like. */
    const Vector omega = subtract(x->rate, x->rate_bias);
    const Vector wheel_B =
        given->has_h_w && h > 0.0 ? changed(given->momentum_B, x->momentum_B, h) : given->wheel_torque_B;
    const Vector motor = apply(law->J_inverse, scale(-1.0, wheel_B));
    const Vector turning = apply(law->J_inverse, cross(add(apply(law->J, omega), x->momentum_B), omega));
    const Vector off = subtract(subtract(measured, x->rate), scale(dt, add(turning, motor)));
    if (estimator_jumps(off, RATE_JUMP + dt * norm(motor), w)) {
        x->rate = add(x->rate, off);
        x->rate_bias = add(x->rate_bias, off);
        doubt(ERROR_RATE, UNCERTAIN * w->usual, &x->P);
    }
}

void estimator_follow_field(const Directions *seen, double age, Estimate *x)
{
    Watch *w = &x->watch[SENSOR_FIELD];
    const double dt = w->since, noise = FIELD_NOISE * sqrt(seen->field_variance);
    if (!x->by_gyro || !(dt > 0.0) || age > 0.0) {
        return;
    }
    const Vector turned = apply(rotation_exp(scale(-dt, subtract(x->rate, x->rate_bias))), x->b_B);
    const Vector off = subtract(subtract(seen->b_B, x->field_bias), turned);
    if (estimator_jumps(off, FIELD_JUMP > noise ? FIELD_JUMP : noise, w)) {
        x->field_bias = add(x->field_bias, off);
        doubt(ERROR_BIAS, UNCERTAIN * w->usual, &x->P);
    }
}

void estimator_undo_jumps(Estimate *x)
{
    Watch *gyro = &x->watch[SENSOR_RATE], *field = &x->watch[SENSOR_FIELD];
    if (estimator_jumped_to_rest(gyro)) {
        x->rate = subtract(x->rate, gyro->jump);
        x->rate_bias = subtract(x->rate_bias, gyro->jump);
        gyro->jumped = ESTIMATOR_CALM;
    }
    if (estimator_jumped_to_rest(field)) {
        x->field_bias = subtract(x->field_bias, field->jump);
        field->jumped = ESTIMATOR_CALM;
    }
}
