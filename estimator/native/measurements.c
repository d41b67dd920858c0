/* Each measurement against its prediction; the first attitude; what is beyond the gate. */
#include <string.h>

#include "state.h"

static const double START_FACTOR = 10.0;            /* of the first attitude's deviation: the covariance at the start */
static const double SINE_MIN = 0.17364817766693033; /* of the angle between Sun and field at the start: 10 deg */
enum { IN_A_ROW = 50 }; /* measurements of one sensor above the gate, one after the other, that end the filter */

/* Right-handed axes of two directions, the first of them the first axis, as columns; false where they are too near to each
 * other. */
static bool axes_of(Vector first, Vector second, Matrix *axes)
{
    const Vector normal = cross(first, second);
    const double length = norm(normal), both = SINE_MIN * norm(first) * norm(second);
    if (!(length >= both && both > 0.0)) {
        return false;
    }
    const Vector x = scale(1.0 / norm(first), first), z = scale(1.0 / length, normal);
    *axes = transposed((Matrix){x, z, cross(x, z)});
    return true;
}

void estimator_begin(const EstimatorLaw *law, const Directions *seen, Estimate *x)
{
    const EstimatorParameters *p = &law->p;
    double deviation;
    if (seen->has_tracker) {
        x->R = seen->R_NB;
        deviation = p->attitude_noise_boresight + p->attitude_noise;
    } else if (seen->has_sun && seen->has_field) {
        const double off = sqrt(seen->field_variance) / norm(seen->field_N);
        const bool by_field = off < p->sun_noise; /* maps the better of the two exactly */
        Matrix in_B, in_N;
        if (!axes_of(by_field ? seen->b_B : seen->sun_B, by_field ? seen->sun_B : seen->b_B, &in_B) ||
            !axes_of(by_field ? seen->field_N : seen->sun_N, by_field ? seen->sun_N : seen->field_N, &in_N)) {
            return;
        }
        x->R = multiply(in_N, transposed(in_B));
        deviation = (off + p->sun_noise) / norm(cross(seen->field_N, seen->sun_N)) * norm(seen->field_N);
    } else {
        return;
    }
    estimator_covariance_at_start(START_FACTOR * deviation, p->rate_bias_sigma, p->field_bias_sigma, &x->P);
    x->known = x->tracking = true;
    memset(x->in_a_row, 0, sizeof x->in_a_row);
}

/* Takes a measurement, unless it is beyond the gate. */
static void take(const EstimatorLaw *law, int sensor, const Innovation *innovation, Estimate *x)
{
    Covariance P = x->P;
    double error[ERRORS];
    x->nis[sensor] = estimator_correct(innovation, &P, error);
    if (!(x->nis[sensor] <= law->p.gate)) {
        ++x->rejected[sensor];
        x->tracking = ++x->in_a_row[sensor] < IN_A_ROW;
        return;
    }
    x->in_a_row[sensor] = 0;
    x->P = P;
    x->R = multiply(x->R, rotation_exp(vector(error + ATTITUDE)));
    x->field_bias = add(x->field_bias, vector(error + BIAS));
    Vector *rate = law->p.rate_source == ESTIMATOR_RATE_SOURCE_GYRO ? &x->rate_bias : &x->rate;
    *rate = add(*rate, vector(error + RATE));
}

static Matrix hat(Vector x)
{
    return (Matrix){{0.0, -x.z, x.y}, {x.z, 0.0, -x.x}, {-x.y, x.x, 0.0}};
}

static Vector equal(double value)
{
    return (Vector){value, value, value};
}

void estimator_take(const EstimatorLaw *law, const Directions *seen, Estimate *x)
{
    const EstimatorParameters *p = &law->p;
    if (seen->has_tracker && x->tracking) {
        const double across = p->attitude_noise * p->attitude_noise;
        const double about = p->attitude_noise_boresight * p->attitude_noise_boresight;
        const Vector turn = rotation_log(multiply(transposed(x->R), seen->R_NB));
        take(law, TRACKER, &(Innovation){apply(law->tracker_axes, turn), law->tracker_axes, false, {across, across, about}}, x);
    }
    if (seen->has_sun && x->tracking) {
        const Vector s = apply_transposed(x->R, seen->sun_N), error = subtract(seen->sun_B, s);
        const Vector y = subtract(error, scale(dot(s, error), s));
        take(law, SUN, &(Innovation){y, hat(s), false, equal(p->sun_noise * p->sun_noise)}, x);
    }
    if (seen->has_field && x->tracking) {
        const Vector b = apply_transposed(x->R, seen->field_N), y = subtract(subtract(seen->b_B, b), x->field_bias);
        take(law, FIELD, &(Innovation){y, hat(b), true, equal(seen->field_variance)}, x);
    }
}
