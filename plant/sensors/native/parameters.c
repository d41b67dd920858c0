/* The check of the parameters, and what follows from them alone. Tests: tests/native/test_flavours.py. */
#include "plant_sensors.h"
#include "rotation.h"

static const double PI = 3.14159265358979323846;
static const double PERIOD_MIN = 1e-6; /* s */
static const double ROUNDING = 1e-6;   /* of a unit vector */

static bool has_numbers(const PlantSensorsParameters *p, Fault *f)
{
    const NamedVector vectors[] = {
        {"attitude_bias_B", vector(p->attitude_bias_B)}, {"attitude_boresight_B", vector(p->attitude_boresight_B)},
        {"rate_bias_B", vector(p->rate_bias_B)},         {"field_bias_B", vector(p->field_bias_B)},
        {"fine_sun_axis_B", vector(p->fine_sun_axis_B)},
    };
    const struct {
        const char *name;
        Matrix value;
    } matrices[] = {{"rate_scale", matrix(p->rate_scale)},
                    {"field_scale", matrix(p->field_scale)},
                    {"field_rod_coupling", matrix(p->field_rod_coupling)}};
    const Named not_negative[] = {
        {"attitude_noise", p->attitude_noise},
        {"attitude_noise_about", p->attitude_noise_about},
        {"attitude_rate_max", p->attitude_rate_max},
        {"attitude_outage_interval", p->attitude_outage_interval},
        {"rate_noise", p->rate_noise},
        {"angle_random_walk", p->angle_random_walk},
        {"rate_random_walk", p->rate_random_walk},
        {"rate_instability", p->rate_instability},
        {"rate_range", p->rate_range},
        {"rate_quantum", p->rate_quantum},
        {"field_noise", p->field_noise},
        {"field_range", p->field_range},
        {"field_quantum", p->field_quantum},
        {"sun_sensor_noise", p->sun_sensor_noise},
        {"fine_sun_noise", p->fine_sun_noise},
        {"position_noise", p->position_noise},
        {"velocity_noise", p->velocity_noise},
        {"orbit_outage_interval", p->orbit_outage_interval},
        {"wheel_momentum_noise", p->wheel_momentum_noise},
        {"dipole_noise", p->dipole_noise},
    };
    const Named times[] = {{"attitude_outage_duration", p->attitude_outage_duration},
                           {"rate_instability_time", p->rate_instability_time},
                           {"orbit_outage_duration", p->orbit_outage_duration}};
    for (size_t i = 0; i < COUNT(matrices); ++i) {
        if (!is_finite_matrix(matrices[i].value)) {
            return fault(f, matrices[i].name, NAN, "finite numbers");
        }
    }
#if PLANT_SENSORS_WHEELS > 1
    for (int i = 0; i < PLANT_SENSORS_WHEELS; ++i) {
        if (!all_finite(&(Named){"wheel_momentum_bias", p->wheel_momentum_bias[i]}, 1, f)) {
            return false;
        }
    }
#endif
    return all_finite_vectors(vectors, COUNT(vectors), f) && all_not_negative(not_negative, COUNT(not_negative), f) &&
           all_positive(times, COUNT(times), f);
}

static bool has_ranges(const PlantSensorsParameters *p, Fault *f)
{
    const struct {
        Named of;
        double low, high;
        const char *expected;
    } ranges[] = {
        {{"attitude_sun_exclusion", p->attitude_sun_exclusion}, 0.0, PI, "0 to pi"},
        {{"attitude_earth_exclusion", p->attitude_earth_exclusion}, 0.0, PI, "0 to pi"},
        {{"sun_sensor_half_angle", p->sun_sensor_half_angle}, 0.0, 0.5 * PI, "0 to pi/2"},
        {{"albedo", p->albedo}, 0.0, 1.0, "0 to 1"},
        {{"sun_threshold", p->sun_threshold}, 1e-3, 1.0, "0.001 to 1"},
        {{"fine_sun_half_angle", p->fine_sun_half_angle}, 0.0, PI, "0 to pi"},
    };
    for (size_t i = 0; i < COUNT(ranges); ++i) {
        if (!(ranges[i].of.value >= ranges[i].low && ranges[i].of.value <= ranges[i].high)) {
            return fault(f, ranges[i].of.name, ranges[i].of.value, ranges[i].expected);
        }
    }
    return true;
}

static bool has_periods(const PlantSensorsParameters *p, Fault *f)
{
    const Named periods[] = {{"attitude_period", p->attitude_period}, {"rate_period", p->rate_period},
                             {"field_period", p->field_period},       {"orbit_period", p->orbit_period},
                             {"sun_period", p->sun_period},           {"telemetry_period", p->telemetry_period},
                             {"sensor_period", p->sensor_period}};
    for (size_t i = 0; i < COUNT(periods); ++i) {
        const double T = periods[i].value;
        if (!(T == 0.0 || (T >= PERIOD_MIN && isfinite(T)))) {
            const bool all = i + 1 == COUNT(periods);
            return fault(f, periods[i].name, T,
                         all ? "0 (every step) or at least 1e-06 s" : "0 (sensor_period) or at least 1e-06 s");
        }
    }
    return true;
}

static bool is_unit(const char *name, double length, Fault *f)
{
    return fabs(length - 1.0) <= ROUNDING || fault(f, name, length, "a unit vector, to 1e-06");
}

bool plant_sensors_check(const PlantSensorsParameters *p, Fault *f)
{
    if (!has_numbers(p, f) || !has_ranges(p, f) || !has_periods(p, f) ||
        !is_unit("attitude_boresight_B", norm(vector(p->attitude_boresight_B)), f) ||
        !is_unit("fine_sun_axis_B", norm(vector(p->fine_sun_axis_B)), f)) {
        return false;
    }
    for (int i = 0; i < SUN_SENSORS; ++i) {
        const double length = norm(vector(p->sun_sensor_axes[i]));
        if (!(length == 0.0 || fabs(length - 1.0) <= ROUNDING)) {
            return fault(f, "sun_sensor_axes", length, "rows of unit length, to 1e-06, or zeros");
        }
    }
    if (p->sun_sensor != PLANT_SENSORS_SUN_SENSOR_COARSE && p->sun_sensor != PLANT_SENSORS_SUN_SENSOR_FINE) {
        return fault(f, "sun_sensor", p->sun_sensor, "1 (coarse) or 2 (fine)");
    }
    return p->seed >= 0 || fault(f, "seed", p->seed, "at least 0");
}

static Vector unit(Vector x)
{
    const double length = norm(x);
    return length > 0.0 ? scale(1.0 / length, x) : x;
}

void plant_sensors_prepare(const PlantSensorsParameters *p, PlantSensorsLaw *law)
{
    const double periods[CLOCKS] = {p->attitude_period, p->rate_period, p->field_period,
                                    p->orbit_period,    p->sun_period,  p->telemetry_period};
    law->p = *p;
    for (int i = 0; i < CLOCKS; ++i) {
        law->periods[i] = periods[i] > 0.0 ? periods[i] : p->sensor_period;
    }
    for (int i = 0; i < SUN_SENSORS; ++i) {
        law->sun_axes[i] = unit(vector(p->sun_sensor_axes[i]));
    }
    law->boresight = unit(vector(p->attitude_boresight_B));
    law->fine_sun_axis = unit(vector(p->fine_sun_axis_B));
    law->turns_attitude =
        p->attitude_noise > 0.0 || p->attitude_noise_about > 0.0 || largest(vector(p->attitude_bias_B)) > 0.0;
    law->has_drift = p->rate_random_walk > 0.0 || p->rate_instability > 0.0;
    law->has_rate_error = law->has_drift || p->rate_noise > 0.0 || p->angle_random_walk > 0.0 || p->rate_range > 0.0 ||
                          p->rate_quantum > 0.0 || largest(vector(p->rate_bias_B)) > 0.0 ||
                          largest_element(matrix(p->rate_scale)) > 0.0;
    law->has_field_error = p->field_noise > 0.0 || p->field_range > 0.0 || p->field_quantum > 0.0 ||
                           largest(vector(p->field_bias_B)) > 0.0 || largest_element(matrix(p->field_scale)) > 0.0 ||
                           largest_element(matrix(p->field_rod_coupling)) > 0.0;
    law->has_rate_scale = largest_element(matrix(p->rate_scale)) > 0.0;
    law->has_field_scale = largest_element(matrix(p->field_scale)) > 0.0;
    law->has_rod_coupling = largest_element(matrix(p->field_rod_coupling)) > 0.0;
    law->cos_sun_exclusion = cos(p->attitude_sun_exclusion);
    law->cos_sun_sensor = larger(cos(p->sun_sensor_half_angle), 0.0);
    law->cos_fine_sun = cos(p->fine_sun_half_angle);
}
