/* Each measurement against its prediction; the first attitude; what is beyond the gate.
 * Requirement: ES-1. Tests: tests/native/test_flavours.py. */
#include <string.h>

#include "state.h"

/* Of the first attitude's deviation, for that of the covariance at the start; less where an earlier field gives it. */
static const double START_FACTOR = 10.0, ANCHOR_FACTOR = 2.0;
static const double START_SINE = 0.17364817766693033;  /* 10 deg: least angle between Sun and field */
static const double ANCHOR_SINE = 0.34202014332566871; /* 20 deg: between two fields */
static const double ANCHOR_AGE = 900.0;                /* s; a field that is older is no longer turned on by the gyro */
static const double ALIGNED = 4.4e-3;                  /* rad; what a star tracker may be off for long */
static const double RATE_UNKNOWN = 0.05;               /* rad/s; of a start without the gyro */

/* Of the angle between x and y; 0 where one of them is zero. */
static double sine(Vector x, Vector y)
{
    const double both = norm(x) * norm(y);
    return both > 0.0 ? norm(cross(x, y)) / both : 0.0;
}

/* Right-handed axes of two directions, as columns. */
static Matrix axes_of(Vector first, Vector second)
{
    const Vector normal = cross(first, second);
    const Vector x = scale(1.0 / norm(first), first), z = scale(1.0 / norm(normal), normal);
    return transposed((Matrix){x, z, cross(x, z)});
}

/* Maps the first direction exactly; false where those of a pair are too near to one line. */
static bool triad(Vector first_B, Vector second_B, Vector first_N, Vector second_N, double apart, Matrix *R)
{
    if (!(sine(first_B, second_B) >= apart && sine(first_N, second_N) >= apart)) {
        return false;
    }
    *R = multiply(axes_of(first_N, second_N), transposed(axes_of(first_B, second_B)));
    return true;
}

void estimator_begin(const EstimatorLaw *law, const Directions *seen, Estimate *x)
{
    const EstimatorParameters *p = &law->p;
    const double off = sqrt(seen->field_variance) / norm(seen->field_N);
    const bool has_tracker = seen->has_tracker && estimator_trusted(&x->watch[SENSOR_ATTITUDE]);
    const bool has_field = seen->has_field && estimator_trusted(&x->watch[SENSOR_FIELD]);
    const bool has_sun = seen->has_sun && estimator_trusted(&x->watch[SENSOR_SUN]);
    const double field = p->lasting_field / norm(seen->field_N) + p->lasting_field_scale;
    double deviation = 0.0, lasting = p->lasting_attitude;
    bool begun = false;
    if (has_tracker) {
        x->R = seen->R_NB;
        deviation = START_FACTOR * (p->attitude_noise_boresight + p->attitude_noise);
        begun = true;
    } else if (has_sun && has_field) {
        begun = off < p->sun_noise ? triad(seen->b_B, seen->sun_B, seen->field_N, seen->sun_N, START_SINE, &x->R)
                                   : triad(seen->sun_B, seen->b_B, seen->sun_N, seen->field_N, START_SINE, &x->R);
        deviation = START_FACTOR * (off + p->sun_noise) / sine(seen->field_N, seen->sun_N);
        lasting = (field + p->lasting_sun) / sine(seen->field_N, seen->sun_N);
    } else if (x->anchored && x->by_gyro && has_field) {
        begun = triad(seen->b_B, x->anchor_B, seen->field_N, x->anchor_N, ANCHOR_SINE, &x->R);
        deviation = ANCHOR_FACTOR * (2.0 * off + p->rate_bias_sigma * x->anchor_age) / sine(seen->field_N, x->anchor_N);
        lasting = 2.0 * field / sine(seen->field_N, x->anchor_N);
    }
    if (begun) {
        const bool lost = estimator_gyro_lost(law, x);
        estimator_covariance_at_start(deviation, lost ? RATE_UNKNOWN : p->rate_bias_sigma,
                                      lost ? estimator_disturbance_sigma(law) : p->field_bias_sigma, &x->P);
        estimator_lasting_begin(lasting, x);
        x->known = x->tracking = true;
        x->anchored = false;
        x->since_start = 0.0;
        memset(x->in_a_row, 0, sizeof x->in_a_row);
    } else if (has_field && x->by_gyro && (!x->anchored || x->anchor_age > ANCHOR_AGE)) {
        x->anchored = true;
        x->anchor_B = seen->b_B;
        x->anchor_N = seen->field_N;
        x->anchor_age = 0.0;
    }
}

/* Takes a measurement, unless it is beyond the gate or its sensor is not trusted. */
static void take(const EstimatorLaw *law, int sensor, const Innovation *innovation, Estimate *x)
{
    Covariance P = x->P;
    Correction given;
    Watch *w = &x->watch[estimator_sensor_of[sensor]];
    x->nis[sensor] = estimator_correct(innovation, &P, &given);
    const bool within = x->nis[sensor] <= law->p.gate;
    if (!within && x->rejected[sensor] < INT32_MAX) {
        ++x->rejected[sensor];
    }
    const int32_t before = w->frozen ? 0 : x->in_a_row[sensor];
    if (within) {
        x->in_a_row[sensor] = before > 0 ? before - 1 : 0;
    } else {
        x->in_a_row[sensor] = before < IN_A_ROW ? before + 1 : IN_A_ROW;
    }
    const bool backed = estimator_is_backed(sensor, x);
    const bool wrong = estimator_weigh(given.scaled, w->since, within && (backed || sensor != GATED_FIELD), w);
    if ((wrong || x->in_a_row[sensor] == IN_A_ROW) && !w->frozen && !estimator_repeats(w)) {
        if (backed) {
            estimator_restart(x);
        } else {
            estimator_suspect(law, sensor, innovation->r.x, x);
        }
    }
    if (!within || !estimator_trusted(w) || !x->tracking) {
        return;
    }
    x->P = P;
    x->R = multiply(x->R, rotation_exp(vector(given.error + ERROR_ATTITUDE)));
    Vector *last = estimator_gyro_lost(law, x) ? &x->disturbance_B : &x->field_bias;
    *last = add(*last, vector(given.error + ERROR_BIAS));
    Vector *rate = x->by_gyro ? &x->rate_bias : &x->rate;
    *rate = add(*rate, vector(given.error + ERROR_RATE));
    estimator_lasting_take(law, sensor, innovation, (const double (*)[ERROR_STATES])given.gains, x);
}

static Vector equal(double value)
{
    return (Vector){value, value, value};
}

Innovation estimator_innovation(const EstimatorLaw *law, const Directions *seen, int sensor, Matrix R,
                                Vector field_bias)
{
    const EstimatorParameters *p = &law->p;
    if (sensor == GATED_TRACKER) {
        const double across = p->attitude_noise * p->attitude_noise;
        const double about = p->attitude_noise_boresight * p->attitude_noise_boresight;
        const Vector turn = rotation_log(multiply(transposed(R), seen->R_NB));
        return (Innovation){apply(law->tracker_axes, turn), law->tracker_axes, false, {across, across, about}, ALIGNED};
    }
    if (sensor == GATED_SUN) {
        const Vector s = apply_transposed(R, seen->sun_N), error = subtract(seen->sun_B, s);
        const Vector y = subtract(error, scale(dot(s, error), s));
        return (Innovation){y, hat(s), false, equal(p->sun_noise * p->sun_noise), 0.0};
    }
    const Vector b = apply_transposed(R, seen->field_N), y = subtract(subtract(seen->b_B, b), field_bias);
    return (Innovation){y, hat(b), true, equal(seen->field_variance), 0.0};
}

void estimator_take(const EstimatorLaw *law, const Directions *seen, Estimate *x)
{
    static const int order[] = {GATED_TRACKER, GATED_SUN, GATED_FIELD};
    const bool has[] = {seen->has_tracker, seen->has_sun, seen->has_field};
    estimator_compare(law, seen, x);
    for (int i = 0; i < GATED; ++i) {
        if (has[i] && x->tracking) {
            Innovation innovation = estimator_innovation(law, seen, order[i], x->R, x->field_bias);
            innovation.biased = innovation.biased && !estimator_gyro_lost(law, x);
            take(law, order[i], &innovation, x);
        }
    }
}
