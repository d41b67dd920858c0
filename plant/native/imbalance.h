/* Imbalance of the wheels, # not in the paper, whose wheel is symmetric.
 *
 * The mass centre of a wheel at r is d off its axis (static: U_s = m d), and a principal axis is tilted (dynamic: U_d,
 * the wheel's product of inertia). With e(theta) a unit vector across the axis that turns with the wheel, its momentum
 * about the satellite's centre of mass is, beside l_w u,
 *     (l_w/I_w) (U_d + U_s r^) de/dtheta = d/dt [(U_d + U_s r^) e],
 * so that at a speed w it acts by U_d w^2 e + r x U_s w^2 e. Over any time its mean is known in closed form: a step may
 * last longer than a turn of the wheel. Left out: the part of the satellite's inertia that turns with the wheel. */
#ifndef PLANT_IMBALANCE_H
#define PLANT_IMBALANCE_H

#include "vector.h"
#include "wheel.h"

/* (U_d + U_s r^) e is cosine cos(theta) + sine sin(theta), kg m2. */
typedef struct {
    Vector cosine, sine;
    double inertia; /* I_w, kg m2 */
} Imbalance;

/* e at the angle zero is axis x the body axis that is furthest from it, of equal ones the first. */
Imbalance plant_imbalance(Vector axis, double inertia, double product, double moment, Vector position);

/* (U_d + U_s r^) e of all, at their angles. */
Vector plant_imbalance_swing(const Imbalance each[PLANT_WHEELS], const double angle[PLANT_WHEELS]);

/* Its rate: momentum of all beside l_w u, N m s. */
Vector plant_imbalance_momentum(const Imbalance each[PLANT_WHEELS], const double angle[PLANT_WHEELS],
                                const double l_w[PLANT_WHEELS]);

/* Angles at time s after the start of a part of a step, at which they are `angle`; rad, within half a turn. */
void plant_imbalance_turned(const Imbalance each[PLANT_WHEELS], const Segment wheels[PLANT_WHEELS],
                            const double angle[PLANT_WHEELS], double s, double turned[PLANT_WHEELS]);

#endif
