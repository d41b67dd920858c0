#include "time_scales.h"

static const int64_t SECOND = 1000000, DAY = 86400000000;
static const double PI = 3.14159265358979323846;

/* Reads exactly n digits at *text and moves on. */
static bool digits(const char **text, int n, int *value)
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

static bool skip(const char **text, char expected)
{
    if (**text != expected) {
        return false;
    }
    ++*text;
    return true;
}

/* Days from 0001-01-01 to the start of a year, Gregorian. */
static int64_t days_before(int year)
{
    const int64_t y = year - 1;
    return 365 * y + y / 4 - y / 100 + y / 400;
}

static bool is_leap(int year)
{
    return days_before(year + 1) - days_before(year) == 366;
}

/* hh:mm[:ss[.f]], as microseconds of the day. */
static bool parse_time(const char **text, int64_t *time)
{
    int hour, minute, second = 0;
    int64_t fraction = 0;
    if (!digits(text, 2, &hour) || !skip(text, ':') || !digits(text, 2, &minute)) {
        return false;
    }
    if (skip(text, ':')) {
        if (!digits(text, 2, &second)) {
            return false;
        }
        if (skip(text, '.') || skip(text, ',')) {
            int one;
            if (**text < '0' || **text > '9') {
                return false;
            }
            for (int64_t unit = SECOND / 10; digits(text, 1, &one); unit /= 10) {
                fraction += unit * one; /* beyond microseconds unit is zero */
            }
        }
    }
    *time = ((int64_t)hour * 3600 + minute * 60 + second) * SECOND + fraction;
    return hour < 24 && minute < 60 && second < 60;
}

bool parse_date(const char *text, Date *date)
{
    static const int lengths[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    int year, month, day, zero;
    int64_t time = 0;
    if (!digits(&text, 4, &year) || !skip(&text, '-') || !digits(&text, 2, &month) || !skip(&text, '-') ||
        !digits(&text, 2, &day) || year < 1 || month < 1 || month > 12) {
        return false;
    }
    const bool leap = is_leap(year);
    if (day < 1 || day > lengths[month - 1] + (month == 2 && leap ? 1 : 0)) {
        return false;
    }
    if (*text != '\0') {
        if ((!skip(&text, 'T') && !skip(&text, ' ')) || !parse_time(&text, &time)) {
            return false;
        }
        if (!skip(&text, 'Z') && (skip(&text, '+') || skip(&text, '-')) &&
            (!digits(&text, 2, &zero) || zero != 0 || !skip(&text, ':') || !digits(&text, 2, &zero) || zero != 0)) {
            return false;
        }
        if (*text != '\0') {
            return false;
        }
    }
    int64_t days = day - 1;
    for (int m = 1; m < month; ++m) {
        days += lengths[m - 1] + (m == 2 && leap ? 1 : 0);
    }
    date->year = year;
    date->in_year = days * DAY + time;
    date->year_length = (leap ? 366 : 365) * DAY;
    date->since_j2000 = (days_before(year) - days_before(2000)) * DAY + date->in_year - DAY / 2;
    return true;
}

double gmst(const Date *date)
{
    const double T = (double)date->since_j2000 / (double)DAY / 36525.0;
    const double seconds = 67310.54841 + T * (876600.0 * 3600.0 + 8640184.812866 + T * (0.093104 - T * 6.2e-6));
    const double day = seconds / 86400.0;
    const double turns = (double)(int64_t)day - (day < 0.0 ? 1.0 : 0.0);
    return (seconds - turns * 86400.0) / 240.0 * (PI / 180.0); /* the product is exact */
}

double day_of_year(const Date *date)
{
    return 1.0 + (double)date->in_year / (double)DAY;
}

double decimal_year(const Date *date)
{
    return date->year + (double)date->in_year / (double)date->year_length;
}
