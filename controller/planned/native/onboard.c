#include "onboard.h"

#include <string.h>

static const double PI = 3.14159265358979323846;
static const double EARTH_RADIUS = 6371200.0;    /* m, of the field models */
static const double EARTH_RATE = 7.292115855e-5; /* rad/s, of Greenwich relative to N */

void controller_planned_onboard_field(const GaussModel *model, double days, int degree, const double error[3],
                                      OnboardField *field)
{
    const double year = year_of_days(days);
    const int last = model->epochs - 1;
    int i = 0;
    while (i < last && model->years[i + 1] <= year) {
        ++i;
    }
    const double elapsed = year - model->years[i];
    const double share = i < last ? elapsed / (model->years[i + 1] - model->years[i]) : 0.0;
    memset(field, 0, sizeof *field);
    field->degree = degree;
    int k = 0;
    for (int n = 1; n <= degree; ++n) {
        field->diagonal[n] = n == 1 ? 1.0 : sqrt((2.0 * n - 1.0) / (2.0 * n));
        for (int m = 0; m <= n; ++m, ++k) {
            double g = model->g[i][k], h = model->h[i][k];
            if (i < last) {
                g += share * (model->g[i + 1][k] - g);
                h += share * (model->h[i + 1][k] - h);
            } else {
                g += elapsed * model->g_rate[k];
                h += elapsed * model->h_rate[k];
            }
            field->g[n][m] = 1e-9 * g;
            field->h[n][m] = 1e-9 * h;
            if (m < n) {
                const double root = sqrt((double)(n * n - m * m));
                field->up[n][m] = (2.0 * n - 1.0) / root;
                field->down[n][m] = sqrt((double)((n - 1) * (n - 1) - m * m)) / root;
            }
        }
    }
    field->g[1][0] += error[0];
    field->g[1][1] += error[1];
    field->h[1][1] += error[2];
    /* Greenwich mean sidereal time, IAU 1982. */
    const double T = days / 36525.0;
    const double seconds = 67310.54841 + (876600.0 * 3600.0 + 8640184.812866) * T + (0.093104 - 6.2e-6 * T) * T * T;
    field->sidereal_angle = (seconds / 86400.0 - (double)(int64_t)(seconds / 86400.0)) * 2.0 * PI;
}

/* The gradient of the potential in spherical components, by recursion of the Schmidt functions and their derivatives. */
Vector controller_planned_onboard_field_at(const OnboardField *field, double t, Vector r_N)
{
    const double angle = field->sidereal_angle + EARTH_RATE * t;
    const double ca = cos(angle), sa = sin(angle);
    const Vector r = {ca * r_N.x + sa * r_N.y, ca * r_N.y - sa * r_N.x, r_N.z};
    const double size = norm(r), from_axis = sqrt(r.x * r.x + r.y * r.y), rho = larger(from_axis, 1e-7 * size);
    const double c = r.z / size, s = rho / size; /* of the colatitude */
    const bool polar = from_axis < rho;
    const double cl = polar ? 1.0 : r.x / rho, sl = polar ? 0.0 : r.y / rho; /* of the longitude, any at the poles */
    double P[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1], dP[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1];
    double cm[ONBOARD_DEGREE_MAX + 1], sm[ONBOARD_DEGREE_MAX + 1];
    P[0][0] = cm[0] = 1.0;
    dP[0][0] = sm[0] = 0.0;
    const double ratio = EARTH_RADIUS / size;
    double power = ratio * ratio;
    Vector B = {0.0, 0.0, 0.0}; /* up, south, east */
    for (int n = 1; n <= field->degree; ++n) {
        cm[n] = cl * cm[n - 1] - sl * sm[n - 1];
        sm[n] = sl * cm[n - 1] + cl * sm[n - 1];
        const double d = field->diagonal[n];
        P[n][n] = d * s * P[n - 1][n - 1];
        dP[n][n] = d * (s * dP[n - 1][n - 1] + c * P[n - 1][n - 1]);
        power *= ratio;
        double up = 0.0, south = 0.0, east = 0.0;
        for (int m = 0; m <= n; ++m) {
            if (m < n) {
                const double a = field->up[n][m], b = field->down[n][m];
                const double P2 = m < n - 1 ? P[n - 2][m] : 0.0, dP2 = m < n - 1 ? dP[n - 2][m] : 0.0;
                P[n][m] = a * c * P[n - 1][m] - b * P2;
                dP[n][m] = a * (c * dP[n - 1][m] - s * P[n - 1][m]) - b * dP2;
            }
            const double along = field->g[n][m] * cm[m] + field->h[n][m] * sm[m];
            up += along * P[n][m];
            south -= along * dP[n][m];
            east += m * (field->g[n][m] * sm[m] - field->h[n][m] * cm[m]) * P[n][m];
        }
        B.x += power * (n + 1) * up;
        B.y += power * south;
        B.z += power * east;
    }
    B.z /= s;
    const double outward = B.x * s + B.y * c;
    const Vector fixed = {outward * cl - B.z * sl, outward * sl + B.z * cl, B.x * c - B.y * s};
    return (Vector){ca * fixed.x - sa * fixed.y, sa * fixed.x + ca * fixed.y, fixed.z};
}

/* Lagrange's coefficients of the change in eccentric anomaly. */
void controller_planned_onboard_orbit_at(const OnboardOrbit *orbit, double t, Vector *r_N, Vector *v_N)
{
    const double mu = orbit->mu, dt = t - orbit->t;
    const double r0 = norm(orbit->r);
    const double a = 1.0 / (2.0 / r0 - dot(orbit->v, orbit->v) / mu);
    const double n = sqrt(mu / (a * a * a));
    const double p = 1.0 - r0 / a, q = dot(orbit->r, orbit->v) / sqrt(mu * a); /* e cos E0, e sin E0 */
    double E = n * dt, c = 1.0, s = 0.0;
    for (int i = 0; i < 8; ++i) {
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

Target controller_planned_lvlh(Vector r_N, Vector v_N)
{
    const double r = norm(r_N);
    return (Target){lvlh_axes(r_N, v_N), {0.0, -norm(cross(r_N, v_N)) / (r * r), 0.0}};
}
