/* Tests: tests/native/test_plant.py. */
#include "atmosphere.h"

enum { DEGREE = 7, ORDER = 3 };

static const double PI = 3.14159265358979323846;
static const double MASSES[SPECIES] = {28.0, 32.0, 16.0, 4.0, 1.0, 40.0, 14.0, 16.0};
static const double THERMAL_DIFFUSION[SPECIES - 1] = {0.0, 0.0, 0.0, -0.38, -0.38, 0.17, 0.0};
static const double AMU = 1.66e-27;
static const double GAS_CONSTANT = 831.4; /* 1e-4 J/(mol K): NRLMSISE-00 counts in cm and g */
static const double BASE = 120.0;         /* km */
static const double HOT_TEMPERATURE = 4000.0, HOT_BASE = 550.0, HOT_SCALE = 76.0; /* K, km, km */

Activity plant_activity_of(double f107, double f107_average, double ap)
{
    const double x = (f107 - f107_average) / 100.0, y = (f107_average - 150.0) / 100.0, d = ap - 4.0;
    Activity activity;
    for (int q = 0; q < QUANTITIES; ++q) {
        const double a = plant_density_ap_shape[0][q], b = plant_density_ap_shape[1][q];
        const double factors[ACTIVITIES] = {1.0, x, x * x, y, y * y, x * y, d + (b - 1.0) * (d + expm1(-a * d) / a)};
        for (int k = 0; k < ACTIVITIES; ++k) {
            activity.factors[k][q] = factors[k];
        }
    }
    return activity;
}

/* P_nm(sin latitude), unnormalised, without Condon and Shortley's sign. */
static void legendre(double s, double c, double P[DEGREE + 1][ORDER + 1])
{
    for (int m = 0; m <= ORDER; ++m) {
        P[m][m] = m == 0 ? 1.0 : (2 * m - 1) * c * P[m - 1][m - 1];
        P[m + 1][m] = (2 * m + 1) * s * P[m][m];
        for (int n = m + 2; n <= DEGREE; ++n) {
            P[n][m] = ((2 * n - 1) * s * P[n - 1][m] - (n + m - 1) * P[n - 2][m]) / (n - m);
        }
    }
}

static void pair(double angle, double out[2])
{
    out[0] = cos(angle);
    out[1] = sin(angle);
}

static void quantities(const Activity *activity, Place place, double day, double values[QUANTITIES])
{
    double P[DEGREE + 1][ORDER + 1], waves[WAVES], seasons[SEASONS];
    const double universal = 2.0 * PI * (day - (double)(int64_t)day);
    const double local = universal + place.longitude;
    const double angles[] = {local,           2.0 * local, 3.0 * local,
                             place.longitude, universal,   universal + 2.0 * place.longitude};
    /* NRLMSISE-00 takes the date's whole number; noon's value is kept and the rest is made continuous. */
    const double year = 2.0 * PI / 365.0 * (day - 0.5);
    waves[0] = seasons[0] = 1.0;
    for (int i = 0; i < 6; ++i) {
        pair(angles[i], &waves[1 + 2 * i]);
    }
    pair(year, &seasons[1]);
    pair(2.0 * year, &seasons[3]);
    legendre(sin(place.latitude), cos(place.latitude), P);
    for (int q = 0; q < QUANTITIES; ++q) {
        values[q] = 0.0;
    }
    for (int k = 0; k < plant_density_term_count; ++k) {
        const DensityTerm *term = &plant_density_terms[k];
        const double weight = P[term->n][term->m] * waves[term->wave] * seasons[term->season];
        const double *factors = activity->factors[term->activity];
        for (int q = 0; q < QUANTITIES; ++q) {
            values[q] += weight * factors[q] * term->coefficients[q];
        }
    }
}

double plant_log_density(const Activity *activity, Place place, double day)
{
    double values[QUANTITIES];
    quantities(activity, place, day, values);
    const double T_inf = values[0], T_base = values[1], gradient = values[2];
    const double z = 1e-3 * place.height, cos_2 = cos(2.0 * place.latitude);
    const double surface_gravity = 980.616 * (1.0 - 0.0026373 * cos_2);             /* cm/s2 */
    const double radius = 2e-5 * surface_gravity / (3.085462e-6 + 2.27e-9 * cos_2); /* km */
    const double relative = 1.0 + BASE / radius, relative_hot = 1.0 + HOT_BASE / radius;
    const double gravity = surface_gravity / (relative * relative);
    const double zeta = (z - BASE) * (radius + BASE) / (radius + z); /* geopotential height above 120 km */
    const double s = gradient / (T_inf - T_base);
    const double cooling = log(T_base / (T_inf - (T_inf - T_base) * exp(-s * zeta)));
    double sum = 0.0;
    for (int i = 0; i < SPECIES - 1; ++i) {
        const double gamma = MASSES[i] * gravity / (s * GAS_CONSTANT * T_inf);
        const double ratio = (1.0 + gamma) * cooling + THERMAL_DIFFUSION[i] * cooling - gamma * s * zeta;
        sum += MASSES[i] * exp(values[TEMPERATURES + i] + ratio);
    }
    const double weight = 16.0 / (GAS_CONSTANT * HOT_TEMPERATURE);
    const double gravity_hot = surface_gravity / (relative_hot * relative_hot);
    const double decay = HOT_SCALE * gravity_hot * expm1(-(z - HOT_BASE) / HOT_SCALE);
    const double hot = -weight * (gravity * zeta + decay);
    sum += MASSES[SPECIES - 1] * exp(values[QUANTITIES - 1] + hot);
    return log(AMU * sum);
}
