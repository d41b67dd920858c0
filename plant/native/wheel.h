/* Reaction wheels: the momentum of each over a step, in closed form, within its limits.
 *
 * l_w is I_w times the speed relative to the body; with motor torque tau, viscous friction c and Coulomb friction d
 *     dl_w/dt = tau - (c/I_w) l_w - d sign(l_w).
 * A step is divided where a wheel reaches its limit or, with Coulomb friction, stands still, so that each l_w is smooth
 * in each part. Friction and limit are not in the paper, which takes the wheel as ideal. */
#ifndef PLANT_WHEEL_H
#define PLANT_WHEEL_H

#include <stdbool.h>

#include "plant_ports.h"

typedef struct {
    double momentum_max; /* N m s */
    double torque_max;   /* N m */
    double decay;        /* viscous friction over inertia, 1/s */
    double coulomb;      /* N m */
    double breakaway;    /* motor torque at rest above which it turns, N m; at least that of Coulomb */
    double gain;         /* of the drive */
} Wheel;

/* Part of a step in which dl_w/dt = drive - decay l_w. */
typedef struct {
    double duration, l_start, l_end, drive, decay;
} Segment;

/* The first smooth part of h s of all wheels, none of whose l_w changes its law in it; returns its duration. */
double plant_wheels_part(const Wheel wheels[PLANT_WHEELS], const double momentum[PLANT_WHEELS],
                         const double command[PLANT_WHEELS], double h, Segment parts[PLANT_WHEELS]);

/* l_w at time s after the segment's start, which may lie outside it. */
double plant_segment_momentum(const Segment *part, double s);

/* Mean of l_w over [s, s + duration]; the duration may be negative. */
double plant_segment_mean(const Segment *part, double s, double duration);

/* dl_w/dt: motor and friction; zero where it would pass the limit, and then *at_limit where something drives it. */
double plant_wheel_net_torque(const Wheel *wheel, double momentum, double command, bool *at_limit);

#endif
