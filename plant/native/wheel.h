/* The reaction wheel: its momentum over a step, in closed form, within its limits.
 *
 * l_w is I_w times the speed relative to the body; with motor torque tau, viscous friction c and Coulomb friction d
 *     dl_w/dt = tau - (c/I_w) l_w - d sign(l_w).
 * A step is divided where the wheel reaches its limit or, with Coulomb friction, stands still, so that l_w is smooth in
 * each part. Friction and limit are not in the paper, which takes the wheel as ideal. */
#ifndef PLANT_WHEEL_H
#define PLANT_WHEEL_H

#include <stdbool.h>

typedef struct {
    double momentum_max; /* N m s */
    double torque_max;   /* N m */
    double decay;        /* viscous friction over inertia, 1/s */
    double coulomb;      /* N m */
} Wheel;

/* Part of a step in which dl_w/dt = drive - decay l_w. */
typedef struct {
    double duration, l_start, l_end, drive, decay;
} Segment;

/* Standstill, then the limit, then rest: no more parts than these, and one to spare. */
enum { SEGMENTS_MAX = 4 };

int plant_wheel_segments(const Wheel *wheel, double momentum, double command, double h, Segment parts[SEGMENTS_MAX]);

/* l_w at time s after the segment's start, which may lie outside it. */
double plant_segment_momentum(const Segment *part, double s);

/* Mean of l_w over [s, s + duration]; the duration may be negative. */
double plant_segment_mean(const Segment *part, double s, double duration);

/* dl_w/dt: motor and friction; zero where it would pass the limit, and then *at_limit where something drives it. */
double plant_wheel_net_torque(const Wheel *wheel, double momentum, double command, bool *at_limit);

#endif
