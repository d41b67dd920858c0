#include "time_scales.h"

double plant_day_of_year(const Epoch *date)
{
    return 1.0 + (double)date->in_year / (double)EPOCH_DAY;
}

double plant_decimal_year(const Epoch *date)
{
    return date->year + (double)date->in_year / (double)date->year_length;
}
