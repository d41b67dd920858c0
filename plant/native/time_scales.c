#include "time_scales.h"

static const double PI = 3.14159265358979323846;

double plant_gmst(const Epoch *date)
{
    const double T = plant_days_since_j2000(date) / 36525.0;
    const double seconds = 67310.54841 + T * (876600.0 * 3600.0 + 8640184.812866 + T * (0.093104 - T * 6.2e-6));
    const double day = seconds / 86400.0;
    const double turns = (double)(int64_t)day - (day < 0.0 ? 1.0 : 0.0);
    return (seconds - turns * 86400.0) / 240.0 * (PI / 180.0); /* the product is exact */
}

double plant_days_since_j2000(const Epoch *date)
{
    return (double)date->since_j2000 / (double)EPOCH_DAY;
}

double plant_day_of_year(const Epoch *date)
{
    return 1.0 + (double)date->in_year / (double)EPOCH_DAY;
}

double plant_decimal_year(const Epoch *date)
{
    return date->year + (double)date->in_year / (double)date->year_length;
}
