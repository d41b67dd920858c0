/* Tests: tests/native/test_flavours.py. */
#include "pointing.h"

static const double RADIUS = 6378137.0, FLATTENING = 1.0 / 298.257223563; /* m; WGS 84 */
static const double OPPOSITE = 1e-12; /* 1 + cosine of two directions below which they are taken as opposite */

Vector supervisor_point_on_earth(double latitude, double longitude, double height)
{
    const double e2 = FLATTENING * (2.0 - FLATTENING), s = sin(latitude), c = cos(latitude);
    const double across = RADIUS / sqrt(1.0 - e2 * s * s), from_axis = (across + height) * c;
    return (Vector){from_axis * cos(longitude), from_axis * sin(longitude), (across * (1.0 - e2) + height) * s};
}

/* The direction of a vector that moves. */
static Moving unit(Moving d)
{
    const double size = norm(d.p);
    const Vector u = scale(1.0 / size, d.p);
    const double change = dot(u, d.dp);
    const Vector du = scale(1.0 / size, subtract(d.dp, scale(change, u)));
    const double bend = dot(u, d.ddp) + dot(du, d.dp);
    return (Moving){u, du, scale(1.0 / size, subtract(subtract(d.ddp, scale(2.0 * change, du)), scale(bend, u)))};
}

Moving supervisor_line_of_sight(Vector point, double angle, Vector r, Vector v, double mu)
{
    const double c = cos(angle), s = sin(angle), size = norm(r);
    const Vector w = {0.0, 0.0, SUPERVISOR_EARTH_RATE};
    const Vector p = {c * point.x - s * point.y, s * point.x + c * point.y, point.z};
    const Vector dp = cross(w, p);
    return unit((Moving){subtract(p, r), subtract(dp, v), add(cross(w, dp), scale(mu / (size * size * size), r))});
}

double supervisor_elevation(Vector point, double latitude, double longitude, double angle, Vector r)
{
    const double c = cos(angle), s = sin(angle);
    const Vector up = {cos(latitude) * cos(longitude), cos(latitude) * sin(longitude), sin(latitude)};
    const Vector d = subtract((Vector){c * r.x + s * r.y, c * r.y - s * r.x, r.z}, point);
    return atan2(dot(d, up), norm(cross(d, up)));
}

/* u x v of two that move. */
static Moving moving_cross(Moving u, Moving v)
{
    return (Moving){cross(u.p, v.p), add(cross(u.dp, v.p), cross(u.p, v.dp)),
                    add(add(cross(u.ddp, v.p), scale(2.0, cross(u.dp, v.dp))), cross(u.p, v.ddp))};
}

Reference supervisor_steered(Moving z, Vector normal, double yaw)
{
    const Vector still = {0.0, 0.0, 0.0};
    const Moving x = unit(moving_cross((Moving){scale(-1.0, normal), still, still}, z)), y = moving_cross(z, x);
    const Vector Omega = {dot(z.p, y.dp), dot(x.p, z.dp), dot(y.p, x.dp)};
    const Vector dOmega = {dot(z.dp, y.dp) + dot(z.p, y.ddp), dot(x.dp, z.dp) + dot(x.p, z.ddp),
                           dot(y.dp, x.dp) + dot(y.p, x.ddp)};
    const double c = cos(yaw), s = sin(yaw);
    const Matrix turn = {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
    const Matrix axes = transposed((Matrix){x.p, y.p, z.p});
    return (Reference){multiply(axes, turn), apply_transposed(turn, Omega), apply_transposed(turn, dOmega)};
}

/* diagonal I + factor w w^T + v^. */
static Matrix turn_of(double diagonal, double factor, Vector w, Vector v)
{
    return (Matrix){{diagonal + factor * w.x * w.x, factor * w.x * w.y - v.z, factor * w.x * w.z + v.y},
                    {factor * w.y * w.x + v.z, diagonal + factor * w.y * w.y, factor * w.y * w.z - v.x},
                    {factor * w.z * w.x - v.y, factor * w.z * w.y + v.x, diagonal + factor * w.z * w.z}};
}

/* The smallest turn that takes the direction of `from` to the unit vector b; of opposite ones any half turn that
 * does. */
static Matrix shortest(Vector from, Vector b)
{
    const Vector a = scale(1.0 / norm(from), from); /* else its rounding would double from step to step */
    const Vector still = {0.0, 0.0, 0.0}, v = cross(a, b);
    const double cosine = dot(a, b);
    if (cosine >= -1.0 + OPPOSITE) {
        return turn_of(cosine, 1.0 / (1.0 + cosine), v, v);
    }
    const bool x = fabs(a.x) <= fabs(a.y) && fabs(a.x) <= fabs(a.z), y = fabs(a.y) <= fabs(a.z);
    const Vector across = cross(a, (Vector){x ? 1.0 : 0.0, !x && y ? 1.0 : 0.0, !x && !y ? 1.0 : 0.0});
    return turn_of(-1.0, 2.0, scale(1.0 / norm(across), across), still);
}

Reference supervisor_free(Vector axis_B, Moving to, Matrix before)
{
    const Matrix R = multiply(shortest(apply(before, axis_B), to.p), before);
    return (Reference){R, apply_transposed(R, cross(to.p, to.dp)), apply_transposed(R, cross(to.p, to.ddp))};
}
