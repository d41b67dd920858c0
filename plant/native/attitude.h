/* Attitude dynamics on SO(3): the Lie group variational integrator of a gyrostat, and its symmetric compositions.
 *
 * From the discrete Lagrangian L_d = (1/h) tr[(I - F) J_d] - 1/2 lm tr(u^ F), R+ = R F, with Pi = J Omega + l_w u
 * [12], u the wheel's axis (the paper's e1), lm the mean of l_w over the step and a = h (Pi + h/2 M(t)), the Cayley
 * vector f of F solves
 *     (a - p) + a x f + ((a + p).f) f - 2 J f = 0,  p = h lm u,   and then   Pi+ = F^T (Pi + h/2 M(t)) + h/2 M(t + h).
 * The wheel's torque is internal: R Pi is kept to rounding whatever the wheel does. R is never reprojected.
 * Unforced: Lee, Leok and McClamroch, IEEE CCA 2005. Order 4: Suzuki 1990; order 6: Yoshida 1990, solution A. */
#ifndef PLANT_ATTITUDE_H
#define PLANT_ATTITUDE_H

#include "fault.h"
#include "vector.h"
#include "wheel.h"

/* External moment, N m, body axes, at attitude R and time t. */
typedef Vector Moment(void *context, const Matrix *R, double t);

/* Told at which time the moment will be asked for next, while its attitude is still being solved: what depends on time
 * alone can be worked out meanwhile, since neither waits for the other in the processor. */
typedef void Announce(void *context, double t);

typedef struct {
    Matrix J, J_inverse, J_twice; /* kg m2, wheel locked */
    double compliance;            /* trace of (2 J)^-1, which lengthens a vector by no more */
    Vector wheel_axis;            /* unit */
} Body;

typedef struct {
    Matrix R;
    Vector Pi; /* N m s, body axes */
} Attitude;

/* From t over a part of a step in which the wheel moves smoothly. order: 2, 4 or 6. */
bool plant_advance(const Body *body, int order, const Segment *wheel, Moment *moment, Announce *announce, void *context,
                   double t, Attitude *x, Fault *f);

#endif
