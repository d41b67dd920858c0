#include "plant_sensors.h"

#include "noise.h"
#include "rotation.h"

static const double SNAP = 1e-6;       /* of sample_period: rounding delays no measurement */
static const double PERIODS_MAX = 1e9; /* in one communication step */
static const double PERIOD_MIN = 1e-6; /* s */

/* They keep their noise apart. */
enum { ATTITUDE, RATE, FIELD, WHEEL, POSITION, VELOCITY };

bool plant_sensors_check(const PlantSensorsParameters *p, Fault *f)
{
    const Named noises[] = {{"attitude_noise", p->attitude_noise}, {"rate_noise", p->rate_noise},
                            {"field_noise", p->field_noise},       {"wheel_momentum_noise", p->wheel_momentum_noise},
                            {"position_noise", p->position_noise}, {"velocity_noise", p->velocity_noise}};
    const NamedVector biases[] = {{"attitude_bias_B", vector(p->attitude_bias_B)},
                                  {"rate_bias_B", vector(p->rate_bias_B)},
                                  {"field_bias_B", vector(p->field_bias_B)}};
    if (!all_finite_vectors(biases, COUNT(biases), f) || !all_not_negative(noises, COUNT(noises), f)) {
        return false;
    }
    if (!(p->sample_period == 0.0 || (p->sample_period >= PERIOD_MIN && isfinite(p->sample_period)))) {
        return fault(f, "sample_period", p->sample_period, "0 (every step) or at least 1e-06 s");
    }
    if (p->seed < 0) {
        return fault(f, "seed", p->seed, "at least 0");
    }
    return true;
}

void plant_sensors_prepare(const PlantSensorsParameters *p, PlantSensorsLaw *law)
{
    law->p = *p;
}

/* Independent normal numbers on three axes. */
static Vector noise(const PlantSensorsParameters *p, int64_t sample, uint32_t sensor, double sigma)
{
    double xy[2], z[2];
    if (!(sigma > 0.0)) {
        return (Vector){0.0, 0.0, 0.0};
    }
    plant_sensors_normal_pair(p->seed, sample, sensor, 0, xy);
    plant_sensors_normal_pair(p->seed, sample, sensor, 1, z);
    return scale(sigma, (Vector){xy[0], xy[1], z[0]});
}

static PlantSensorsOutputs measured(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u)
{
    PlantSensorsOutputs y;
    const Vector turn = add(vector(p->attitude_bias_B), noise(p, sample, ATTITUDE, p->attitude_noise));
    const Vector rate_error = add(vector(p->rate_bias_B), noise(p, sample, RATE, p->rate_noise));
    const Vector field_error = add(vector(p->field_bias_B), noise(p, sample, FIELD, p->field_noise));
    store_matrix(multiply(matrix(u->R_NB), rotation_exp(turn)), y.R_NB_measured);
    store(add(vector(u->omega_B), rate_error), y.omega_B_measured);
    store(add(vector(u->b_B), field_error), y.b_B_measured);
    store(add(vector(u->r_N), noise(p, sample, POSITION, p->position_noise)), y.r_N_measured);
    store(add(vector(u->v_N), noise(p, sample, VELOCITY, p->velocity_noise)), y.v_N_measured);
    y.h_w_measured = u->h_w + noise(p, sample, WHEEL, p->wheel_momentum_noise).x;
    return y;
}

bool plant_sensors_start(const PlantSensorsLaw *law, const PlantSensorsInputs *u, PlantSensorsState *x, Fault *f)
{
    (void)f;
    x->sample = 0;
    x->since = 0.0;
    x->held = measured(&law->p, 0, u);
    return true;
}

bool plant_sensors_outputs(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u,
                           PlantSensorsOutputs *y, Fault *f)
{
    (void)f;
    *y = law->p.sample_period == 0.0 ? measured(&law->p, x->sample, u) : x->held;
    return true;
}

bool plant_sensors_step(const PlantSensorsLaw *law, PlantSensorsState *x, const PlantSensorsInputs *u, double h,
                        PlantSensorsOutputs *y, Fault *f)
{
    const double T = law->p.sample_period;
    double since = 0.0;
    int64_t due = 1;
    if (T > 0.0) {
        since = x->since + h;
        if (!(since / T <= PERIODS_MAX)) {
            return fault(f, "sample_period", T, "at least 1e-09 of the communication step");
        }
        due = (int64_t)(since / T + SNAP);
        since -= (double)due * T;
    }
    x->since = since;
    if (due > 0) {
        x->sample += due;
        x->held = measured(&law->p, x->sample, u);
    }
    *y = x->held;
    return true;
}
