/* Density of the upper atmosphere: NRLMSISE-00 above 150 km in closed form, from tabulated expansions.
 *
 * Above the turbopause each species is in diffusive equilibrium on a Bates profile of temperature (Walker, J. Atmos.
 * Sci. 22, 1965), so eleven quantities describe a place: three of its temperature profile and the logarithms of eight
 * densities at 120 km. Each is a sum over the table's terms of P_nm(sin latitude), a wave in local time, longitude and
 * universal time, a season and a power of solar or geomagnetic activity. Picone, Hedin, Drob and Aikin, J. Geophys.
 * Res. 107(A12), 2002. */
#ifndef PLANT_ATMOSPHERE_H
#define PLANT_ATMOSPHERE_H

#include <stdint.h>

#include "orbit.h"

#define AIR_LOWEST 150e3 /* m */
#define AIR_HIGHEST 2000e3

enum { QUANTITIES = 11, TEMPERATURES = 3, SPECIES = 8, ACTIVITIES = 7, WAVES = 13, SEASONS = 5 };

/* In `coefficients` T_inf, K; T at 120 km, K; its gradient there, K/km; ln of N2, O2, O, He, H, Ar, N, hot O, 1/m3. */
typedef struct {
    uint8_t n, m, wave, season, activity;
    double coefficients[QUANTITIES];
} DensityTerm;

/* Written by the build from plant/tables. */
extern const DensityTerm plant_density_terms[];
extern const int plant_density_term_count;
extern const double plant_density_ap_shape[2]
                                          [QUANTITIES]; /* a and b of d + (b - 1)(d + (exp(-a d) - 1)/a), d = Ap - 4 */

typedef struct {
    double factors[ACTIVITIES][QUANTITIES];
} Activity;

/* f107 of the day before, its mean over 81 days, both 1e-22 W/(m2 Hz), and the day's mean Ap. */
Activity plant_activity_of(double f107, double f107_average, double ap);

/* ln of the mass density, kg/m3, hot oxygen included; day of the year, UTC, 1.0 at the start of 1 January. */
double plant_log_density(const Activity *activity, Place place, double day);

#endif
