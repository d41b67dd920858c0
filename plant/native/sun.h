/* The Sun: its apparent position, and how much of it the Earth leaves visible. */
#ifndef PLANT_SUN_H
#define PLANT_SUN_H

#include <stdbool.h>
#include <stdint.h>

#include "vector.h"

/* Straight lines between positions 600 s apart, on which the direction errs by less than 2e-9 rad; the last one is
 * kept. It follows from the epoch alone, so keeping it is no memory of the block. */
typedef struct {
    double days; /* after J2000, UTC, at t = 0 */
    bool known;
    int64_t number;
    Vector start, change;
} Sun;

/* At t s, from a satellite at r, m: the unit vector to the Sun in N and the part of its disc that the ellipsoid of
 * WGS 84 leaves visible. Apparent, with aberration; N has the true pole of date and the mean equinox.
 * Returns the distance to the Sun, m. */
double plant_see_sun(Sun *sun, double t, const Vector *r, double sun_N[3], double *sunlight);

#endif
