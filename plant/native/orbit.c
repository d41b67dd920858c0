#include "orbit.h"

static const double J2 = 1.082629821313e-3; /* of the WGS 84 ellipsoid */

Orbit plant_circular_orbit(double radius, double inclination, double raan, double argument_of_latitude, double mu)
{
    const double ci = cos(inclination), si = sin(inclination), cn = cos(raan), sn = sin(raan);
    return (Orbit){radius,
                   0.0,
                   sqrt(mu / (radius * radius * radius)),
                   argument_of_latitude,
                   {cn, sn, 0.0},
                   {-sn * ci, cn * ci, si},
                   0.0};
}

bool plant_orbit_through(Vector r, Vector v, double mu, Orbit *orbit)
{
    const double radius = norm(r);
    const Vector h = cross(r, v);
    const double momentum = norm(h);
    if (momentum <= 1e-6 * radius * norm(v)) { /* also where either is zero */
        return false;
    }
    const double energy = 0.5 * dot(v, v) - mu / radius;
    const double a = -mu / (2.0 * energy);
    const Vector perigee = subtract(scale(1.0 / mu, cross(v, h)), scale(1.0 / radius, r));
    const double length = norm(perigee);
    const double e = length > 1e-12 ? length : 0.0;
    const Vector p_hat = e > 0.0 ? scale(1.0 / e, perigee) : scale(1.0 / radius, r);
    const Vector q_hat = cross(scale(1.0 / momentum, h), p_hat);
    const double E = atan2(dot(r, q_hat) / sqrt(1.0 - e * e), dot(r, p_hat) + a * e);
    *orbit = (Orbit){a, e, sqrt(mu / (a * a * a)), E - e * sin(E), p_hat, q_hat, 0.0};
    return energy < 0.0;
}

double plant_j2_node_rate(const Orbit *orbit, double mu)
{
    const double a = orbit->semi_major_axis, e = orbit->eccentricity;
    const double share = WGS84_RADIUS / (a * (1.0 - e * e));
    const double cos_inclination = cross(orbit->towards_perigee, orbit->along_perigee).z;
    return -1.5 * sqrt(mu / (a * a * a)) * J2 * share * share * cos_inclination;
}

/* E of M = E - e sin E, by Newton's method; without a limit to its change it diverges before the perigee where e is
 * above 0.99. It ends by the break: after 15 passes at the latest, up to e = 0.999999. */
static double eccentric_anomaly(double M, double e)
{
    double E = M + e * sin(M);
    for (int i = 0; i < 50; ++i) { /* GCOVR_EXCL_BR_LINE: see above */
        const double change = clip((E - e * sin(E) - M) / (1.0 - e * cos(E)), -1.0, 1.0);
        E -= change;
        if (fabs(change) < 1e-9 * larger(1.0, fabs(M))) {
            break;
        }
    }
    return E;
}

OrbitState plant_motion_at(const Orbit *orbit, double t)
{
    const double a = orbit->semi_major_axis, e = orbit->eccentricity;
    const double M = orbit->mean_anomaly + orbit->mean_motion * t;
    const double E = e > 0.0 ? eccentric_anomaly(M, e) : M;
    const double c = cos(E), s = sin(E);
    const double minor = sqrt(1.0 - e * e);
    const double E_rate = orbit->mean_motion / (1.0 - e * c);
    const Vector p = orbit->towards_perigee, q = orbit->along_perigee;
    OrbitState motion = {add(scale(a * (c - e), p), scale(a * minor * s, q)),
                         add(scale(-a * E_rate * s, p), scale(a * minor * E_rate * c, q))};
    if (orbit->node_rate != 0.0) {
        const double angle = orbit->node_rate * t;
        motion.r = plant_turned(angle, motion.r);
        motion.v = add(plant_turned(angle, motion.v), scale(orbit->node_rate, (Vector){-motion.r.y, motion.r.x, 0.0}));
    }
    return motion;
}

Vector plant_turned(double angle, Vector x)
{
    const double c = cos(angle), s = sin(angle);
    return (Vector){c * x.x - s * x.y, s * x.x + c * x.y, x.z};
}

/* Bowring's formula, iterated. */
Place plant_geodetic(Vector r)
{
    const double e2 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);
    const double b = WGS84_RADIUS * (1.0 - WGS84_FLATTENING);
    const double p = sqrt(r.x * r.x + r.y * r.y);
    double beta = atan2(r.z * WGS84_RADIUS, p * b);
    double latitude = 0.0;
    for (int i = 0; i < 3; ++i) {
        const double sb = sin(beta), cb = cos(beta);
        latitude = atan2(r.z + e2 / (1.0 - e2) * b * sb * sb * sb, p - e2 * WGS84_RADIUS * cb * cb * cb);
        beta = atan2((1.0 - WGS84_FLATTENING) * sin(latitude), cos(latitude));
    }
    const double s = sin(latitude), c = cos(latitude);
    return (Place){latitude, atan2(r.y, r.x), p * c + r.z * s - WGS84_RADIUS * sqrt(1.0 - e2 * s * s)};
}
