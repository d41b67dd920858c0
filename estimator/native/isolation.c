/* Which of the parts that disagree is wrong: a sensor, the filter, or its gyro. docs/how/health.md derives the limits.
 * Requirement: ES-4. Tests: tests/native/test_flavours.py. */
#include <string.h>

#include "rates.h"
#include "state.h"

static const double BACKED = 0.5;      /* averages of sensors against each other that agree */
static const double RESTARTED = 600.0; /* s; who starts again within it has a wrong gyro */
static const double RATE_LOST = 1e-3;  /* rad/s; a rate's change over what the gyro takes to be frozen */
static const double STALE = 10.0;      /* s; that time */
static const double RADIAN = 1000.0;   /* s, of an orbit */

/* Offset that a magnetometer may have had before it is found: deviations of its noise, at most that of the field. */
static const double MISLED = 5.0, MISLED_MOST = 0.2;

const int estimator_sensor_of[GATED] = {SENSOR_FIELD, SENSOR_SUN, SENSOR_ATTITUDE};

static bool is_small(const double mean[3])
{
    return norm(vector(mean)) < BACKED;
}

bool estimator_is_backed(int gated, const Estimate *x)
{
    if (gated == GATED_FIELD) {
        return x->field_calm >= ESTIMATOR_CALM;
    }
    return gated == GATED_TRACKER && is_small(x->field_by_tracker) && is_small(x->sun_by_tracker);
}

void estimator_restart(Estimate *x)
{
    Watch *gyro = &x->watch[SENSOR_RATE];
    x->tracking = false;
    gyro->suspect = gyro->suspect || (x->by_gyro && x->restarted && x->since_start < RESTARTED);
    gyro->calm = 0.0;
    x->restarted = true;
    for (int i = 0; i < GATED; ++i) {
        Watch *w = &x->watch[estimator_sensor_of[i]];
        memset(w->mean, 0, sizeof w->mean);
        /* Without its gyro the filter judged the others by a rate that was wrong, and needs them for an attitude. */
        w->suspect = w->suspect && estimator_trusted(gyro) && !estimator_is_backed(i, x);
    }
}

void estimator_compare(const EstimatorLaw *law, const Directions *seen, Estimate *x)
{
    const double since = x->watch[SENSOR_FIELD].since, deviation = sqrt(seen->field_variance);
    const double sun = law->p.sun_noise * norm(seen->field_N);
    const Vector b = subtract(seen->b_B, x->field_bias);
    double off[3] = {0.0, 0.0, 0.0};
    if (seen->has_field) {
        off[0] = (norm(b) - norm(seen->field_N)) / deviation;
        if (seen->has_sun) {
            off[1] = (dot(b, seen->sun_B) - dot(seen->field_N, seen->sun_N)) / sqrt(deviation * deviation + sun * sun);
        }
        estimator_average(off, since, x->field_alone);
        const double strength[3] = {x->field_alone[0], 0.0, 0.0};
        const bool small = is_small(estimator_trusted(&x->watch[SENSOR_SUN]) ? x->field_alone : strength);
        x->field_calm = small ? x->field_calm + since : 0.0;
    }
    if (seen->has_tracker && seen->has_field && estimator_trusted(&x->watch[SENSOR_FIELD])) {
        store(scale(1.0 / deviation, subtract(b, apply_transposed(seen->R_NB, seen->field_N))), off);
        estimator_average(off, since, x->field_by_tracker);
    }
    if (seen->has_tracker && seen->has_sun && estimator_trusted(&x->watch[SENSOR_SUN])) {
        store(scale(1.0 / law->p.sun_noise, subtract(seen->sun_B, apply_transposed(seen->R_NB, seen->sun_N))), off);
        estimator_average(off, x->watch[SENSOR_SUN].since, x->sun_by_tracker);
    }
}

bool estimator_gyro_lost(const EstimatorLaw *law, const Estimate *x)
{
    return law->p.rate_source == ESTIMATOR_RATE_SOURCE_GYRO && !x->by_gyro;
}

void estimator_go_on_turning(const EstimatorLaw *law, const Given *given, Vector wheel_B, Vector momentum_B, double h,
                             Estimate *x)
{
    const Torques torques = {
        .J = law->J,
        .J_inverse = law->J_inverse,
        .dipole_B = apply_transposed(law->rod_axes, given->dipole),
        .field_N = x->b_B,
        .wheel_B = wheel_B,
    };
    Matrix R = identity;
    Vector omega = subtract(x->rate, x->rate_bias);
    (void)estimator_turn_by_dynamics(&torques, momentum_B, h, &R, &omega);
    x->rate = add(omega, x->rate_bias);
}

double estimator_disturbance_sigma(const EstimatorLaw *law)
{
    return law->p.momentum_random_walk / sqrt(RADIAN);
}

void estimator_suspect(const EstimatorLaw *law, int gated, double variance, Estimate *x)
{
    Watch *w = &x->watch[estimator_sensor_of[gated]];
    if (gated == GATED_FIELD && !w->suspect && law->p.lasting_field > 0.0) {
        const double offset = smaller(MISLED * sqrt(variance), MISLED_MOST * norm(x->b_B));
        const double times = offset / law->p.lasting_field;
        for (int i = 0; i < ERROR_STATES; ++i) {
            for (int j = 0; j < ERROR_STATES; ++j) {
                for (int k = LASTING_DRIFT; k < LASTING; ++k) {
                    x->P.m[i][j] += times * times * x->S.m[i][k] * x->S.m[j][k];
                }
            }
        }
    }
    w->suspect = true;
}

/* Three errors become independent of all others. */
static void forget(int first, double deviation, Covariance *P)
{
    for (int j = first; j < first + 3; ++j) {
        for (int i = 0; i < ERROR_STATES; ++i) {
            P->m[j][i] = P->m[i][j] = 0.0;
        }
        P->m[j][j] = deviation * deviation;
    }
}

void estimator_weigh_gyro(const EstimatorLaw *law, Vector measured, Estimate *x)
{
    const double spread = law->p.rate_bias_sigma;
    double off[3];
    store(subtract(measured, x->rate), off);
    for (int i = 0; i < 3; ++i) {
        off[i] /= sqrt(x->P.m[ERROR_RATE + i][ERROR_RATE + i] + spread * spread);
    }
    (void)estimator_weigh(off, x->watch[SENSOR_RATE].since, norm(vector(off)) < 3.0, &x->watch[SENSOR_RATE]);
}

void estimator_choose_rate(const EstimatorLaw *law, Estimate *x)
{
    if (law->p.rate_source != ESTIMATOR_RATE_SOURCE_GYRO) {
        return;
    }
    const Watch *w = &x->watch[SENSOR_RATE];
    const bool by_gyro = estimator_trusted(w);
    if (x->by_gyro && !by_gyro) {
        /* The rate's error is minus that of the bias; what it has become since the gyro froze is not known. */
        const double omega = norm(subtract(x->rate, x->rate_bias));
        const double rate = w->frozen ? RATE_LOST + omega * omega * STALE : 10.0 * RATE_LOST + law->p.rate_bias_sigma;
        for (int i = 0; i < ERROR_STATES; ++i) {
            for (int j = 0; j < 3; ++j) {
                x->P.m[ERROR_RATE + j][i] *= -1.0;
                x->P.m[i][ERROR_RATE + j] *= -1.0;
            }
        }
        for (int j = 0; j < 3; ++j) {
            x->P.m[ERROR_ATTITUDE + j][ERROR_ATTITUDE + j] += 0.25 * rate * rate * STALE * STALE;
            x->P.m[ERROR_RATE + j][ERROR_RATE + j] += rate * rate;
        }
        forget(ERROR_BIAS, estimator_disturbance_sigma(law), &x->P);
        x->disturbance_B = (Vector){0.0, 0.0, 0.0};
        estimator_lasting_rate(-1.0, x);
    } else if (!x->by_gyro && by_gyro) {
        forget(ERROR_RATE, law->p.rate_bias_sigma, &x->P);
        forget(ERROR_BIAS, law->p.field_bias_sigma, &x->P);
        estimator_lasting_rate(0.0, x);
    }
    x->by_gyro = by_gyro;
}
