/* The least time in which rods take momentum away that the wheels cannot hold: docs/how/planned-wheels.md, (7). The
 * steering of controller_planned, on the field of a dipole along the Earth's axis: each sample corrects it. */
#ifndef CONTROLLER_PLANNED_WHEELS_SHEDDING_H
#define CONTROLLER_PLANNED_WHEELS_SHEDDING_H

#include "rotation.h"

enum { SHEDDING_NODES = 120 };

static const double SHEDDING_TURN = 0.06;     /* rad of the orbit from node to node */
static const double SHEDDING_DIPOLE = 7.8e15; /* T m3, of the Earth */
static const double SHEDDING_REGULAR = 1e-3;  /* of the mean of M: what no field of the horizon takes away */
static const double SHEDDING_NEAR = 0.02;     /* |b x lambda| over |b|, below which the field gives no direction */

/* The direction lambda in which the rods' torque takes the momentum D_N away in the least time, by one iteration from
 * `before`; dipole is theirs, A m2. Both are unit vectors in N. */
static inline Vector shedding_direction(Vector D_N, Vector before, double dipole, Vector r_N, Vector v_N)
{
    const Vector across = cross(r_N, v_N), north = {0.0, 0.0, 1.0};
    const double r = norm(r_N), size = norm(across);
    if (!(r > 1.0 && size > 0.0 && norm(D_N) > 0.0)) {
        return direction(1.0, D_N);
    }
    const double time = SHEDDING_TURN * r * r / size; /* s from node to node, on a circle through r */
    const Vector radial = scale(1.0 / r, r_N), ahead = cross(scale(1.0 / size, across), radial);
    Matrix M = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    Vector lambda = before;
    for (int i = 0; i < SHEDDING_NODES; ++i) {
        const double angle = (i + 0.5) * SHEDDING_TURN;
        const Vector up = add(scale(cos(angle), radial), scale(sin(angle), ahead));
        const Vector b = scale(SHEDDING_DIPOLE / (r * r * r), subtract(north, scale(3.0 * dot(north, up), up)));
        const double B = norm(b), part = dipole * time / larger(norm(cross(b, before)), SHEDDING_NEAR * B);
        M = add_scaled(M, part * B * B, identity);
        M = add_scaled(M, -part, (Matrix){scale(b.x, b), scale(b.y, b), scale(b.z, b)});
        const double regular = SHEDDING_REGULAR * (M.a.x + M.b.y + M.c.z) / 3.0;
        lambda = solve(add_scaled(M, regular, identity), D_N);
        if (norm(lambda) <= 1.0) { /* the time suffices */
            break;
        }
    }
    return direction(1.0, lambda);
}

#endif
