/* The geomagnetic field of a spherical-harmonic model at one date. */
#ifndef PLANT_GEOMAGNETIC_H
#define PLANT_GEOMAGNETIC_H

#include "vector.h"

enum { FIELD_DEGREE_MAX = 13, FIELD_TERMS = 104 };

/* Coefficients nT, Schmidt semi-normalised, n = 1 to 13 (WMM's are zero above 12), m = 0 to n in this order: in time
 * linear between the epochs, secular variation after the last. The build writes the table from the packages that
 * maintain the models. */
typedef struct {
    int epochs;
    const double *years;
    double valid_until;
    const char *covered;                               /* in words, for a refusal */
    const double (*g)[FIELD_TERMS], (*h)[FIELD_TERMS]; /* one row for each epoch */
    const double *g_rate, *h_rate;                     /* nT/year */
} FieldModel;

/* In the order of the parameter field_model. */
extern const FieldModel plant_field_models[];

/* [n][m], T, for the recursion's unnormalised harmonics. */
typedef struct {
    int degree;
    double g[FIELD_DEGREE_MAX + 1][FIELD_DEGREE_MAX + 1], h[FIELD_DEGREE_MAX + 1][FIELD_DEGREE_MAX + 1];
} Field;

Field plant_field_of(const FieldModel *model, double year, int degree);

/* B, T, at a position, m, not at the Earth's centre; both Earth-fixed, geocentric, Cartesian. */
Vector plant_field_at(const Field *field, Vector r);

#endif
