/* The total momentum led to the target's in least time, whatever the attitude does. */
#ifndef CONTROLLER_PLANNED_STEERING_H
#define CONTROLLER_PLANNED_STEERING_H

#include "../motion.h"

enum { STEERING_NODES = 161 };

/* The costate of the minimum-time problem, and the time that is left. */
typedef struct {
    Vector lambda_N; /* unit */
    double time;     /* s */
} Steering;

/* Improves the costate for the momentum D_N that is still to be given, by dipoles of at most `dipole`, A m2, in the
 * field ahead; `unit`, s, is the satellite's time T; `field` is scratch. A zero costate is started anew. */
void controller_planned_steer(const Ahead *ahead, double t, Vector D_N, double dipole, double unit,
                              Vector field[STEERING_NODES], Steering *steering);

/* Controls of the rods, -1 to 1: across the field B_B in the costate's direction, at full strength but at the very
 * end. */
void controller_planned_steering_rods(const Steering *steering, Matrix R, Vector B_B, const Vector rods[3], double unit,
                                      double u[3]);

#endif
