/* What the controller knows of orbit, target and field ahead of it: models of its own, so that they may be wrong. */
#ifndef CONTROLLER_PLANNED_ONBOARD_H
#define CONTROLLER_PLANNED_ONBOARD_H

#include <stdint.h>

#include "epoch.h"
#include "rotation.h"
#include "vector.h"

enum { ONBOARD_DEGREE_MAX = 13, ONBOARD_TERMS = 104 };

/* The target: none, one that the parameter `reference` names (1 and 2 are its values), or a given one, which keeps its
 * attitude to LVLH or its body rate. */
enum {
    ONBOARD_TARGET_NONE = 0,
    ONBOARD_TARGET_LVLH = 1,
    ONBOARD_TARGET_INERTIAL = 2,
    ONBOARD_TARGET_WITH_LVLH = 3,
    ONBOARD_TARGET_TURNING = 4
};

/* Gauss coefficients, nT, Schmidt semi-normalised, n = 1 to 13, m = 0 to n in this order; linear in time between the
 * epochs, with `g_rate`, `h_rate`, nT/year, after the last. The build writes the table. */
typedef struct {
    int epochs;
    const double *years;
    const char *covered; /* in words, for a refusal */
    double valid_until;
    const double (*g)[ONBOARD_TERMS], (*h)[ONBOARD_TERMS];
    const double *g_rate, *h_rate;
} GaussModel;

/* In the order of the parameter field_model. */
extern const GaussModel controller_planned_gauss_models[];

/* At one date, T, and the factors of the Legendre functions' recursion. */
typedef struct {
    int degree;
    double g[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1], h[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1];
    double up[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1], down[ONBOARD_DEGREE_MAX + 1][ONBOARD_DEGREE_MAX + 1];
    double diagonal[ONBOARD_DEGREE_MAX + 1];
    double sidereal_angle; /* of Greenwich at t = 0, rad */
} OnboardField;

/* A two-body orbit through a position and a velocity at a time. */
typedef struct {
    double t, mu;
    Vector r, v;
} OnboardOrbit;

/* The desired motion: attitude (N from desired body), rate in desired body axes. */
typedef struct {
    Matrix R;
    Vector Omega;
} Target;

/* Days of 86400 s from 2000-01-01T12:00. */
static inline double days_of_epoch(const Epoch *epoch)
{
    const int64_t time = epoch->in_year % EPOCH_DAY;
    const int64_t days = (epoch->since_j2000 + EPOCH_DAY / 2 - time) / EPOCH_DAY;
    return (double)days - 0.5 + (double)time / (double)EPOCH_SECOND / 86400.0;
}

/* The decimal year of days from 2000-01-01T12:00. */
static inline double year_of_days(double days)
{
    return 2000.0 + (days + 0.5) / 365.25;
}

/* `error` (T) is added to g10, g11, h11. */
void controller_planned_onboard_field(const GaussModel *model, double days, int degree, const double error[3],
                                      OnboardField *field);

/* B_N, T, at a time after the epoch, s, and a position in N, m. */
Vector controller_planned_onboard_field_at(const OnboardField *field, double t, Vector r_N);

/* Position and velocity at t. */
void controller_planned_onboard_orbit_at(const OnboardOrbit *orbit, double t, Vector *r_N, Vector *v_N);

/* LVLH of a position and a velocity: Z to nadir, Y against the orbit's normal. */
Target controller_planned_lvlh(Vector r_N, Vector v_N);

#endif
