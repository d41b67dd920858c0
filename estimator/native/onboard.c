/* Tests: tests/native/test_flavours.py. */
#include "onboard.h"

static const double DEGREE = 3.14159265358979323846 / 180.0;
static const double EARTH_RADIUS = 6378137.0; /* equatorial, m */
static const double J2 = 1.082629821313e-3;
static const double SUN_RADIUS = 4.65e-3; /* half the angle that the Sun takes up, rad */
static const double ORBIT_STEP = 10.0;    /* s, longest step of the integration */

Vector estimator_sun_direction(double days)
{
    const double mean_longitude = (280.460 + 0.9856474 * days) * DEGREE;
    const double anomaly = (357.528 + 0.9856003 * days) * DEGREE;
    const double longitude = mean_longitude + (1.915 * sin(anomaly) + 0.020 * sin(2.0 * anomaly)) * DEGREE;
    const double obliquity = (23.439 - 4e-7 * days) * DEGREE, s = sin(longitude);
    return (Vector){cos(longitude), cos(obliquity) * s, sin(obliquity) * s};
}

double estimator_sunlight(Vector r_N, Vector sun_N)
{
    const double r = norm(r_N);
    if (r <= EARTH_RADIUS) {
        return 0.0;
    }
    const double from_nadir = atan2(norm(cross(r_N, sun_N)), -dot(r_N, sun_N));
    const double earth = atan2(EARTH_RADIUS, sqrt((r - EARTH_RADIUS) * (r + EARTH_RADIUS)));
    return clip(0.5 + (from_nadir - earth) / (2.0 * SUN_RADIUS), 0.0, 1.0);
}

/* Montenbruck and Gill, Satellite Orbits, 3.2, with the Earth's axis along Z. */
static Vector gravity(Vector r_N, double mu, bool oblate)
{
    const double r2 = dot(r_N, r_N), factor = -mu / (r2 * sqrt(r2));
    if (!oblate) {
        return scale(factor, r_N);
    }
    const double z2 = 5.0 * r_N.z * r_N.z / r2, c = 1.5 * J2 * (EARTH_RADIUS * EARTH_RADIUS / r2);
    const double across = factor * (1.0 + c * (1.0 - z2));
    return (Vector){across * r_N.x, across * r_N.y, factor * (1.0 + c * (3.0 - z2)) * r_N.z};
}

static Vector mean_of(Vector k1, Vector k2, Vector k3, Vector k4)
{
    return scale(1.0 / 6.0, add(add(k1, k4), scale(2.0, add(k2, k3))));
}

void estimator_orbit_after(double h, double mu, bool oblate, Vector *r_N, Vector *v_N)
{
    const int steps = steps_of(h, ORBIT_STEP);
    const double dt = h / steps;
    for (int i = 0; i < steps; ++i) {
        const Vector v1 = *v_N, a1 = gravity(*r_N, mu, oblate);
        const Vector v2 = add(v1, scale(0.5 * dt, a1)), a2 = gravity(add(*r_N, scale(0.5 * dt, v1)), mu, oblate);
        const Vector v3 = add(v1, scale(0.5 * dt, a2)), a3 = gravity(add(*r_N, scale(0.5 * dt, v2)), mu, oblate);
        const Vector v4 = add(v1, scale(dt, a3)), a4 = gravity(add(*r_N, scale(dt, v3)), mu, oblate);
        *r_N = add(*r_N, scale(dt, mean_of(v1, v2, v3, v4)));
        *v_N = add(*v_N, scale(dt, mean_of(a1, a2, a3, a4)));
    }
}
