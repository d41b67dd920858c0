/* Dates and sidereal time. UT1 is taken as UTC. */
#ifndef TIME_SCALES_H
#define TIME_SCALES_H

#include <stdbool.h>
#include <stdint.h>

/* Rate of GMST, rad/s. */
#define EARTH_RATE 7.2921158553e-5

/* A UTC date: microseconds from 2000-01-01T12:00, from the start of its year, and in its year. */
typedef struct {
    int year;
    int64_t since_j2000, in_year, year_length;
} Date;

/* ISO 8601 in its extended form, UTC: 2009-08-10, 2009-08-10T12:00[:00[.5]], with Z, +00:00 or nothing at the end. */
bool parse_date(const char *text, Date *date);

/* Greenwich mean sidereal time, rad in [0, 2 pi): IAU 1982. */
double gmst(const Date *date);

/* Day of the year, 1.0 at the start of 1 January. */
double day_of_year(const Date *date);

double decimal_year(const Date *date);

#endif
