/* The date that a parameter `epoch` gives. */
#ifndef COMMON_EPOCH_H
#define COMMON_EPOCH_H

#include <stdint.h>

#include "fault.h"

#define EPOCH_SECOND INT64_C(1000000) /* microseconds */
#define EPOCH_DAY (86400 * EPOCH_SECOND)

/* A UTC date: microseconds from 2000-01-01T12:00, from the start of its year, and in its year. */
typedef struct {
    int year;
    int64_t since_j2000, in_year, year_length;
} Epoch;

/* Days of 86400 s from 2000-01-01T12:00. */
static inline double epoch_days_since_j2000(const Epoch *date)
{
    return (double)date->since_j2000 / (double)EPOCH_DAY;
}

/* Greenwich mean sidereal time, rad in [0, 2 pi): IAU 1982 (Aoki et al., A&A 105, 1982). UT1 is taken as UTC. */
static inline double epoch_sidereal_angle(const Epoch *date)
{
    const double T = epoch_days_since_j2000(date) / 36525.0, degree = 3.14159265358979323846 / 180.0;
    const double seconds = 67310.54841 + T * (876600.0 * 3600.0 + 8640184.812866 + T * (0.093104 - T * 6.2e-6));
    const double day = seconds / 86400.0;
    const double turns = (double)(int64_t)day - (day < 0.0 ? 1.0 : 0.0);
    return (seconds - turns * 86400.0) / 240.0 * degree; /* the product is exact */
}

/* Reads exactly n digits at *text and moves on. */
static inline bool epoch_digits(const char **text, int n, int *value)
{
    *value = 0;
    for (; n > 0; --n, ++*text) {
        if (**text < '0' || **text > '9') {
            return false;
        }
        *value = 10 * *value + (**text - '0');
    }
    return true;
}

static inline bool epoch_skip(const char **text, char expected)
{
    if (**text != expected) {
        return false;
    }
    ++*text;
    return true;
}

/* Days from 0001-01-01 to the start of a year, Gregorian. */
static inline int64_t epoch_days_before(int year)
{
    const int64_t y = year - 1;
    return 365 * y + y / 4 - y / 100 + y / 400;
}

/* hh:mm[:ss[.f]], as microseconds of the day. */
static inline bool epoch_time(const char **text, int64_t *time)
{
    int hour, minute, second = 0, digit;
    int64_t fraction = 0;
    if (!epoch_digits(text, 2, &hour) || !epoch_skip(text, ':') || !epoch_digits(text, 2, &minute)) {
        return false;
    }
    if (epoch_skip(text, ':')) {
        if (!epoch_digits(text, 2, &second)) {
            return false;
        }
        if (epoch_skip(text, '.') || epoch_skip(text, ',')) {
            if (**text < '0' || **text > '9') {
                return false;
            }
            for (int64_t unit = EPOCH_SECOND / 10; epoch_digits(text, 1, &digit); unit /= 10) {
                fraction += unit * digit; /* beyond microseconds unit is zero */
            }
        }
    }
    *time = ((int64_t)hour * 3600 + minute * 60 + second) * EPOCH_SECOND + fraction;
    return hour < 24 && minute < 60 && second < 60;
}

/* Nothing, Z, +00:00 or -00:00, and then the end of the text. */
static inline bool epoch_is_utc(const char *text)
{
    int zero;
    if (!epoch_skip(&text, 'Z') && (epoch_skip(&text, '+') || epoch_skip(&text, '-')) &&
        (!epoch_digits(&text, 2, &zero) || zero != 0 || !epoch_skip(&text, ':') || !epoch_digits(&text, 2, &zero) ||
         zero != 0)) {
        return false;
    }
    return *text == '\0';
}

/* UTC in the extended form of ISO 8601: 2009-08-10, or 2009-08-10T12:00[:00[.5]] and Z, +00:00, -00:00 or nothing. A
 * space may stand for the T and a comma for the point; digits beyond microseconds are dropped. Years 1 to 9999; no
 * leap second. */
/*@ requires \valid_read(text + (0 .. 127)) && text[127] == 0;
    assigns *epoch, \result \from text[0 .. 127];
    ensures \result == 0 || \result == 1;
    ensures \result == 1 ==> \initialized(&epoch->since_j2000) && \initialized(&epoch->in_year);
    ensures \result == 1 ==> 1 <= epoch->year <= 9999;
    ensures \result == 1 ==> -63200000000000000 <= epoch->since_j2000 <= 252500000000000000;
    ensures \result == 1 ==> 0 <= epoch->in_year <= 31622400000000;
    ensures \result == 1 ==> 31536000000000 <= epoch->year_length <= 31622400000000; */
#ifdef PROOF_APART
extern bool epoch_read(const char *text, Epoch *epoch);
#else
static inline bool epoch_read(const char *text, Epoch *epoch)
{
    static const int lengths[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    int year, month, day;
    int64_t time = 0;
    if (!epoch_digits(&text, 4, &year) || !epoch_skip(&text, '-') || !epoch_digits(&text, 2, &month) ||
        !epoch_skip(&text, '-') || !epoch_digits(&text, 2, &day) || year < 1 || month < 1 || month > 12) {
        return false;
    }
    const int64_t year_days = epoch_days_before(year + 1) - epoch_days_before(year);
    const bool leap = year_days == 366;
    if (day < 1 || day > lengths[month - 1] + (month == 2 && leap ? 1 : 0)) {
        return false;
    }
    if (*text != '\0' &&
        ((!epoch_skip(&text, 'T') && !epoch_skip(&text, ' ')) || !epoch_time(&text, &time) || !epoch_is_utc(text))) {
        return false;
    }
    int64_t days = day - 1;
    for (int m = 1; m < month; ++m) {
        days += lengths[m - 1] + (m == 2 && leap ? 1 : 0);
    }
    const int64_t in_year = days * EPOCH_DAY + time;
    const int64_t year_start = (epoch_days_before(year) - epoch_days_before(2000)) * EPOCH_DAY;
    *epoch = (Epoch){year, year_start + in_year - EPOCH_DAY / 2, in_year, year_days * EPOCH_DAY};
    return true;
}
#endif

/* Whether the parameter `epoch` is a date. */
static inline bool is_epoch(const char *text, Epoch *epoch, Fault *f)
{
    //@ slevel 10;
    if (epoch_read(text, epoch)) {
        return true;
    }
    fault(f, "epoch", 0.0, "UTC in ISO 8601, such as 2009-08-10T12:00:00Z");
    f->text = text;
    return false;
}

#endif
