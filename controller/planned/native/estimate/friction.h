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

/* How the measured change of momentum follows the torque, both about their means over some time, in which the wheel
 * stays where it is, or was stuck: (F5). */
typedef struct {
    double torque, rate;   /* N m, means */
    double square, common; /* (N m)2, variance of the torque, covariance of both */
    double jumps;          /* (N m)2, mean square of the torque's changes from sample to sample */
    double last, seen;     /* N m, torque of the last sample; s */
    double momentum;       /* N m s, where the wheel stays */
} Following;

/* d sign(l) + c l by a Kalman filter: d, Coulomb, N m; c, viscous, 1/s. */
typedef struct {
    double p[2], P[2][2];
    double variance;   /* (N m)2, of a sample's mean torque */
    double density[2]; /* (N m)2/s and 1/s3, of the changes of p */
    double torque_max, momentum_max;
    /* Of the measured change less that of command and friction, N m: filtered; of the last sample; the means of its
     * square and of its product with that of the sample before. */
    double slip, last, square, product;
    double forgets, followed, period; /* s; of the sums above, and of a sample */
    Response drag, stall;             /* to torques above a small and a large share of the limit */
    Following following;              /* at torques of any size */
    double rate, bends; /* N m, change of the momentum in the last sample; (N m)2, mean square of that one's change */
    double pushed;      /* N m s, what torques beyond friction should have given a wheel that stays about standstill */
    bool stuck;         /* it was seen not to follow its torque */
} Friction;

void controller_planned_friction_start(const ControllerPlannedParameters *p, double T, Friction *friction);

/* Takes a sample of dt with the motor's torque, N m, and the momenta at its ends, N m s. */
void controller_planned_friction_learn(double dt, double torque, double l, double l_next, Friction *friction);

/* Whether the wheel is stuck or drags: it has given less than half of what was asked of it. */
bool controller_planned_wheel_failed(const Friction *friction);

/* Whether the wheel has become stuck, or has been and follows its torque again; friction->stuck is then the other. */
bool controller_planned_wheel_changes(Friction *friction);

/* dl/dt over the sample, N m: the measured one, or where this is noise the one of command and friction. */
double controller_planned_wheel_rate(double dt, double torque, double l, double l_next, Friction *friction);

/* The torque against friction, N m, that goes with a change of the momentum l by `rate`, N m, over dt. */
double controller_planned_friction_torque(const Friction *friction, double l, double rate, double dt);

#endif
