/* A turn from rest to rest in the least time under limits of acceleration and rate: docs/how/planned-wheels.md, (4). */
#ifndef CONTROLLER_PLANNED_WHEELS_TURN_H
#define CONTROLLER_PLANNED_WHEELS_TURN_H

#include "vector.h"

typedef struct {
    double angle;              /* rad */
    double acceleration, rate; /* limits, rad/s2, rad/s */
} SlewTurn;

/* Angle that is left and rate, `time` s after the begin: (4). */
typedef struct {
    double left, rate;
} TurnPoint;

/* Time of the acceleration, and of the whole turn, s: (4). */
static inline double turn_rise(const SlewTurn *turn)
{
    return smaller(turn->rate / turn->acceleration, sqrt(turn->angle / turn->acceleration));
}

static inline double turn_time(const SlewTurn *turn)
{
    const double rise = turn_rise(turn);
    return rise > 0.0 ? turn->angle / (turn->acceleration * rise) + rise : 0.0;
}

static inline TurnPoint turn_at(const SlewTurn *turn, double time)
{
    const double a = turn->acceleration, rise = turn_rise(turn), whole = turn_time(turn), to_end = whole - time;
    if (time <= 0.0) {
        return (TurnPoint){turn->angle, 0.0};
    }
    if (to_end <= 0.0) {
        return (TurnPoint){0.0, 0.0};
    }
    if (time < rise) {
        return (TurnPoint){turn->angle - 0.5 * a * time * time, -a * time};
    }
    if (to_end < rise) {
        return (TurnPoint){0.5 * a * to_end * to_end, -a * to_end};
    }
    return (TurnPoint){turn->angle - a * rise * (time - 0.5 * rise), -a * rise};
}

#endif
