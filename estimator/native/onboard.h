/* The estimator's own models of Sun, Earth's shadow and orbit; they may differ from the plant's. */
#ifndef ESTIMATOR_ONBOARD_H
#define ESTIMATOR_ONBOARD_H

#include "vector.h"

/* Unit vector from the Earth to the Sun in N at days from 2000-01-01T12:00: the low-precision formula of the
 * Astronomical Almanac, 0.01 deg from 1950 to 2050. */
Vector estimator_sun_direction(double days);

/* Part of the Sun that a spherical Earth leaves uncovered at r_N, m: 0 to 1, linear over the penumbra. */
double estimator_sunlight(Vector r_N, Vector sun_N);

/* Position and velocity after h s: two bodies, with J2 where the Earth is oblate; Runge and Kutta, order 4. */
void estimator_orbit_after(double h, double mu, bool oblate, Vector *r_N, Vector *v_N);

#endif
