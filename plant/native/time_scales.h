/* Years of a date, and the Earth's turn. */
#ifndef PLANT_TIME_SCALES_H
#define PLANT_TIME_SCALES_H

#include "epoch.h"

/* Rate of GMST, rad/s. */
#define EARTH_RATE 7.2921158553e-5

/* Day of the year, 1.0 at the start of 1 January. */
double plant_day_of_year(const Epoch *date);

double plant_decimal_year(const Epoch *date);

#endif
