/* Sensors of attitude, rate, field, Sun, position and velocity, and telemetry of wheel and rods: errors, periods, drop-outs.
 * Generated from fmus/interfaces/plant_sensors.toml by python -m fmus.native; do not edit. */
#ifndef PLANT_SENSORS_PORTS_H
#define PLANT_SENSORS_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    PLANT_SENSORS_SUN_SENSOR_COARSE = 1,
    PLANT_SENSORS_SUN_SENSOR_FINE = 2
};

typedef struct {
    /* rad; Noise of the attitude about each axis across the boresight, 1 sigma */
    double attitude_noise;
    /* rad; Noise of the attitude about the boresight, 1 sigma; 0: as across it */
    double attitude_noise_about;
    /* rad; frame B; Constant small rotation of the measured body axes, for example of a misaligned star
     * tracker */
    double attitude_bias_B[3];
    /* frame B; Boresight of the star tracker; of unit length to 1e-6 (normalised on use) */
    double attitude_boresight_B[3];
    /* rad/s; Body rate above which the star tracker gives no attitude; 0: none */
    double attitude_rate_max;
    /* rad; Angle from the boresight to the Sun below which the star tracker is blind; 0: none. Needs sun_N */
    double attitude_sun_exclusion;
    /* rad; Angle from the boresight to the Earth's limb below which the star tracker is blind; 0: none */
    double attitude_earth_exclusion;
    /* s; Mean time from the end of a drop-out of the star tracker to the next, exponentially distributed; 0:
     * none */
    double attitude_outage_interval;
    /* s; Mean duration of a drop-out of the star tracker, exponentially distributed */
    double attitude_outage_duration;
    /* s; Time between two measurements of the star tracker, from t = 0; 0: sample_period */
    double attitude_period;
    /* rad/s; White noise of the rate on each axis, 1 sigma, whatever the period */
    double rate_noise;
    /* rad/s; frame B; Bias of the rate, constant from t = 0 */
    double rate_bias_B[3];
    /* rad; Angle random walk N (IEEE 952) for a time of 1 s: the angle that the white noise of the rate adds
     * up to, 1 sigma. 0.06 deg/sqrt(h) is 0.001 deg */
    double angle_random_walk;
    /* rad/s; Rate random walk K (IEEE 952) for a time of 1 s: the change of the bias, 1 sigma */
    double rate_random_walk;
    /* rad/s; Exponentially correlated (Markov) noise of the rate (IEEE 952), 1 sigma: stands for the bias
     * instability. The largest Allan deviation is 0.617 times this, at 1.89 rate_instability_time */
    double rate_instability;
    /* s; Correlation time of rate_instability */
    double rate_instability_time;
    /* frame B; Scale-factor errors of the gyro (diagonal) and its misalignments (off the diagonal): the
     * measurement is that of (I + rate_scale) times the truth */
    double rate_scale[3][3];
    /* rad/s; Magnitude on each axis at which the rate is clipped; 0: none */
    double rate_range;
    /* rad/s; Resolution on each axis: the rate is rounded to a multiple of it; 0: none */
    double rate_quantum;
    /* s; Time between two measurements of the gyro, from t = 0; 0: sample_period */
    double rate_period;
    /* T; Noise of the field on each axis, 1 sigma */
    double field_noise;
    /* T; frame B; Bias of the field */
    double field_bias_B[3];
    /* frame B; Scale-factor errors of the magnetometer (diagonal) and its misalignments (off the diagonal):
     * the measurement is that of (I + field_scale) times the truth */
    double field_scale[3][3];
    /* T/(A.m2); frame B from rods; Field at the magnetometer for each rod's dipole: column i is that of rod
     * i. Needs dipole */
    double field_rod_coupling[3][3];
    /* T; Magnitude on each axis at which the field is clipped; 0: none */
    double field_range;
    /* T; Resolution on each axis: the field is rounded to a multiple of it; 0: none */
    double field_quantum;
    /* s; Time between two measurements of the magnetometer, from t = 0; 0: sample_period */
    double field_period;
    /* Which sensor gives sun_B_measured: the coarse ones by their least squares, or a fine one */
    int32_t sun_sensor;
    /* frame B; Rows: the unit axes of the coarse sun sensors (to 1e-6); zeros: there is no such sensor */
    double sun_sensor_axes[6][3];
    /* rad; Half angle of the field of view of each coarse sun sensor */
    double sun_sensor_half_angle;
    /* Noise of each signal of the coarse sun sensors, 1 sigma; 1: full light at normal incidence */
    double sun_sensor_noise;
    /* Part of the sunlight that the Earth reflects, which the coarse sun sensors see too; 0: none, about 0.3:
     * the Earth's mean */
    double albedo;
    /* Sun vector of the coarse sensors, or sunlight of the fine one, below which there is no sun_B_measured
     * */
    double sun_threshold;
    /* frame B; Boresight of the fine sun sensor; of unit length to 1e-6 (normalised on use) */
    double fine_sun_axis_B[3];
    /* rad; Half angle of the field of view of the fine sun sensor */
    double fine_sun_half_angle;
    /* rad; Noise of the fine sun sensor about each body axis, 1 sigma */
    double fine_sun_noise;
    /* s; Time between two measurements of the sun sensors, from t = 0; 0: sample_period */
    double sun_period;
    /* m; Noise of the position on each axis, 1 sigma */
    double position_noise;
    /* m/s; Noise of the velocity on each axis, 1 sigma */
    double velocity_noise;
    /* s; Mean time from the end of a drop-out of GNSS to the next, exponentially distributed; 0: none */
    double orbit_outage_interval;
    /* s; Mean duration of a drop-out of GNSS, exponentially distributed */
    double orbit_outage_duration;
    /* s; Time between two measurements of the GNSS receiver, from t = 0; 0: sample_period */
    double orbit_period;
    /* N.m.s; Noise of the wheel momentum, 1 sigma */
    double wheel_momentum_noise;
    /* A.m2; Noise of the measured dipole of each rod, 1 sigma */
    double dipole_noise;
    /* s; Time between two measurements of the wheel and of the rods, from t = 0; 0: sample_period */
    double telemetry_period;
    /* s; Time between two measurements, from t = 0; the outputs are held between measurements. 0: a
     * measurement at every communication step; otherwise at least 1 us */
    double sample_period;
    /* Seed of the noise; runs with the same seed have the same noise */
    int32_t seed;
} PlantSensorsParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* T; frame B; Geomagnetic field */
    double b_B[3];
    /* N.m.s; Wheel momentum l_w */
    double h_w;
    /* frame N; Unit vector from the satellite to the Sun; optional; 1e9 means not connected */
    double sun_N[3];
    /* Part of the Sun's disc that is visible, 0 to 1; 1 where it is not connected; optional; 1e9 means not
     * connected */
    double sunlight;
    /* A.m2; frame rods; Dipole of each rod along its axis; the plant's dipole_mean has no direct feedthrough
     * and closes no algebraic loop; optional; 1e9 means not connected */
    double dipole[3];
} PlantSensorsInputs;

typedef struct {
    /* frame N from B; Attitude by the star tracker, R_NB exp(δ^), as orthonormal as R_NB; zeros while it
     * gives none */
    double R_NB_measured[3][3];
    /* rad/s; frame B; Body rate relative to N by the gyro */
    double omega_B_measured[3];
    /* m; frame N; Position by GNSS; held through a drop-out */
    double r_N_measured[3];
    /* m/s; frame N; Velocity by GNSS; held through a drop-out */
    double v_N_measured[3];
    /* T; frame B; Geomagnetic field by the magnetometer, the rods' field included */
    double b_B_measured[3];
    /* N.m.s; Wheel momentum by telemetry */
    double h_w_measured;
    /* Signal of each coarse sun sensor, 1 in full light at normal incidence; zero where its axis is zero or
     * sun_N is not connected */
    double sun_sensors[6];
    /* frame B; Measured unit vector to the Sun; zeros where there is none */
    double sun_B_measured[3];
    /* A.m2; frame rods; Dipole of each rod by telemetry; zero where dipole is not connected */
    double dipole_measured[3];
    /* Number of measurements of the gyro up to now; a measurement is new where its number has changed. From
     * 2147483647 it goes on at 1 */
    int32_t rate_sample;
    /* Number of measurements of the magnetometer up to now */
    int32_t field_sample;
    /* Number of attitudes of the star tracker up to now: those without outage and blinding */
    int32_t attitude_sample;
    /* Number of fixes of GNSS up to now: those without drop-out */
    int32_t orbit_sample;
    /* Number of measured sun vectors up to now: those with sun_B_measured other than zeros */
    int32_t sun_sample;
} PlantSensorsOutputs;

/* An optional input is not connected where an element is this large. */
#define PLANT_SENSORS_ABSENT_MIN 999000000.0

static inline bool plant_sensors_has_sun_N(const PlantSensorsInputs *u)
{
    return !(fabs(u->sun_N[0]) >= PLANT_SENSORS_ABSENT_MIN ||
             fabs(u->sun_N[1]) >= PLANT_SENSORS_ABSENT_MIN ||
             fabs(u->sun_N[2]) >= PLANT_SENSORS_ABSENT_MIN);
}

static inline bool plant_sensors_has_sunlight(const PlantSensorsInputs *u)
{
    return !(fabs(u->sunlight) >= PLANT_SENSORS_ABSENT_MIN);
}

static inline bool plant_sensors_has_dipole(const PlantSensorsInputs *u)
{
    return !(fabs(u->dipole[0]) >= PLANT_SENSORS_ABSENT_MIN ||
             fabs(u->dipole[1]) >= PLANT_SENSORS_ABSENT_MIN ||
             fabs(u->dipole[2]) >= PLANT_SENSORS_ABSENT_MIN);
}

#endif
