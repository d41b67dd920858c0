#include "actuators.h"

#include <string.h>

/* By how much the wheels' momentum h has to move along the null space of their axes until each is `away` from rest and
 * from its limit: the least such motion; where none suffices, the one that leaves the worst wheel least to wish. */
static double null_space_motion(const AllocatorBoundedLaw *law, const double h[ALLOCATOR_BOUNDED_WHEELS], double away)
{
    const double *n = law->null_space;
    double best = 0.0, least = INFINITY;
    for (int k = -1; k < 4 * ALLOCATOR_BOUNDED_WHEELS; ++k) { /* none, or until wheel k/4 is at one of its four ends */
        double motion = 0.0, wish = 0.0;
        if (k >= 0) {
            const int i = k / 4;
            const double end = k % 2 == 0 ? away : larger(law->p.wheel_momentum_max[i] - away, away);
            if (fabs(n[i]) < 1e-6) {
                continue;
            }
            motion = ((k % 4 < 2 ? end : -end) - h[i]) / n[i];
        }
        for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
            const double size = fabs(h[i] + motion * n[i]);
            if (fabs(n[i]) >= 1e-6) {
                wish = larger(wish, larger(away - size, size - law->p.wheel_momentum_max[i] + away));
            }
        }
        wish = wish < 1e-9 * away ? 0.0 : wish;
        if (wish < least || (wish <= least && fabs(motion) < fabs(best))) {
            least = wish;
            best = motion;
        }
    }
    return best;
}

/* The preferred wheel torques d, N m: the feed-forward, or those that bring the momentum to its target. Along the null
 * space, where they cancel on the body, those that keep the speeds away from zero and from their limits. */
static void preferred_torques(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                              const AllocatorBoundedInputs *u, double d[ALLOCATOR_BOUNDED_WHEELS])
{
    const AllocatorBoundedParameters *p = &law->p;
    const bool with_wheel_ff = allocator_bounded_has_wheel_torque_ff(u);
    bool all_act = law->has_null_space;
    double h_w[ALLOCATOR_BOUNDED_WHEELS] = {0.0};
    for (int i = 0; i < WHEELS(p); ++i) {
        h_w[i] = WHEEL_MOMENTUM(law, x, u, i);
        d[i] = with_wheel_ff ? u->wheel_torque_ff[i] : -(h_w[i] - WHEEL_TARGET(p, i)) / p->desaturation_time;
        all_act = all_act && WHEEL_GAIN(law, x, u, i) != 0.0;
    }
    if (all_act && NULL_SPACE_MOMENTUM(p) > 0.0) {
        double change = null_space_motion(law, h_w, NULL_SPACE_MOMENTUM(p)) / p->desaturation_time;
        for (int i = 0; i < WHEELS(p); ++i) {
            change -= law->null_space[i] * d[i];
        }
        for (int i = 0; i < WHEELS(p); ++i) {
            d[i] += change * law->null_space[i];
        }
    }
#if ALLOCATOR_BOUNDED_WHEELS > 1
    for (int i = 0; i < WHEELS(p); ++i) {
        d[i] = allocator_bounded_tried_torque(law, x, u, i, d[i]);
    }
#endif
}

void allocator_bounded_actuators(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                 const AllocatorBoundedInputs *u, const Vector rods[3], bool with_rods_ff, Actuators *a)
{
    const AllocatorBoundedParameters *p = &law->p;
    (void)memset(a, 0, sizeof *a);
    a->rods = RODS(p);
    a->wheels = WHEELS(p);
    a->n = a->rods + a->wheels;
    for (int i = 0; i < a->rods; ++i) {
        a->limit[i] = p->dipole_max * p->rod_limits[i];
        a->torque[i] = scale(a->limit[i], rods[i]);
        a->weight[i] = p->rod_weight * a->limit[i];
        a->preferred[i] = (with_rods_ff ? u->dipole_ff[i] : 0.0) / a->limit[i];
        a->low[i] = -1.0;
        a->high[i] = 1.0;
    }
    double d[ALLOCATOR_BOUNDED_WHEELS] = {0.0};
    preferred_torques(law, x, u, d);
    const double weight = allocator_bounded_has_wheel_torque_ff(u) ? p->wheel_weight_ff : p->wheel_weight;
    for (int k = 0; k < WHEELS(p); ++k) {
        const int i = a->rods + k;
        const double gain = WHEEL_GAIN(law, x, u, k), h_w = WHEEL_MOMENTUM(law, x, u, k);
        const double torque_max = p->wheel_torque_max[k];
        a->limit[i] = torque_max;
        a->torque[i] = scale(-torque_max * gain, vector(law->axis[k]));
        a->weight[i] = weight * torque_max;
        a->preferred[i] = d[k] / torque_max;
        /* The wheel stays within its momentum over a period. Zero is always allowed, so the box is never empty. */
        const double down = larger((p->wheel_momentum_max[k] + h_w) / p->command_period, 0.0);
        const double up = larger((p->wheel_momentum_max[k] - h_w) / p->command_period, 0.0);
        a->low[i] = -smaller((gain < 0.0 ? up : down) / torque_max, 1.0);
        a->high[i] = smaller((gain < 0.0 ? down : up) / torque_max, 1.0);
        if (WHEEL_TRIED(law, x, u, k)) { /* of one that is reversed the way back leads out of the limits */
            a->low[i] = -1.0;
            a->high[i] = 1.0;
        }
    }
}
