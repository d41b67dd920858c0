/* Tests: tests/native/test_flavours.py. */
#include "plant_sensors.h"

#include "models.h"

static const double SNAP = 1e-6;       /* of a period: rounding delays no measurement */
static const double PERIODS_MAX = 1e9; /* in one communication step */

static int32_t following(int32_t count)
{
    return count < INT32_MAX ? count + 1 : 1;
}

/* The measurements by the sensors that are due, of the numbers and with the memory in x. */
static void measure(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u,
                    const bool due[CLOCKS], PlantSensorsOutputs *y)
{
    const PlantSensorsParameters *p = &law->p;
    if (due[ATTITUDE]) {
        static const Matrix none = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
        const bool given = !x->attitude_lost && plant_sensors_sees_stars(law, u);
        store_matrix(given ? plant_sensors_attitude(law, x->sample[ATTITUDE], u) : none, y->R_NB_measured);
        y->attitude_sample = given ? following(x->before[ATTITUDE]) : x->before[ATTITUDE];
    }
    if (due[RATE]) {
        store(plant_sensors_rate(law, x, u), y->omega_B_measured);
        y->rate_sample = following(x->before[RATE]);
    }
    if (due[FIELD]) {
        store(plant_sensors_field(law, x->sample[FIELD], u), y->b_B_measured);
        y->field_sample = following(x->before[FIELD]);
    }
    if (due[ORBIT]) {
        if (!x->orbit_lost) {
            plant_sensors_fix(p, x->sample[ORBIT], u, y);
        }
        y->orbit_sample = x->orbit_lost ? x->before[ORBIT] : following(x->before[ORBIT]);
    }
    if (due[SUN]) {
        const bool given = plant_sensors_has_sun_N(u) && plant_sensors_sun(law, x->sample[SUN], u, y);
        y->sun_sample = given ? following(x->before[SUN]) : x->before[SUN];
    }
    if (due[TELEMETRY]) {
        plant_sensors_telemetry(p, x->sample[TELEMETRY], u, y);
    }
}

bool plant_sensors_start(const PlantSensorsLaw *law, const PlantSensorsInputs *u, PlantSensorsState *x, Fault *f)
{
    static const bool due[CLOCKS] = {true, true, true, true, true, true};
    const double forever = 1e3 * law->p.rate_instability_time; /* the noise is stationary from the first number on */
    (void)f;
    *x = (PlantSensorsState){.rate_span = law->periods[RATE]};
    x->rate_markov = plant_sensors_correlated(&law->p, x->rate_markov, 0, forever);
    measure(law, x, u, due, &x->held);
    return true;
}

bool plant_sensors_outputs(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u,
                           PlantSensorsOutputs *y, Fault *f)
{
    bool due[CLOCKS];
    (void)f;
    for (int i = 0; i < CLOCKS; ++i) {
        due[i] = law->periods[i] == 0.0;
    }
    *y = x->held;
    measure(law, x, u, due, y);
    return true;
}

/* How many measurements of the period T are due at the end of the step, and the time that they span. */
static bool tick(const PlantSensorsLaw *law, int i, double h, double *since, int64_t *periods, double *span, Fault *f)
{
    static const char *const names[CLOCKS] = {"attitude_period", "rate_period", "field_period",
                                              "orbit_period",    "sun_period",  "telemetry_period"};
    const double T = law->periods[i], passed = *since + h;
    if (!(passed / T <= PERIODS_MAX)) {
        const char *name = T == law->p.sensor_period ? "sensor_period" : names[i];
        return fault(f, name, T, "at least 1e-09 of the communication step");
    }
    *periods = (int64_t)(passed / T + SNAP);
    *span = (double)*periods * T;
    *since = passed - *span;
    return true;
}

/* Drift and drop-outs over the time since the measurement before. */
static void remember(const PlantSensorsLaw *law, PlantSensorsState *x, const bool due[CLOCKS],
                     const double spans[CLOCKS])
{
    const PlantSensorsParameters *p = &law->p;
    const int32_t counted[COUNTERS] = {x->held.attitude_sample, x->held.rate_sample, x->held.field_sample,
                                       x->held.orbit_sample, x->held.sun_sample};
    for (int i = 0; i < COUNTERS; ++i) {
        x->before[i] = due[i] ? counted[i] : x->before[i];
    }
    if (due[RATE]) {
        x->rate_span = spans[RATE];
        if (law->has_drift) {
            x->rate_walk = plant_sensors_walked(p, x->rate_walk, x->sample[RATE], spans[RATE]);
            x->rate_markov = plant_sensors_correlated(p, x->rate_markov, x->sample[RATE], spans[RATE]);
        }
    }
    if (due[ATTITUDE] && p->attitude_outage_interval > 0.0) {
        const Draw draw = {p->seed, x->sample[ATTITUDE], ATTITUDE_LOSS_NOISE};
        x->attitude_lost = plant_sensors_lost(x->attitude_lost, p->attitude_outage_interval,
                                              p->attitude_outage_duration, spans[ATTITUDE], draw);
    }
    if (due[ORBIT] && p->orbit_outage_interval > 0.0) {
        const Draw draw = {p->seed, x->sample[ORBIT], ORBIT_LOSS_NOISE};
        x->orbit_lost =
            plant_sensors_lost(x->orbit_lost, p->orbit_outage_interval, p->orbit_outage_duration, spans[ORBIT], draw);
    }
}

bool plant_sensors_step(const PlantSensorsLaw *law, PlantSensorsState *x, const PlantSensorsInputs *u, double h,
                        PlantSensorsOutputs *y, Fault *f)
{
    bool due[CLOCKS];
    double spans[CLOCKS];
    if (law->has_rod_coupling && !plant_sensors_has_dipole(u)) {
        return fault(f, "dipole", u->dipole[0], "to be connected, since field_rod_coupling is not zero");
    }
    if (law->p.attitude_sun_exclusion > 0.0 && !plant_sensors_has_sun_N(u)) {
        return fault(f, "sun_N", u->sun_N[0], "to be connected, since attitude_sun_exclusion is not zero");
    }
    for (int i = 0; i < CLOCKS; ++i) {
        int64_t periods = 1;
        spans[i] = h;
        if (law->periods[i] > 0.0 && !tick(law, i, h, &x->since[i], &periods, &spans[i], f)) {
            return false;
        }
        x->sample[i] += periods;
        due[i] = periods > 0;
    }
    remember(law, x, due, spans);
    measure(law, x, u, due, &x->held);
    *y = x->held;
    return true;
}
