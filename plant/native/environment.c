/* Tests: tests/native/test_plant.py. */
#include "environment.h"

#include <string.h>

#include "time_scales.h"

static const double INTERVAL = 10.0; /* s */

static Along evaluate(const Environment *environment, double t)
{
    const double sidereal = environment->gmst0 + EARTH_RATE * t;
    const OrbitState motion = plant_motion_at(&environment->orbit, t);
    const Vector r_earth = plant_turned(-sidereal, motion.r);
    const double r = norm(motion.r);
    Along along = {plant_turned(sidereal, plant_field_at(&environment->field, r_earth)),
                   scale(sqrt(3.0 * environment->mu / r) / (r * r), motion.r),
                   {0.0, 0.0, 0.0},
                   0.0};
    if (environment->has_air) {
        /* The air turns with the Earth. */
        const Vector v = motion.v;
        along.flow_N = (Vector){v.x + EARTH_RATE * motion.r.y, v.y - EARTH_RATE * motion.r.x, v.z};
        along.log_density =
            plant_log_density(&environment->activity, plant_geodetic(r_earth), environment->day0 + t / 86400.0);
    }
    return along;
}

static const Along *node_of(Environment *environment, int64_t number)
{
    Node *node = &environment->nodes[(uint64_t)number % NODES];
    if (!node->known || node->number != number) {
        *node = (Node){number, true, evaluate(environment, (double)number * INTERVAL)};
    }
    return &node->along;
}

/* Lagrange's polynomials of the nodes -2 to 3, multiplied out. */
static const Stretch *stretch_of(Environment *environment, int64_t number)
{
    static const double weights[POWERS][6] = {
        {0.0, 0.0, 120.0, 0.0, 0.0, 0.0},      {6.0, -60.0, -40.0, 120.0, -30.0, 4.0},
        {-5.0, 80.0, -150.0, 80.0, -5.0, 0.0}, {-5.0, -5.0, 50.0, -70.0, 35.0, -5.0},
        {5.0, -20.0, 30.0, -20.0, 5.0, 0.0},   {-1.0, 5.0, -10.0, 10.0, -5.0, 1.0}};
    Stretch *stretch = &environment->stretch;
    if (stretch->known && stretch->number == number) {
        return stretch;
    }
    memset(stretch, 0, sizeof *stretch);
    for (int i = 0; i < 6; ++i) {
        double values[VALUES];
        memcpy(values, node_of(environment, number - 2 + i), sizeof values);
        for (int k = 0; k < POWERS; ++k) {
            for (int j = 0; j < VALUES; ++j) {
                stretch->coefficients[k][j] += weights[k][i] / 120.0 * values[j];
            }
        }
    }
    stretch->number = number;
    stretch->known = true;
    return stretch;
}

void plant_forget_surroundings(Environment *environment)
{
    for (int i = 0; i < NODES; ++i) {
        environment->nodes[i].known = false;
    }
    environment->stretch.known = false;
    environment->last.known = false;
    environment->sun.known = false;
}

const Surroundings *plant_surroundings_at(Environment *environment, double t)
{
    Surroundings *around = &environment->last;
    if (around->known && around->t == t) {
        return around;
    }
    const double s = t / INTERVAL;
    int64_t k = (int64_t)s;
    k -= s < (double)k ? 1 : 0;
    const Stretch *stretch = stretch_of(environment, k);
    const double u = s - (double)k;
    double values[VALUES];
    memcpy(values, stretch->coefficients[POWERS - 1], sizeof values);
    for (int i = POWERS - 2; i >= 0; --i) {
        for (int j = 0; j < VALUES; ++j) {
            values[j] = values[j] * u + stretch->coefficients[i][j];
        }
    }
    memcpy(&around->along, values, sizeof values);
    around->density = environment->has_air ? exp(around->along.log_density) : 0.0;
    around->t = t;
    around->known = true;
    return around;
}
