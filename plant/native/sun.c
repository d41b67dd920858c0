#include "sun.h"

#include "orbit.h"

static const double PI = 3.14159265358979323846;
static const double AU = 149597870700.0;   /* m */
static const double SUN_RADIUS = 695.7e6;  /* m */
static const double TT_UTC = 69.184;       /* s, from 2017 on */
static const double NODE_INTERVAL = 600.0; /* s */
static const double DISC_MAX = 0.005;      /* above the sine of the Sun's angular radius */

static double radians(double degrees)
{
    return degrees * (PI / 180.0);
}

/* Of the longitude: amplitude and phase, deg, rate, deg a century; Venus twice, Jupiter, the Moon and a long period. */
static double perturbations(double T)
{
    static const double terms[5][3] = {{0.00134, 351.984, 22518.7541},
                                       {0.00154, 254.078, 45037.5082},
                                       {0.00200, 157.048, 32964.3577},
                                       {0.00179, 207.854, 445267.1142},
                                       {0.00178, 161.390, 20.2}};
    double sum = 0.0;
    for (int i = 0; i < 5; ++i) {
        sum += terms[i][0] * cos(radians(terms[i][1] + terms[i][2] * T));
    }
    return sum;
}

/* Meeus, Astronomical Formulae for Calculators (1979), ch. 18, on the elements of Astronomical Algorithms (1998),
 * ch. 25; T: Julian centuries from J2000. */
static Vector position(double T)
{
    const double L = radians(280.46646 + T * (36000.76983 + 0.0003032 * T));
    const double M = radians(357.52911 + T * (35999.05029 - 0.0001537 * T));
    const double e = 0.016708634 - T * (0.000042037 + 0.0000001267 * T);
    const double center =
        radians((1.914602 - T * (0.004817 + 0.000014 * T)) * sin(M) + (0.019993 - 0.000101 * T) * sin(2.0 * M) +
                0.000289 * sin(3.0 * M) + perturbations(T));
    const double distance = 1.000001018 * (1.0 - e * e) / (1.0 + e * cos(M + center));
    const double aberration = radians(-20.4898 / 3600.0) / distance;
    const double node = radians(125.04452 - 1934.136261 * T); /* of the Moon's orbit */
    const double nutation = radians((-17.20 * sin(node) - 1.32 * sin(2.0 * L)) / 3600.0);
    const double tilt = radians(23.43929111 - 0.013004167 * T + (9.20 * cos(node) + 0.57 * cos(2.0 * L)) / 3600.0);
    const double longitude = L + center + aberration + nutation;
    const Vector apparent = {cos(longitude), sin(longitude) * cos(tilt), sin(longitude) * sin(tilt)};
    /* From the true equinox to the mean one, since GMST turns the Earth in N. */
    return scale(AU * distance, plant_turned(-nutation * cos(tilt), apparent));
}

static Vector node_at(const Sun *sun, int64_t number)
{
    return position((sun->days + ((double)number * NODE_INTERVAL + TT_UTC) / 86400.0) / 36525.0);
}

/* From the Earth's centre. */
static inline Vector sun_at(Sun *sun, double t)
{
    const double s = t / NODE_INTERVAL;
    int64_t k = (int64_t)s;
    k -= s < (double)k ? 1 : 0;
    if (!sun->known || sun->number != k) {
        sun->known = true;
        sun->number = k;
        sun->start = node_at(sun, k);
        sun->change = subtract(node_at(sun, k + 1), sun->start);
    }
    return add(sun->start, scale(s - (double)k, sun->change));
}

/* The part of a disc of radius a that one of radius b leaves visible, their centres c apart. */
static double disc_left(double a, double b, double c)
{
    if (c >= a + b) {
        return 1.0;
    }
    if (c <= fabs(b - a)) {
        return b >= a ? 0.0 : 1.0 - b * b / (a * a);
    }
    const double x = 0.5 * (c * c + a * a - b * b) / c;
    const double y = sqrt(larger(a * a - x * x, 0.0));
    const double overlap = a * a * atan2(y, x) + b * b * atan2(y, c - x) - c * y;
    return clip(1.0 - overlap / (PI * a * a), 0.0, 1.0);
}

/* A ray misses the ellipsoid where it misses, with Z stretched by 1/(1 - f), the sphere of its equator. Montenbruck and
 * Gill, Satellite Orbits, 3.4.2; the Earth has no air. */
static double visible(Vector r, Vector d)
{
    static const double stretch = 1.0 / (1.0 - WGS84_FLATTENING);
    r.z *= stretch;
    d.z *= stretch;
    const double along = dot(r, d);
    if (along >= 0.0) {
        return 1.0; /* the Earth is behind */
    }
    const double r2 = dot(r, r), d2 = dot(d, d), radius = sqrt(r2), margin = DISC_MAX * radius;
    const double across2 = r2 - along * along / d2;
    if (across2 >= (WGS84_RADIUS + margin) * (WGS84_RADIUS + margin)) {
        return 1.0;
    }
    if (margin < WGS84_RADIUS && across2 <= (WGS84_RADIUS - margin) * (WGS84_RADIUS - margin)) {
        return 0.0;
    }
    const double a = atan2(SUN_RADIUS, sqrt(larger(d2 - SUN_RADIUS * SUN_RADIUS, 0.0)));
    const double b = atan2(WGS84_RADIUS, sqrt(larger(r2 - WGS84_RADIUS * WGS84_RADIUS, 0.0)));
    return disc_left(a, b, atan2(sqrt(larger(across2, 0.0)), -along / sqrt(d2)));
}

double plant_see_sun(Sun *sun, double t, const Vector *r, double sun_N[3], double *sunlight)
{
    const Vector d = subtract(sun_at(sun, t), *r);
    const double distance = norm(d);
    store(scale(1.0 / distance, d), sun_N);
    *sunlight = visible(*r, d);
    return distance;
}
