/* How the rate of a turn follows from that of its rotation vector, and back. */
#ifndef COMMON_JACOBIAN_H
#define COMMON_JACOBIAN_H

#include "vector.h"

/* a = (1 - cos x)/x^2, b = (x - sin x)/x^3, a'/x and b'/x: of the right Jacobian I - a x^ + b x^^2. */
typedef struct {
    double a, b, da, db;
} RightJacobian;

/* Of a turn by x, rad. */
static inline RightJacobian right_jacobian_of(double x)
{
    static const double SMALL = 0.05; /* rad, below which the coefficients are taken from their series */
    const double x2 = x * x;
    if (x < SMALL) {
        return (RightJacobian){1.0 / 2.0 - x2 / 24.0 + x2 * x2 / 720.0, 1.0 / 6.0 - x2 / 120.0 + x2 * x2 / 5040.0,
                               -1.0 / 12.0 + x2 / 180.0 - x2 * x2 / 6720.0,
                               -1.0 / 60.0 + x2 / 1260.0 - x2 * x2 / 60480.0};
    }
    const double s = sin(x), c = cos(x), a = (1.0 - c) / x2, b = (x - s) / (x2 * x);
    return (RightJacobian){a, b, (s / x - 2.0 * a) / x2, (a - 3.0 * b) / x2};
}

/* (I - a phi^ + b phi^^2) v: d exp(phi^)/dt = exp(phi^) (this of dphi/dt)^. */
static inline Vector right_jacobian(const RightJacobian *k, Vector phi, Vector v)
{
    const Vector across = cross(phi, v);
    return add(subtract(v, scale(k->a, across)), scale(k->b, cross(phi, across)));
}

/* v with right_jacobian v = w. */
static inline Vector right_jacobian_solve(const RightJacobian *k, Vector phi, Vector w)
{
    const Vector x = right_jacobian(k, phi, (Vector){1.0, 0.0, 0.0}),
                 y = right_jacobian(k, phi, (Vector){0.0, 1.0, 0.0}),
                 z = right_jacobian(k, phi, (Vector){0.0, 0.0, 1.0});
    return solve(transposed((Matrix){x, y, z}), w);
}

#endif
