/* Tests: tests/native/test_plant_imbalance.py. */
#include "imbalance.h"

#include <math.h>

static const double TURN = 6.28318530717958647693;
static const double SHIFT = 6755399441055744.0; /* 1.5 * 2^52: what is added to it is rounded to an integer */

Imbalance plant_imbalance(Vector axis, double inertia, double product, double moment, Vector position)
{
    const double x = fabs(axis.x), y = fabs(axis.y), z = fabs(axis.z);
    const Vector furthest = x <= y && x <= z ? (Vector){1.0, 0.0, 0.0}
                            : y <= z         ? (Vector){0.0, 1.0, 0.0}
                                             : (Vector){0.0, 0.0, 1.0};
    const Vector across = cross(axis, furthest), e = scale(1.0 / norm(across), across), other = cross(axis, e);
    return (Imbalance){add(scale(product, e), scale(moment, cross(position, e))),
                       add(scale(product, other), scale(moment, cross(position, other))), inertia};
}

Vector plant_imbalance_swing(const Imbalance each[PLANT_WHEELS], const double angle[PLANT_WHEELS])
{
    Vector sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        sum = add(sum, add(scale(cos(angle[i]), each[i].cosine), scale(sin(angle[i]), each[i].sine)));
    }
    return sum;
}

Vector plant_imbalance_momentum(const Imbalance each[PLANT_WHEELS], const double angle[PLANT_WHEELS],
                                const double l_w[PLANT_WHEELS])
{
    Vector sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        const double speed = l_w[i] / each[i].inertia;
        sum =
            add(sum, scale(speed, subtract(scale(cos(angle[i]), each[i].sine), scale(sin(angle[i]), each[i].cosine))));
    }
    return sum;
}

void plant_imbalance_turned(const Imbalance each[PLANT_WHEELS], const Segment wheels[PLANT_WHEELS],
                            const double angle[PLANT_WHEELS], double s, double turned[PLANT_WHEELS])
{
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        const double whole = angle[i] + s * plant_segment_mean(&wheels[i], 0.0, s) / each[i].inertia;
        turned[i] = whole - ((whole / TURN + SHIFT) - SHIFT) * TURN;
    }
}
