/* How the attitude turns over a step: by the measured rate, or, without a gyro, by the equations of motion. */
#ifndef ESTIMATOR_RATES_H
#define ESTIMATOR_RATES_H

#include "rotation.h"

/* The torques on a satellite of inertia J, kg m2, over a step. */
typedef struct {
    Matrix J, J_inverse;
    Vector dipole_B, field_N; /* A m2, T */
    Vector nadir_N;           /* sqrt(3 mu/r^3) times the unit position, 1/s */
    Vector wheel_B;           /* dl/dt of all wheels, N m */
    Vector disturbance_B;     /* N m */
} Torques;

/* The turn, rad, of a step of h s by the rates of the last measurement and of this one, `since` s apart. */
Vector estimator_turn_by_gyro(Vector before, Vector now, double h, double since);

/* Attitude and rate after h s, from the momentum of the wheels at their begin; returns the turn in all. Runge and Kutta, order 4, for the rate. */
Vector estimator_turn_by_dynamics(const Torques *torques, Vector momentum_B, double h, Matrix *R, Vector *omega);

/* The derivative, 1/s, of d omega/dt with omega. */
Matrix estimator_rate_growth(const Torques *torques, Vector omega, Vector momentum_B);

#endif
