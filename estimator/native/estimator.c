#include "estimator.h"

#include "estimator_guard.h"

#include <string.h>

#include "onboard.h"
#include "reference.h"

static const double PI = 3.14159265358979323846;
static const double STEP_MAX = 1000.0; /* s */

static bool measurements_fit(const EstimatorInputs *u, Fault *f)
{
    const NamedVector inputs[] = {
        {"omega_B_measured", vector(u->omega_B_measured)}, {"b_B_measured", vector(u->b_B_measured)},
        {"r_N_measured", vector(u->r_N_measured)},         {"v_N_measured", vector(u->v_N_measured)},
        {"sun_B_measured", vector(u->sun_B_measured)},     {"sun_sensors", vector(u->sun_sensors)},
        {"sun_sensors", vector(u->sun_sensors + 3)}};
    if (!all_finite_vectors(inputs, COUNT(inputs), f)) {
        return false;
    }
    const double b = norm(vector(u->b_B_measured)), r = norm(vector(u->r_N_measured));
    if (b > ONBOARD_FIELD_MAX) {
        return fault(f, "b_B_measured", b, "a field in tesla, |b_B_measured| at most 0.001");
    }
    if (r > 0.0 && !(r >= ONBOARD_R_MIN)) {
        return fault(f, "r_N_measured", r, "at least 1000 km from the Earth's centre");
    }
    const Matrix R = matrix(u->R_NB_measured);
    if (!is_finite_matrix(R)) {
        return fault(f, "R_NB_measured", NAN, "finite numbers");
    }
    return !estimator_has_R_NB_measured(u) || is_zero_matrix(R) ||
           is_rotation(R, REFERENCE_ATTITUDE_TOLERANCE, "R_NB_measured",
                       "a rotation matrix, max |R_NB_measured^T R_NB_measured - I| at most 0.0001", f);
}

static bool actuators_fit(const EstimatorInputs *u, Fault *f)
{
    for (int i = 0; i < ESTIMATOR_WHEELS; ++i) {
        const Named scalars[] = {{"wheel_torque", u->wheel_torque[i]}, {"h_w", u->h_w[i]}};
        if (!all_finite(scalars, COUNT(scalars), f)) {
            return false;
        }
    }
    return all_finite_vectors(&(NamedVector){"dipole", vector(u->dipole)}, 1, f);
}

/* What each wheel has along its axis, in body axes and all together. */
static Vector of_wheels(const EstimatorLaw *law, const double each[ESTIMATOR_WHEELS])
{
    Vector sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < ESTIMATOR_WHEELS; ++i) {
        sum = add(sum, scale(each[i], law->wheel_axes[i]));
    }
    return sum;
}

static Given given_by(const EstimatorLaw *law, const EstimatorInputs *u)
{
    const bool torque = estimator_has_wheel_torque(u), momentum = estimator_has_h_w(u);
    const Vector none = {0.0, 0.0, 0.0};
    return (Given){.dipole = estimator_has_dipole(u) ? vector(u->dipole) : none,
                   .wheel_torque_B = torque ? of_wheels(law, u->wheel_torque) : none,
                   .momentum_B = momentum ? of_wheels(law, u->h_w) : none,
                   .has_wheel_torque = torque,
                   .has_h_w = momentum};
}

static void put_out(const EstimatorLaw *law, const Estimate *x, const Bank *bank, EstimatorOutputs *y)
{
    const Vector sun_N = estimator_sun_direction(law->days + x->t / 86400.0);
    memset(y, 0, sizeof *y);
    if (x->known) {
        store_matrix(x->R, y->R_NB);
    }
    store(subtract(x->rate, x->rate_bias), y->omega_B);
    store(x->r_N, y->r_N);
    store(x->v_N, y->v_N);
    store(x->b_B, y->b_B);
    store(x->rate_bias, y->rate_bias_B);
    store(x->field_bias, y->field_bias_B);
    y->attitude_valid = x->tracking;
    for (int i = 0; i < 3; ++i) {
        y->attitude_sigma_B[i] = x->tracking ? sqrt(x->P.m[i][i]) : PI;
        y->attitude_valid = y->attitude_valid && y->attitude_sigma_B[i] < law->p.valid_sigma;
    }
    if (law->p.bank) {
        y->attitude_doubtful = estimator_bank_doubtful(bank);
        y->attitude_valid = y->attitude_valid && y->attitude_doubtful == 0;
        y->ambiguity = bank->ambiguity;
        store(bank->scale, y->rate_scale_B);
    }
    y->attitude_bound = estimator_bound(law, x, y->attitude_doubtful != 0);
    for (int i = 0; i < 6; ++i) {
        memcpy(y->covariance[i], x->P.m[i], sizeof y->covariance[i]);
    }
    memcpy(y->nis, x->nis, sizeof y->nis);
    memcpy(y->rejected, x->rejected, sizeof y->rejected);
    for (int i = 0; i < SENSORS; ++i) {
        y->health[i] = estimator_health(&x->watch[i]);
    }
    store(sun_N, y->sun_N);
    y->sunlight = x->oriented ? estimator_sunlight(x->r_N, sun_N) : 0.0;
}

/* Of each measurement whether it is new, from its number and the last one; at the start 0 says that there is none
 * yet. */
static Fresh fresh_of(const int32_t counts[5], const int32_t last[5])
{
    bool fresh[5];
    for (int i = 0; i < 5; ++i) {
        fresh[i] = counts[i] < 0 || counts[i] != last[i];
    }
    return (Fresh){fresh[0], fresh[1], fresh[2], fresh[3], fresh[4]};
}

static void step(const EstimatorLaw *law, const EstimatorInputs *u, double h, EstimatorState *x)
{
    const int32_t counts[5] = {u->rate_sample, u->field_sample, u->orbit_sample, u->attitude_sample, u->sun_sample};
    x->given = given_by(law, u);
    x->fresh = fresh_of(counts, x->counts);
    memcpy(x->counts, counts, sizeof counts);
    x->h = h;
    x->now = x->before;
    estimator_advance(law, u, &x->fresh, &x->given, h, &x->now, &x->bank);
}

bool estimator_start(const EstimatorLaw *law, const EstimatorInputs *u, EstimatorState *x, Fault *f)
{
    memset(x, 0, sizeof *x);
    estimator_blank(law, u, &x->before);
    estimator_bank_clear(&x->bank);
    x->bank.rate = x->before.rate;
    if (!measurements_fit(u, f) || !actuators_fit(u, f)) {
        return false;
    }
    step(law, u, 0.0, x);
    return true;
}

/*@ requires \separated(x, y, f);
    ESTIMATOR_FINITE */
bool estimator_outputs(const EstimatorLaw *law, const EstimatorState *x, const EstimatorInputs *u, EstimatorOutputs *y,
                       Fault *f)
{
    if (!measurements_fit(u, f) || !actuators_fit(u, f)) {
        return false;
    }
    Estimate now = x->before;
    if (law->p.bank) {
        now = x->now;
    } else {
        estimator_advance(law, u, &x->fresh, &x->given, x->h, &now, NULL);
    }
    put_out(law, &now, &x->bank, y);
    return estimator_guard(y, f);
}

/*@ requires \separated(x, y, f);
    ESTIMATOR_FINITE */
bool estimator_step(const EstimatorLaw *law, EstimatorState *x, const EstimatorInputs *u, double h, EstimatorOutputs *y,
                    Fault *f)
{
    if (!(h >= 0.0 && h <= STEP_MAX)) {
        return fault(f, "communicationStepSize", h, "at least 0 and at most 1000 s");
    }
    if (!measurements_fit(u, f) || !actuators_fit(u, f)) {
        return false;
    }
    x->before = x->now;
    step(law, u, h, x);
    put_out(law, &x->now, &x->bank, y);
    return estimator_guard(y, f);
}
