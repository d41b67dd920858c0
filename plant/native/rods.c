#include "rods.h"

#include <stdint.h>

static const double SNAP = 1e-6; /* of a period, so that the rounding of a long sum of steps cuts no slivers */

static bool take_turns(const PlantParameters *p)
{
    return p->rod_period > 0.0 && p->rod_duty > 0.0 && p->rod_duty < 1.0;
}

Turn plant_turn_at(const PlantParameters *p, double t)
{
    if (!take_turns(p)) {
        return (Turn){0.0, !(p->rod_period > 0.0) || p->rod_duty > 0.0};
    }
    const double periods = t / p->rod_period;
    const double ahead = periods + SNAP;
    const double k = (double)(int64_t)ahead; /* t is not negative, and a step is of a million periods at most */
    return (Turn){k, periods - k < p->rod_duty - SNAP};
}

double plant_turn_part(const PlantParameters *p, Turn turn, double t, double left)
{
    if (!take_turns(p)) {
        return left;
    }
    const double duration = (turn.period + (turn.on ? p->rod_duty : 1.0)) * p->rod_period - t;
    return duration < left - SNAP * p->rod_period ? larger(duration, 0.0) : left;
}

Turn plant_next_turn(Turn turn)
{
    return (Turn){turn.on ? turn.period : turn.period + 1.0, !turn.on};
}

Vector plant_rod_dipoles(const PlantParameters *p, const PlantInputs *u, bool on)
{
    double dipole[3] = {0.0, 0.0, 0.0};
    for (int i = 0; on && i < 3; ++i) {
        const double limit = p->dipole_max * p->rod_limits[i];
        dipole[i] = p->rod_gain[i] * clip(u->dipole_cmd[i], -limit, limit);
    }
    return vector(dipole);
}
