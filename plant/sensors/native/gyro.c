/* The gyro in the terms of IEEE Std 952. Tests: tests/native/test_flavours.py. */
#include "models.h"
#include "three_axis.h"

Vector plant_sensors_walked(const PlantSensorsParameters *p, Vector walk, int64_t sample, double span)
{
    return add(walk, sensor_noise((Draw){p->seed, sample, RATE_WALK_NOISE}, p->rate_random_walk * sqrt(span)));
}

/* The exact step of a stationary Gauss-Markov process of first order: e g + sqrt(1 - e^2) sigma xi. */
Vector plant_sensors_correlated(const PlantSensorsParameters *p, Vector markov, int64_t sample, double span)
{
    const double ratio = span / p->rate_instability_time;
    const double sigma = p->rate_instability * sqrt(-expm1(-2.0 * ratio));
    return add(scale(exp(-ratio), markov), sensor_noise((Draw){p->seed, sample, RATE_INSTABILITY_NOISE}, sigma));
}

Vector plant_sensors_rate(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u)
{
    const PlantSensorsParameters *p = &law->p;
    if (!law->has_rate_error) {
        return vector(u->omega_B);
    }
    double sigma = p->rate_noise;
    if (p->angle_random_walk > 0.0 && x->rate_span > 0.0) {
        sigma = sqrt(sigma * sigma + p->angle_random_walk * p->angle_random_walk / x->rate_span);
    }
    Vector rate = vector(u->omega_B);
    Vector error = add(vector(p->rate_bias_B), sensor_noise((Draw){p->seed, x->sample[RATE], RATE_NOISE}, sigma));
    if (law->has_rate_scale) {
        rate = scaled(p->rate_scale, rate);
    }
    if (law->has_drift) {
        error = add(error, add(x->rate_walk, x->rate_markov));
    }
    return digitised(add(rate, error), p->rate_range, p->rate_quantum);
}
