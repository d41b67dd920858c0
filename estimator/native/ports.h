/* Attitude, rate and gyro bias from magnetometer, Sun sensors, star tracker, gyro and GNSS: multiplicative extended Kalman filter.
 * Generated from fmus/interfaces/estimator.toml by python -m fmus.native; do not edit. */
#ifndef ESTIMATOR_PORTS_H
#define ESTIMATOR_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    ESTIMATOR_RATE_SOURCE_GYRO = 1,
    ESTIMATOR_RATE_SOURCE_DYNAMICS = 2
};

enum {
    ESTIMATOR_FIELD_MODEL_IGRF14 = 1,
    ESTIMATOR_FIELD_MODEL_WMM2010 = 2,
    ESTIMATOR_FIELD_MODEL_WMM2015 = 3,
    ESTIMATOR_FIELD_MODEL_WMM2020 = 4,
    ESTIMATOR_FIELD_MODEL_WMM2025 = 5
};

typedef struct {
    /* 'gyro': the attitude follows the measured rate; 'dynamics': there is no gyro, and the rate follows the
     * equations of motion */
    int32_t rate_source;
    /* rad; Gyro: standard deviation that the white noise of the rate gives to the angle in 1 s; that of a
     * sample times the root of its period in s, or deg/sqrt(h) over 60 */
    double angle_random_walk;
    /* rad/s; Gyro: standard deviation of the change of the bias in 1 s */
    double rate_random_walk;
    /* rad/s; Gyro: standard deviation of the bias at the start, in each axis. Where rate_source is
     * 'dynamics', that of the rate */
    double rate_bias_sigma;
    /* kg.m2; frame B; Inertia with the wheel locked, for rate_source 'dynamics'; symmetric, positive
     * definite, with each principal moment at most the sum of the others */
    double J_B[3][3];
    /* frame B; Rows: the rods' unit axes u1, u2, u3, for rate_source 'dynamics'; of unit length to 1e-6 */
    double rod_axes[3][3];
    /* frame B; Unit axis of the wheel, for rate_source 'dynamics'; of unit length to 1e-6 */
    double wheel_axis[3];
    /* N.m.s; Dynamics: standard deviation that torques which are not modelled give to the momentum in 1 s, in
     * each axis */
    double momentum_random_walk;
    /* T; Standard deviation of the measured field from the onboard model in each axis, sensor and model
     * together */
    double field_noise;
    /* T; Standard deviation of the magnetometer's bias at the start; with 0, and field_random_walk 0, no bias
     * is estimated */
    double field_bias_sigma;
    /* T; Standard deviation of the change of the magnetometer's bias in 1 s */
    double field_random_walk;
    /* T/(A.m2); frame B, rods; Field of the rods at the magnetometer: column i is that of rod i for each A.m2
     * of its dipole */
    double rod_field[3][3];
    /* Standard deviation of rod_field as part of it: what the noise of the field grows by with the dipoles */
    double rod_field_error;
    /* A.m2; The field is not used where a rod has a larger dipole */
    double dipole_limit;
    /* rad; Standard deviation of the measured Sun direction about each axis across it */
    double sun_noise;
    /* rad; Star tracker: standard deviation about the axes across its boresight */
    double attitude_noise;
    /* rad; Star tracker: standard deviation about its boresight */
    double attitude_noise_boresight;
    /* frame B; Star tracker: direction of its boresight, of unit length to 1e-6 */
    double boresight_B[3];
    /* A measurement is not used where its normalised innovation squared is above this (chi-square of 3, for
     * the Sun 2, degrees of freedom) */
    double gate;
    /* rad; The attitude is valid below this standard deviation about each axis */
    double valid_sigma;
    /* s; Time over which measured positions and velocities are averaged; 0: each as it is */
    double orbit_time;
    /* Whether the propagated orbit feels the Earth's oblateness, J2 */
    bool j2;
    /* m3/s2; mu of the Earth (WGS 84) */
    double gravitational_parameter;
    /* UTC at t = 0, ISO 8601, with the time of day; with Z, +00:00, -00:00 or no zone at its end */
    char epoch[128];
    /* Onboard model of the geomagnetic field, at the year of epoch */
    int32_t field_model;
    /* Degree to which the onboard field is evaluated; 1 is a tilted dipole */
    int32_t field_degree;
    /* T; Deliberate error for tests, added to g10, g11, h11 of the onboard field model */
    double field_error[3];
} EstimatorParameters;

typedef struct {
    /* rad/s; frame B; Rate that the gyro measures; not used where rate_source is 'dynamics' */
    double omega_B_measured[3];
    /* T; frame B; Field that the magnetometer measures; a vector of zeros is no measurement */
    double b_B_measured[3];
    /* m; frame N; Measured position; a vector of zeros is no measurement */
    double r_N_measured[3];
    /* m/s; frame N; Measured velocity */
    double v_N_measured[3];
    /* frame N from B; Attitude that a star tracker measures, orthonormal to 1e-4; a matrix of zeros is no
     * measurement; optional; 1e9 means not connected */
    double R_NB_measured[3][3];
    /* frame B; Measured direction to the Sun, of any length; a vector of zeros is no measurement; optional;
     * 1e9 means not connected */
    double sun_B_measured[3];
    /* Number of the last valid measurement of omega_B_measured, from 1; the measurement is new where the
     * number has changed. If not connected, each step has a new one; optional; -1 means not connected */
    int32_t rate_sample;
    /* The same of b_B_measured; optional; -1 means not connected */
    int32_t field_sample;
    /* The same of R_NB_measured; optional; -1 means not connected */
    int32_t attitude_sample;
    /* The same of r_N_measured and v_N_measured; optional; -1 means not connected */
    int32_t orbit_sample;
    /* The same of sun_B_measured; optional; -1 means not connected */
    int32_t sun_sample;
    /* A.m2; frame rods; Dipoles of the rods, each along its axis, over the sample that ends: their field
     * disturbs the magnetometer, and they turn the satellite. If not connected, there are none; optional; 1e9
     * means not connected */
    double dipole[3];
    /* N.m.s; Wheel momentum l_w, for rate_source 'dynamics'. If not connected, it is computed from
     * wheel_torque; optional; 1e9 means not connected */
    double h_w;
    /* N.m; dl_w/dt over the sample that ends, for rate_source 'dynamics'. If not connected, it is computed
     * from h_w; optional; 1e9 means not connected */
    double wheel_torque;
} EstimatorInputs;

typedef struct {
    /* frame N from B; Estimated attitude; a matrix of zeros until the first attitude is known */
    double R_NB[3][3];
    /* rad/s; frame B; Estimated body rate relative to N: the measured rate without its estimated bias */
    double omega_B[3];
    /* m; frame N; Position, propagated where there is no new measurement */
    double r_N[3];
    /* m/s; frame N; Velocity, propagated where there is no new measurement */
    double v_N[3];
    /* T; frame B; Field at the satellite: as measured, without its estimated bias and the rods' field; by the
     * model and the attitude where the measurement is not used */
    double b_B[3];
    /* rad/s; frame B; Estimated bias of the gyro; zero where rate_source is 'dynamics' */
    double rate_bias_B[3];
    /* T; frame B; Estimated bias of the magnetometer */
    double field_bias_B[3];
    /* rad; frame B; Standard deviation of the attitude about each body axis; pi until the first attitude is
     * known */
    double attitude_sigma_B[3];
    /* rad2, rad2, rad2, rad2/s, rad2/s, rad2/s, rad2, rad2, rad2, rad2/s, rad2/s, rad2/s, rad2, rad2, rad2,
     * rad2/s, rad2/s, rad2/s, rad2/s, rad2/s, rad2/s, rad2/s2, rad2/s2, rad2/s2, rad2/s, rad2/s, rad2/s,
     * rad2/s2, rad2/s2, rad2/s2, rad2/s, rad2/s, rad2/s, rad2/s2, rad2/s2, rad2/s2; frame B; Covariance of
     * the attitude's error (small turn in body axes) and of the error of rate_bias_B; of omega_B where
     * rate_source is 'dynamics' */
    double covariance[6][6];
    /* Whether there is an attitude, and its standard deviation is below valid_sigma about each axis */
    bool attitude_valid;
    /* Normalised innovation squared of the last measurement of field, Sun and star tracker; without errors of
     * model its mean is 3, 2 and 3 */
    double nis[3];
    /* Number of measurements of field, Sun and star tracker that were not used, since their nis was above
     * gate */
    int32_t rejected[3];
    /* frame N; Unit vector to the Sun by the onboard model */
    double sun_N[3];
    /* Part of the Sun that the Earth does not cover, by the onboard model: 0 in the umbra, 1 in full light */
    double sunlight;
} EstimatorOutputs;

/* An optional input is not connected where an element is this large. */
#define ESTIMATOR_ABSENT_MIN 999000000.0

static inline bool estimator_has_R_NB_measured(const EstimatorInputs *u)
{
    return !(fabs(u->R_NB_measured[0][0]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[0][1]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[0][2]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[1][0]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[1][1]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[1][2]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[2][0]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[2][1]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->R_NB_measured[2][2]) >= ESTIMATOR_ABSENT_MIN);
}

static inline bool estimator_has_sun_B_measured(const EstimatorInputs *u)
{
    return !(fabs(u->sun_B_measured[0]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->sun_B_measured[1]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->sun_B_measured[2]) >= ESTIMATOR_ABSENT_MIN);
}

static inline bool estimator_has_rate_sample(const EstimatorInputs *u)
{
    return !(u->rate_sample < 0);
}

static inline bool estimator_has_field_sample(const EstimatorInputs *u)
{
    return !(u->field_sample < 0);
}

static inline bool estimator_has_attitude_sample(const EstimatorInputs *u)
{
    return !(u->attitude_sample < 0);
}

static inline bool estimator_has_orbit_sample(const EstimatorInputs *u)
{
    return !(u->orbit_sample < 0);
}

static inline bool estimator_has_sun_sample(const EstimatorInputs *u)
{
    return !(u->sun_sample < 0);
}

static inline bool estimator_has_dipole(const EstimatorInputs *u)
{
    return !(fabs(u->dipole[0]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->dipole[1]) >= ESTIMATOR_ABSENT_MIN ||
             fabs(u->dipole[2]) >= ESTIMATOR_ABSENT_MIN);
}

static inline bool estimator_has_h_w(const EstimatorInputs *u)
{
    return !(fabs(u->h_w) >= ESTIMATOR_ABSENT_MIN);
}

static inline bool estimator_has_wheel_torque(const EstimatorInputs *u)
{
    return !(fabs(u->wheel_torque) >= ESTIMATOR_ABSENT_MIN);
}

#endif
