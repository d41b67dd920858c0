/* What each wheel gives: docs/how/planned-wheels.md, Commands. */
#include "sample.h"

static const double FULL = 0.9, EVENED_SAMPLES = 4.0; /* of a wheel's limit; time in which the wheels are evened out */
static const double NULL_MIN = 1e-6;                  /* of a wheel in the null space */

/* (11): how far the momenta `w` of four wheels move along `null`, along which they cancel, so that none is beyond FULL
 * of its limit: the least way; half-way between the two worst where no way suffices. */
static double evened(const double w[WHEELS_MAX], const double null[WHEELS_MAX], const double limits[WHEELS_MAX])
{
    double low = -INFINITY, high = INFINITY;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        if (fabs(null[i]) > NULL_MIN) {
            const double middle = -w[i] / null[i], reach = FULL * limits[i] / fabs(null[i]);
            low = larger(low, middle - reach);
            high = smaller(high, middle + reach);
        }
    }
    if (!(low < INFINITY && high > -INFINITY && low > -INFINITY)) {
        return 0.0;
    }
    return low > high ? 0.5 * (low + high) : clip(0.0, low, high);
}

/* (10), (11): the momentum that each wheel should have for what they have together, so that they are even in their
 * limits about their targets. */
static void even_momenta(const ControllerPlannedWheelsLaw *law, const Sample *s, const double h_w[WHEELS_MAX],
                         double momenta[WHEELS_MAX])
{
    const double *target = law->p.wheel_momentum_target;
    double limits[WHEELS_MAX], null[WHEELS_MAX], motion = 0.0;
    Vector of_set[WHEELS_MAX], h = {0.0, 0.0, 0.0};
    int first = 0, n = 0;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        limits[i] = s->works[i] ? law->p.wheel_momentum_max[i] : 0.0;
        h = s->works[i] ? add(h, scale(h_w[i] - target[i], law->axes[i])) : h;
        n += s->works[i] ? 1 : 0;
    }
    distribute(WHEELS_MAX, law->axes, limits, of_set);
    for (int i = 0; i < WHEELS_MAX; ++i) { /* the wheel that has the largest part in the null space */
        const double part = 1.0 + dot(of_set[i], law->axes[i]), best = 1.0 + dot(of_set[first], law->axes[first]);
        first = part > best ? i : first;
    }
    for (int i = 0; i < WHEELS_MAX; ++i) {
        null[i] = (i == first ? 1.0 : 0.0) + dot(of_set[i], law->axes[first]);
        momenta[i] = target[i] - dot(of_set[i], h);
    }
    if (n == WHEELS_MAX) {
        motion = evened(momenta, null, limits);
    }
    for (int i = 0; i < WHEELS_MAX; ++i) {
        momenta[i] += motion * null[i];
    }
}

void controller_planned_wheels_share(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                     const double h_w[WHEELS_MAX], Vector wanted, double of_wheels[WHEELS_MAX])
{
    double limits[WHEELS_MAX], then[WHEELS_MAX], even[WHEELS_MAX];
    Vector torque_of[WHEELS_MAX];
    for (int i = 0; i < WHEELS_MAX; ++i) {
        limits[i] = s->works[i] ? law->p.wheel_torque_max[i] : 0.0;
    }
    distribute(WHEELS_MAX, law->axes, limits, torque_of);
    const double time = EVENED_SAMPLES * law->p.command_period;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        then[i] = h_w[i] + time * dot(torque_of[i], wanted);
    }
    even_momenta(law, s, then, even);
    for (int i = 0; i < WHEELS_MAX; ++i) {
        const double more = (even[i] - then[i]) / time;
        of_wheels[i] = s->works[i] ? clip(dot(torque_of[i], wanted) + more, -limits[i], limits[i]) : 0.0;
    }
}
