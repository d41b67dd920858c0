/* The wheel's friction, from what its motor was commanded and how its momentum changed. */
#ifndef CONTROLLER_PLANNED_FRICTION_H
#define CONTROLLER_PLANNED_FRICTION_H

#include "ports.h"

/* d sign(l) + c l by a Kalman filter: d, Coulomb, N m; c, viscous, 1/s. */
typedef struct {
    double p[2], P[2][2];
    double variance;   /* (N m)2, of a sample's mean torque */
    double density[2]; /* (N m)2/s and 1/s3, of the changes of p */
    double torque_max, momentum_max;
} Friction;

void controller_planned_friction_start(const ControllerPlannedParameters *p, Friction *friction);

/* A sample of dt with the motor's torque, N m, and the momenta at its ends, N m s. */
void controller_planned_friction_learn(double dt, double torque, double l, double l_next, Friction *friction);

/* The torque against friction, N m, that goes with a change of the momentum l by `rate`, N m, over dt. */
double controller_planned_friction_torque(const Friction *friction, double l, double rate, double dt);

#endif
