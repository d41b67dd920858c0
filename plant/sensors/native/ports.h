/* Sensors of attitude, rate, field, wheel momentum, position and velocity: bias, white noise, sampling.
 * Generated from fmus/interfaces/plant_sensors.toml by python -m fmus.native; do not edit. */
#ifndef PLANT_SENSORS_PORTS_H
#define PLANT_SENSORS_PORTS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /* rad; Noise of the attitude about each body axis, 1 sigma */
    double attitude_noise;
    /* rad; frame B; Constant small rotation of the measured body axes, for example of a misaligned star
     * tracker */
    double attitude_bias_B[3];
    /* rad/s; Noise of the rate on each axis, 1 sigma */
    double rate_noise;
    /* rad/s; frame B; Bias of the rate */
    double rate_bias_B[3];
    /* T; Noise of the field on each axis, 1 sigma */
    double field_noise;
    /* T; frame B; Bias of the field */
    double field_bias_B[3];
    /* N.m.s; Noise of the wheel momentum, 1 sigma */
    double wheel_momentum_noise;
    /* m; Noise of the position on each axis, 1 sigma */
    double position_noise;
    /* m/s; Noise of the velocity on each axis, 1 sigma */
    double velocity_noise;
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
} PlantSensorsInputs;

typedef struct {
    /* frame N from B; Measured attitude R_NB exp(δ^), as orthonormal as R_NB */
    double R_NB_measured[3][3];
    /* rad/s; frame B; Measured body rate relative to N */
    double omega_B_measured[3];
    /* m; frame N; Measured position */
    double r_N_measured[3];
    /* m/s; frame N; Measured velocity */
    double v_N_measured[3];
    /* T; frame B; Measured geomagnetic field */
    double b_B_measured[3];
    /* N.m.s; Measured wheel momentum */
    double h_w_measured;
} PlantSensorsOutputs;

#endif
