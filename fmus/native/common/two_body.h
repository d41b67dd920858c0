/* A two-body orbit. */
#ifndef COMMON_TWO_BODY_H
#define COMMON_TWO_BODY_H

#include "vector.h"

/* Through a position and a velocity at a time; an ellipse. */
typedef struct {
    double t, mu;
    Vector r, v;
} TwoBody;

/* Position and velocity at t, by Lagrange's coefficients of the change in eccentric anomaly. */
/*@ requires \valid_read(orbit) && \initialized(orbit) && \valid(r_N) && \valid(v_N);
    requires \separated(orbit, r_N, v_N);
    assigns *r_N, *v_N \from *orbit, t;
    ensures \initialized(r_N) && \initialized(v_N); */
#ifdef PROOF_APART
extern void two_body_at(const TwoBody *orbit, double t, Vector *r_N, Vector *v_N);
#else
static inline void two_body_at(const TwoBody *orbit, double t, Vector *r_N, Vector *v_N)
{
    const double mu = orbit->mu, dt = t - orbit->t;
    const double r0 = norm(orbit->r);
    const double a = 1.0 / (2.0 / r0 - dot(orbit->v, orbit->v) / mu);
    const double n = sqrt(mu / (a * a * a));
    const double p = 1.0 - r0 / a, q = dot(orbit->r, orbit->v) / sqrt(mu * a); /* e cos E0, e sin E0 */
    double E = n * dt, c = 1.0, s = 0.0;
    for (int i = 0; i < 30; ++i) {
        c = cos(E);
        s = sin(E);
        const double change = (E - p * s + q * (1.0 - c) - n * dt) / (1.0 - p * c + q * s);
        E -= change;
        if (fabs(change) < 1e-13) {
            break;
        }
    }
    c = cos(E);
    s = sin(E);
    const double r = a * (1.0 - p * c + q * s);
    const double f = 1.0 - a / r0 * (1.0 - c), g = dt + (s - E) / n;
    const double df = -sqrt(mu * a) * s / (r * r0), dg = 1.0 - a / r * (1.0 - c);
    *r_N = add(scale(f, orbit->r), scale(g, orbit->v));
    *v_N = add(scale(df, orbit->r), scale(dg, orbit->v));
}
#endif

#endif
