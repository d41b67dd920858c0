/* Disturbance torque, own dipole, inertia and rod gain, from what was commanded and what was measured. */
#ifndef CONTROLLER_PLANNED_IDENTIFICATION_H
#define CONTROLLER_PLANNED_IDENTIFICATION_H

#include "scales.h"

enum { UNKNOWNS = 10, GAIN = 3, TORQUE = 4, DIPOLE = 7 };

/* p = (J11, J22, J33, gain of the rods, disturbance torque, residual dipole) by a Kalman filter on windows of a few
 * seconds. */
typedef struct {
    double p[UNKNOWNS], P[UNKNOWNS][UNKNOWNS];
    double start[TORQUE];         /* of inertias and gain */
    double disturbance_max, walk; /* N m; its change in a window, one standard deviation */
    double dipole_max;            /* A m2 */
    double rate_noise;            /* rad/s */
    double window;                /* s, of a balance of momentum */
    double noise;                 /* N m s, of a balance */
    double change_min;            /* rad/s, of the rate in a window that tells something of the inertia */
    double known_min;             /* N m s, of a known impulse, below which the scale of p cannot be observed */
    /* Sums over the window that is open. */
    double elapsed;
    Vector Omega_0;             /* rate at its beginning */
    double l_0;                 /* wheel momentum at its beginning */
    Vector products;            /* int (Om2 Om3, Om3 Om1, Om1 Om2) */
    Vector rods, others, wheel; /* int of the rods' nominal torque, of known torques, of Omega x l a */
    Vector field;               /* int of B */
} Identification;

/* `spread`: standard deviation of inertias and gain, relative; `disturbance_time`, s, over which the disturbance is forgotten;
 * `rate_noise`, rad/s, of the measured rates. */
void controller_planned_identification_start(const Scales *scales, const double inertia[3], double spread,
                                             double disturbance_time, double rate_noise, Identification *id);

/* Adds a sample of dt: the rates and wheel momenta at its ends, the rods' torque at gain 1 and the other known torque
 * over it (gravity gradient, products of inertia), the field; `wheel_axis` a, unit. A window that is full is used; it tells of disturbance and dipole alone
 * where `inertia` is false. */
void controller_planned_identify(double dt, Vector wheel_axis, Vector Omega, Vector Omega_next, double l, double l_next,
                                 Vector tau_rods, Vector tau_known, Vector B_B, bool inertia, Identification *id);

#endif
