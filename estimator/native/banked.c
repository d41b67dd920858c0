/* The estimate by the bank of filters: what `bank` puts in the place of the one filter.
 * Tests: tests/native/test_flavours.py, tests/estimator/test_banked.py. */
#include <string.h>

#include "onboard.h"
#include "state.h"

static const double EARTH_RADIUS = 6378137.0; /* m */
static const double CURRENT_LIGHT = 0.99;     /* of the Sun that must be seen for currents to count */
enum { PRUNE_EVERY = 20 };                    /* measurements of the field */

/* All filters take a measurement; it counts as rejected where it is beyond the gate of the best one. */
static void take(const EstimatorLaw *law, const Directions *seen, int sensor, int32_t best, Estimate *x, Bank *bank)
{
    for (int32_t k = 0; k < bank->count; ++k) {
        BankFilter *filter = &bank->of[k];
        const Innovation innovation = estimator_innovation(law, seen, sensor, filter->R, filter->field_bias);
        const double nis = estimator_bank_correct(&innovation, law->p.gate, filter);
        x->nis[sensor] = k == best ? nis : x->nis[sensor];
    }
    if (!(x->nis[sensor] <= law->p.gate) && x->rejected[sensor] < INT32_MAX) {
        ++x->rejected[sensor];
    }
}

/* A current is max(0, n.s) + the Earth's light ((1 + n.nadir)/2)^2. */
static void take_current(const EstimatorLaw *law, Vector n, double current, const Directions *seen, Vector r_N,
                         Bank *bank)
{
    const double size = norm(r_N), variance = law->p.sun_sensor_noise * law->p.sun_sensor_noise;
    const double near = EARTH_RADIUS / size,
                 lit = law->p.albedo * near * near * larger(0.0, dot(r_N, seen->sun_N) / size);
    for (int32_t k = 0; k < bank->count; ++k) {
        const Vector s = apply_transposed(bank->of[k].R, seen->sun_N);
        const Vector nadir = apply_transposed(bank->of[k].R, scale(-1.0 / size, r_N));
        const double cosine = dot(n, s), half = 0.5 * (1.0 + dot(n, nadir));
        const Vector direct = cosine > 0.0 ? cross(n, s) : (Vector){0.0, 0.0, 0.0};
        Innovation innovation;
        memset(&innovation, 0, sizeof innovation);
        innovation.y.x = current - larger(0.0, cosine) - lit * half * half;
        innovation.H_attitude.a = add(direct, scale(lit * half, cross(n, nadir)));
        innovation.r = (Vector){variance, variance, variance};
        (void)estimator_bank_correct(&innovation, law->p.gate, &bank->of[k]);
    }
}

static void take_all(const EstimatorLaw *law, const EstimatorInputs *u, bool new_currents, const Directions *seen,
                     Estimate *x, Bank *bank)
{
    const int32_t best = estimator_bank_best(bank);
    if (seen->has_tracker) {
        take(law, seen, GATED_TRACKER, best, x, bank);
    }
    if (seen->has_sun) {
        take(law, seen, GATED_SUN, best, x, bank);
    }
    for (int i = 0; i < BANK_DIODES && new_currents && estimator_sunlight(x->r_N, seen->sun_N) > CURRENT_LIGHT; ++i) {
        const Vector n = vector(law->p.sun_sensor_axes[i]);
        if (dot(n, n) > 0.0 && fabs(u->sun_sensors[i]) < ESTIMATOR_ABSENT_MIN) {
            take_current(law, n, u->sun_sensors[i], seen, x->r_N, bank);
        }
    }
    if (seen->has_field) {
        take(law, seen, GATED_FIELD, best, x, bank);
        bank->in_a_row = x->nis[GATED_FIELD] <= law->p.gate ? 0 : bank->in_a_row + 1;
        ++bank->taken;
        if (bank->taken >= PRUNE_EVERY) {
            estimator_bank_prune(bank);
        }
    }
}

void estimator_by_bank(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Directions *seen,
                       double h, Estimate *x, Bank *bank)
{
    const EstimatorParameters *p = &law->p;
    const BankNoise noise = {p->angle_random_walk, p->rate_random_walk, p->rate_bias_sigma,
                             p->rate_scale_sigma,  p->field_bias_sigma, p->field_random_walk};
    const Vector now = fresh->rate ? vector(u->omega_B_measured) : bank->rate;
    x->since_rate += h;
    if (bank->count > 0) {
        estimator_bank_propagate(now, h, fresh->rate ? x->since_rate : 0.0, &noise, bank);
    } else if (seen->has_field) {
        estimator_bank_start(seen->b_B, seen->field_N, &noise, bank);
    }
    x->since_rate = fresh->rate ? 0.0 : x->since_rate;
    bank->rate = x->rate = now;
    if (bank->count == 0) {
        return;
    }
    take_all(law, u, fresh->sun, seen, x, bank);
    const BankFilter *best = &bank->of[estimator_bank_best(bank)];
    estimator_bank_look(&noise, bank);
    const Vector rate = subtract(now, best->bias), k = best->scale;
    x->known = x->known || estimator_bank_doubtful(bank) == 0;
    x->R = best->R;
    x->rate_bias = best->bias;
    x->field_bias = best->field_bias;
    x->rate = add((Vector){rate.x / (1.0 + k.x), rate.y / (1.0 + k.y), rate.z / (1.0 + k.z)}, best->bias);
    for (int i = 0; i < ERROR_STATES; ++i) {
        memcpy(x->P.m[i], best->P[i], sizeof x->P.m[i]);
    }
    if (bank->in_a_row >= IN_A_ROW) {
        estimator_bank_clear(bank);
    }
    x->tracking = x->known && bank->count > 0;
}
