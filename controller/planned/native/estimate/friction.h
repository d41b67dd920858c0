/* The wheel's friction and what the wheel did, from what its motor was commanded and how its measured momentum
 * changed. */
#ifndef CONTROLLER_PLANNED_FRICTION_H
#define CONTROLLER_PLANNED_FRICTION_H

#include "controller_planned_ports.h"

/* What a wheel gives of its torque: the torque's mean square, (N m)2, that with the change of momentum instead, and
 * of how much time, s. */
typedef struct {
    double asked, given, seen;
} Response;

/* d sign(l) + c l by a Kalman filter: d, Coulomb, N m; c, viscous, 1/s. */
typedef struct {
    double p[2], P[2][2];
    double variance;   /* (N m)2, of a sample's mean torque */
    double density[2]; /* (N m)2/s and 1/s3, of the changes of p */
    double torque_max, momentum_max;
    /* Of the measured change less that of command and friction, N m: filtered; of the last sample; the means of its
     * square and of its product with that of the sample before. */
    double slip, last, square, product;
    double forgets;       /* s */
    Response drag, stall; /* to torques above a small and a large share of the limit */
} Friction;

void controller_planned_friction_start(const ControllerPlannedParameters *p, double T, Friction *friction);

/* Takes a sample of dt with the motor's torque, N m, and the momenta at its ends, N m s. */
void controller_planned_friction_learn(double dt, double torque, double l, double l_next, Friction *friction);

/* Whether the wheel is stuck or drags: it has given less than half of what was asked of it. */
bool controller_planned_wheel_failed(const Friction *friction);

/* Whether it is stuck: it has given next to nothing of the largest torques, where a wheel that drags gives
 * something. */
bool controller_planned_wheel_stuck(const Friction *friction);

/* dl/dt over the sample, N m: the measured one, or where this is noise the one of command and friction. */
double controller_planned_wheel_rate(double dt, double torque, double l, double l_next, Friction *friction);

/* The torque against friction, N m, that goes with a change of the momentum l by `rate`, N m, over dt. */
double controller_planned_friction_torque(const Friction *friction, double l, double rate, double dt);

#endif
