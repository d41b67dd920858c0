/* Attitude dynamics on SO(3): the Lie group variational integrator of a gyrostat, and its symmetric compositions.
 *
 * From the discrete Lagrangian L_d = (1/h) tr[(I - F) J_d] - 1/2 sum lm_i tr(u_i^ F), R+ = R F, with Pi = J Omega +
 * sum l_i u_i [12], u_i the axis of wheel i (the paper's e1), lm_i the mean of its l_w over the step and a = h (Pi + h/2
 * M(t)), the Cayley vector f of F solves
 *     (a - p) + a x f + ((a + p).f) f - 2 J f = 0,  p = h sum lm_i u_i,  and  Pi+ = F^T (Pi + h/2 M(t)) + h/2 M(t + h).
 * The wheels' torques are internal: R Pi is kept to rounding whatever they do. R is never reprojected.
 * Unforced: Lee, Leok and McClamroch, IEEE CCA 2005. Order 4: Suzuki 1990; order 6: Yoshida 1990, solution A. */
#ifndef PLANT_ATTITUDE_H
#define PLANT_ATTITUDE_H

#include "fault.h"
#include "imbalance.h"
#include "vector.h"
#include "wheel.h"

/* External moment, N m, body axes, at attitude R and time t. */
typedef Vector Moment(void *context, const Matrix *R, double t);

/* Told at which time the moment will be asked for next, while its attitude is still being solved: what depends on time
 * alone can be worked out meanwhile, since neither waits for the other in the processor. */
typedef void Announce(void *context, double t);

typedef struct {
    Matrix J, J_inverse, J_twice;    /* kg m2, wheels locked */
    double compliance;               /* trace of (2 J)^-1, which lengthens a vector by no more */
    Vector wheel_axes[PLANT_WHEELS]; /* unit */
    bool unbalanced;                 /* any wheel */
    Imbalance imbalances[PLANT_WHEELS];
} Body;

typedef struct {
    Matrix R;
    Vector Pi; /* N m s, body axes */
} Attitude;

/* Momentum of the wheels in body axes, of l_w and the angle of each. */
Vector plant_wheels_momentum(const Body *body, const double l_w[PLANT_WHEELS], const double angle[PLANT_WHEELS]);

/* From t, where the wheels are at `angle`, over a part of a step in which they move smoothly. order: 2, 4 or 6. */
bool plant_advance(const Body *body, int order, const Segment wheels[PLANT_WHEELS], const double angle[PLANT_WHEELS],
                   Moment *moment, Announce *announce, void *context, double t, Attitude *x, Fault *f);

#endif
