/* The parameters: their check, and what follows from them alone. Tests: tests/native/test_flavours.py. */
#include "estimator.h"
#include "gauss_models.h"

/* A block for one wheel has no parameter for how many there are. */
#if ESTIMATOR_WHEELS > 1
#define WHEELS(p) ((p)->wheels)
static const char *const axis_names[] = {"wheel_axis[1]", "wheel_axis[2]", "wheel_axis[3]", "wheel_axis[4]"};
#else
#define WHEELS(p) 1
static const char *const axis_names[] = {"wheel_axis"};
#endif

static bool check_choices(const EstimatorParameters *p, Fault *f)
{
    if (p->rate_source != ESTIMATOR_RATE_SOURCE_GYRO && p->rate_source != ESTIMATOR_RATE_SOURCE_DYNAMICS) {
        return fault(f, "rate_source", p->rate_source, "1 (gyro) or 2 (dynamics)");
    }
#if defined(ESTIMATOR_WITHOUT_BANK)
    if (p->bank) {
        return fault(f, "bank", 1.0, "false: ESTIMATOR_WITHOUT_BANK leaves no room for its filters");
    }
#endif
    if (p->bank && p->rate_source != ESTIMATOR_RATE_SOURCE_GYRO) {
        return fault(f, "bank", 1.0, "rate_source 'gyro'; the bank follows the measured rate");
    }
    if (p->field_model < ESTIMATOR_FIELD_MODEL_IGRF14 || p->field_model > ESTIMATOR_FIELD_MODEL_WMM2025) {
        return fault(f, "field_model", p->field_model, "1 to 5");
    }
    if (p->field_degree < 1 || p->field_degree > ONBOARD_DEGREE_MAX) {
        return fault(f, "field_degree", p->field_degree, "1 to 13");
    }
    return true;
}

static bool check_vectors(const EstimatorParameters *p, Fault *f)
{
    if (!is_finite(vector(p->field_error))) {
        return fault(f, "field_error", NAN, "finite numbers");
    }
    if (!is_finite_matrix(matrix(p->rod_field))) {
        return fault(f, "rod_field", NAN, "finite numbers");
    }
    for (int i = 0; i < BANK_DIODES; ++i) {
        const Vector axis = vector(p->sun_sensor_axes[i]);
        if (norm(axis) != 0.0 && !is_unit_vector(axis, "sun_sensor_axes", f)) {
            return false;
        }
    }
    if (!(WHEELS(p) >= 0 && WHEELS(p) <= ESTIMATOR_WHEELS)) {
        return fault(f, "wheels", WHEELS(p), "0 to 4");
    }
    for (int i = 0; i < ESTIMATOR_WHEELS; ++i) {
        if (i < WHEELS(p) && !is_unit_vector(vector(p->wheel_axis[i]), axis_names[i], f)) {
            return false;
        }
    }
    return is_unit_vector(vector(p->boresight_B), "boresight_B", f) &&
           has_unit_rows(matrix(p->rod_axes), "rod_axes", f) && is_inertia(matrix(p->J_B), "J_B", f);
}

bool estimator_check(const EstimatorParameters *p, Fault *f)
{
    const Named positive[] = {
        {"field_noise", p->field_noise},
        {"sun_noise", p->sun_noise},
        {"sun_sensor_noise", p->sun_sensor_noise},
        {"attitude_noise", p->attitude_noise},
        {"attitude_noise_boresight", p->attitude_noise_boresight},
        {"gate", p->gate},
        {"gravitational_parameter", p->gravitational_parameter},
    };
    const Named not_negative[] = {
        {"angle_random_walk", p->angle_random_walk},
        {"rate_random_walk", p->rate_random_walk},
        {"rate_bias_sigma", p->rate_bias_sigma},
        {"rate_scale_sigma", p->rate_scale_sigma},
        {"momentum_random_walk", p->momentum_random_walk},
        {"field_bias_sigma", p->field_bias_sigma},
        {"field_random_walk", p->field_random_walk},
        {"rod_field_error", p->rod_field_error},
        {"dipole_limit", p->dipole_limit},
        {"valid_sigma", p->valid_sigma},
        {"orbit_time", p->orbit_time},
        {"albedo", p->albedo},
        {"lasting_field", p->lasting_field},
        {"lasting_field_scale", p->lasting_field_scale},
        {"lasting_rate_scale", p->lasting_rate_scale},
        {"lasting_sun", p->lasting_sun},
        {"lasting_attitude", p->lasting_attitude},
    };
    return all_positive(positive, COUNT(positive), f) && all_not_negative(not_negative, COUNT(not_negative), f) &&
           check_choices(p, f) && check_vectors(p, f) &&
           is_covered_epoch(p->epoch, &gauss_models[p->field_model - 1], f);
}

void estimator_prepare(const EstimatorParameters *p, EstimatorLaw *law)
{
    law->p = *p;
    law->days = days_of_text(p->epoch);
    onboard_field(&gauss_models[p->field_model - 1], law->days, p->field_degree, p->field_error, &law->field);
    law->J = matrix(p->J_B);
    law->J_inverse = inverse(law->J);
    law->rod_axes = matrix(p->rod_axes);
    law->rod_field = matrix(p->rod_field);
    for (int i = 0; i < ESTIMATOR_WHEELS; ++i) {
        law->wheel_axes[i] = i < WHEELS(p) ? unit_vector(vector(p->wheel_axis[i])) : (Vector){0.0, 0.0, 0.0};
    }
    law->tracker_axes = estimator_axes_about(unit_vector(vector(p->boresight_B)));
}
