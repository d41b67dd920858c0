/* The parameters: their check, and what follows from them alone. */
#include "controller_planned.h"

static const double REFERENCE_TOLERANCE = 1e-3; /* of R_d0, which may be typed from four printed decimals */
enum { SEARCH_ITERATIONS_MAX = 1000 };

static bool check_choices(const ControllerPlannedParameters *p, Fault *f)
{
    const struct {
        const char *name;
        int32_t value, low, high;
        const char *expected;
    } counts[] = {
        {"field_model", p->field_model, CONTROLLER_PLANNED_FIELD_MODEL_IGRF14, CONTROLLER_PLANNED_FIELD_MODEL_WMM2025,
         "1 to 5"},
        {"field_degree", p->field_degree, 1, ONBOARD_DEGREE_MAX, "1 to 13"},
        {"search_iterations", p->search_iterations, 1, SEARCH_ITERATIONS_MAX, "1 to 1000"},
    };
    if (p->reference != CONTROLLER_PLANNED_REFERENCE_LVLH && p->reference != CONTROLLER_PLANNED_REFERENCE_INERTIAL) {
        return fault(f, "reference", p->reference, "1 (lvlh) or 2 (inertial); the planned controller does not offer 3 (rate)");
    }
    for (size_t i = 0; i < COUNT(counts); ++i) {
        if (counts[i].value < counts[i].low || counts[i].value > counts[i].high) {
            return fault(f, counts[i].name, counts[i].value, counts[i].expected);
        }
    }
    return true;
}

/* Whether the field model covers the epoch. */
static bool check_epoch(const ControllerPlannedParameters *p, Fault *f)
{
    const GaussModel *model = &controller_planned_gauss_models[p->field_model - 1];
    Epoch epoch;
    if (!is_epoch(p->epoch, &epoch, f)) {
        return false;
    }
    const double year = year_of_days(days_of_epoch(&epoch));
    if (year < model->years[0] || year > model->valid_until) {
        return fault(f, "epoch", year, model->covered);
    }
    return true;
}

bool controller_planned_check(const ControllerPlannedParameters *p, Fault *f)
{
    const Named positive[] = {
        {"control_period", p->control_period},     {"dipole_max", p->dipole_max},
        {"wheel_torque_max", p->wheel_torque_max}, {"wheel_momentum_max", p->wheel_momentum_max},
        {"plan_period", p->plan_period},           {"steering_limit", p->steering_limit},
        {"disturbance_time", p->disturbance_time}, {"gravitational_parameter", p->gravitational_parameter},
    };
    const Named not_negative[] = {
        {"attitude_noise", p->attitude_noise},   {"rate_noise", p->rate_noise},
        {"disturbance_max", p->disturbance_max}, {"residual_dipole_max", p->residual_dipole_max},
        {"identify_spread", p->identify_spread},
    };
    const NamedVector field_error = {"field_error", vector(p->field_error)};
    static const char *const rotation = "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001";
    return all_positive(positive, COUNT(positive), f) && all_not_negative(not_negative, COUNT(not_negative), f) &&
           all_finite_vectors(&field_error, 1, f) && check_choices(p, f) && is_inertia(matrix(p->J_B), "J_B", f) &&
           is_positive_definite(matrix(p->L0), "L0", f) && is_ascending(p->K0, f) &&
           has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) && check_epoch(p, f) &&
           is_rotation(matrix(p->R_d0), REFERENCE_TOLERANCE, "R_d0", rotation, f);
}

void controller_planned_prepare(const ControllerPlannedParameters *p, ControllerPlannedLaw *law)
{
    Epoch epoch = {0, 0, 0, 0};
    law->p = *p;
    law->R_d0 = nearest_rotation(matrix(p->R_d0));
    law->rod_axes = with_unit_rows(matrix(p->rod_axes));
    (void)epoch_read(p->epoch, &epoch);
    controller_planned_onboard_field(&controller_planned_gauss_models[p->field_model - 1], days_of_epoch(&epoch),
                                     p->field_degree, p->field_error, &law->field);
}
