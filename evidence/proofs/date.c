/* The epoch of any text, and what follows from it. */
#include "epoch.h"

#include "__fc_builtin.h"

volatile double seen_real;
volatile int64_t seen_whole;

int main(void)
{
    char text[128];
    Epoch epoch;
    Fault f;
    Frama_C_make_unknown(text, 127);
    text[127] = 0;
    if (is_epoch(text, &epoch, &f)) {
        seen_real = epoch_sidereal_angle(&epoch);
        seen_real = epoch_days_since_j2000(&epoch);
        seen_whole = epoch.in_year + epoch.year_length;
    }
    return 0;
}
