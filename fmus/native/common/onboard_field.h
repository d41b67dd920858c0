/* An onboard model of the geomagnetic field, which the blocks of the flight software share. The plant's field is its
 * own. */
#ifndef COMMON_ONBOARD_FIELD_H
#define COMMON_ONBOARD_FIELD_H

#include <string.h>

#include "epoch.h"
#include "vector.h"

enum { ONBOARD_DEGREE_MAX = 13, ONBOARD_TERMS = 104 };

static const double ONBOARD_RADIUS = 6371200.0;          /* m, of the field models */
static const double ONBOARD_EARTH_RATE = 7.292115855e-5; /* rad/s, of Greenwich relative to N */
static const double ONBOARD_R_MIN =
    1e6; /* m; no orbit is nearer to the centre, so a lesser distance is in another unit */
static const double ONBOARD_FIELD_MAX = 1e-3; /* T; no orbit has more, so a larger field is in another unit */
static const double ONBOARD_TURN = 2.0 * 3.14159265358979323846;

/* Gauss coefficients, nT, Schmidt semi-normalised, n = 1 to 13, m = 0 to n in this order; linear in time between the
 * epochs, with `g_rate`, `h_rate`, nT/year, after the last. The build writes the table gauss_models.h, in the order
 * of the parameter field_model. */
typedef struct {
    int epochs;
    const double *years;
    const char *covered; /* in words, for a refusal */
    double valid_until;
    const double (*g)[ONBOARD_TERMS], (*h)[ONBOARD_TERMS];
    const double *g_rate, *h_rate;
} GaussModel;

/* At one date, T, and the factors of the Legendre functions' recursion. */
typedef struct {
    int degree;
    double g[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1], h[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1];
    double up[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1], down[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1];
    double diagonal[ONBOARD_DEGREE_MAX + 1];
    double sidereal_angle; /* of Greenwich at t = 0, rad */
} OnboardField;

/* Days of 86400 s from 2000-01-01T12:00. */
static inline double days_of_epoch(const Epoch *epoch)
{
    const int64_t time = epoch->in_year % EPOCH_DAY;
    const int64_t days = (epoch->since_j2000 + EPOCH_DAY / 2 - time) / EPOCH_DAY;
    return (double)days - 0.5 + (double)time / (double)EPOCH_SECOND / 86400.0;
}

/* The same of a parameter `epoch` that is a date. */
static inline double days_of_text(const char *text)
{
    Epoch epoch;
    //@ slevel 10;
    return epoch_read(text, &epoch) ? days_of_epoch(&epoch) : 0.0;
}

/* The decimal year of days from 2000-01-01T12:00. */
static inline double year_of_days(double days)
{
    return 2000.0 + (days + 0.5) / 365.25;
}

/* Whether the parameter `epoch` is a date in the years of a field model. */
static inline bool is_covered_epoch(const char *text, const GaussModel *model, Fault *f)
{
    Epoch epoch;
    //@ slevel 10;
    if (!is_epoch(text, &epoch, f)) {
        return false;
    }
    const double year = year_of_days(days_of_epoch(&epoch));
    if (year < model->years[0] || year > model->valid_until) {
        return fault(f, "epoch", year, model->covered);
    }
    return true;
}

/* The field at a date, up to a degree; `error` (T) is added to g10, g11, h11. */
/*@ requires \valid_read(model) && \valid_read(error + (0 .. 2)) && \valid(field);
    requires \is_finite(days) && -1e7 <= days <= 1e7 && 1 <= degree <= 13;
    assigns *field \from indirect:*model, days, degree, error[0 .. 2];
    ensures 1 <= field->degree <= 13 && \initialized(field); */
#ifdef PROOF_APART
extern void onboard_field(const GaussModel *model, double days, int degree, const double error[3], OnboardField *field);
#else
static inline void onboard_field(const GaussModel *model, double days, int degree, const double error[3],
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
    field->sidereal_angle = (seconds / 86400.0 - (double)(int64_t)(seconds / 86400.0)) * ONBOARD_TURN;
}
#endif

/* B_N, T, at a time after the epoch, s, and a position in N, m: the gradient of the potential in spherical
 * components, by recursion of the Schmidt functions and their derivatives. */
/*@ requires \valid_read(field) && \initialized(field) && 1 <= field->degree <= 13;
    assigns \result \from *field, t, r_N; */
#ifdef PROOF_APART
extern Vector onboard_field_at(const OnboardField *field, double t, Vector r_N);
#else
static inline Vector onboard_field_at(const OnboardField *field, double t, Vector r_N)
{
    const double angle = field->sidereal_angle + ONBOARD_EARTH_RATE * t;
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
    const double ratio = ONBOARD_RADIUS / size;
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
#endif

#endif
