#include "environment.h"

#include "time_scales.h"

static const double INTERVAL = 10.0; /* s */

static Node evaluate(const Environment *environment, int64_t number)
{
    const double t = (double)number * INTERVAL;
    const double sidereal = environment->gmst0 + EARTH_RATE * t;
    const Motion motion = motion_at(&environment->orbit, t);
    const Vector r_earth = turned(-sidereal, motion.r);
    Node node = {number, true, turned(sidereal, field_at(&environment->field, r_earth)), {0.0, 0.0, 0.0}, 0.0};
    if (environment->has_air) {
        /* The air turns with the Earth. */
        const Vector r = motion.r, v = motion.v;
        node.flow_N = (Vector){v.x + EARTH_RATE * r.y, v.y - EARTH_RATE * r.x, v.z};
        node.log_density = log_density(&environment->activity, geodetic(r_earth), environment->day0 + t / 86400.0);
    }
    return node;
}

static const Node *node_of(Environment *environment, int64_t number)
{
    Node *node = &environment->nodes[(uint64_t)number % NODES];
    if (!node->known || node->number != number) {
        *node = evaluate(environment, number);
    }
    return node;
}

void forget_surroundings(Environment *environment)
{
    for (int i = 0; i < NODES; ++i) {
        environment->nodes[i].known = false;
    }
    environment->last.known = false;
}

const Surroundings *surroundings_at(Environment *environment, double t)
{
    Surroundings *around = &environment->last;
    if (around->known && around->t == t) {
        return around;
    }
    const double s = t / INTERVAL;
    int64_t k = (int64_t)s;
    k -= s < (double)k ? 1 : 0;
    const double c = s - (double)k, a = c + 2.0, b = c + 1.0, d = c - 1.0, e = c - 2.0, f = c - 3.0;
    const double ab = a * b, cd = c * d, ef = e * f;
    const double weights[6] = {b * cd * ef / -120.0, a * cd * ef / 24.0,  ab * d * ef / -12.0,
                               ab * c * ef / 12.0,   ab * cd * f / -24.0, ab * cd * e / 120.0};
    Vector field = {0.0, 0.0, 0.0}, flow = field;
    double logarithm = 0.0;
    for (int i = 0; i < 6; ++i) {
        const Node *node = node_of(environment, k - 2 + i);
        field = add(field, scale(weights[i], node->b_N));
        flow = add(flow, scale(weights[i], node->flow_N));
        logarithm += weights[i] * node->log_density;
    }
    const double density = environment->has_air ? exp(logarithm) : 0.0;
    *around = (Surroundings){t, true, motion_at(&environment->orbit, t), field, flow, density};
    return around;
}
