/* Sidereal time and years of a date. UT1 is taken as UTC. */
#ifndef PLANT_TIME_SCALES_H
#define PLANT_TIME_SCALES_H

#include "epoch.h"

/* Rate of GMST, rad/s. */
#define EARTH_RATE 7.2921158553e-5

/* Greenwich mean sidereal time, rad in [0, 2 pi): IAU 1982. */
double plant_gmst(const Epoch *date);

/* Day of the year, 1.0 at the start of 1 January. */
double plant_day_of_year(const Epoch *date);

double plant_decimal_year(const Epoch *date);

/* Days of 86400 s from 2000-01-01 12:00. */
double plant_days_since_j2000(const Epoch *date);

#endif
