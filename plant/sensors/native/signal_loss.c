/* Drop-outs of the star tracker and of GNSS. Tests: tests/native/test_flavours.py. */
#include "models.h"

/* The exact probability for any span. */
bool plant_sensors_lost(bool was, double interval, double duration, double span, Draw draw)
{
    const double mean = duration / (interval + duration);
    const double left = exp(-span * (1.0 / interval + 1.0 / duration));
    return plant_sensors_uniform(draw) < mean + ((was ? 1.0 : 0.0) - mean) * left;
}
