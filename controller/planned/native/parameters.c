/* The check of the parameters, and what follows from them alone: docs/how/planned-scales.md, Gains and periods that
 * are refused. Tests: test_refusals.py, test_scales.py. */
#include "controller_planned.h"

#include "gauss_models.h"
#include "reference.h"

static const double FIELD_WRONG = 2e-6; /* T, from a model of all degrees */
static const double LEFT_OUT = 3.0;     /* rms of what a model of few degrees leaves out */
enum { SEARCH_ITERATIONS_MAX = 1000 };

static bool check_choices(const ControllerPlannedParameters *p, Fault *f)
{
    if (p->reference != CONTROLLER_PLANNED_REFERENCE_LVLH && p->reference != CONTROLLER_PLANNED_REFERENCE_INERTIAL) {
        return fault(f, "reference", p->reference,
                     "1 (lvlh) or 2 (inertial); the planned controller does not offer 3 (rate)");
    }
    if (p->field_model < CONTROLLER_PLANNED_FIELD_MODEL_IGRF14 ||
        p->field_model > CONTROLLER_PLANNED_FIELD_MODEL_WMM2025) {
        return fault(f, "field_model", p->field_model, "1 to 5");
    }
    if (p->field_degree < 1 || p->field_degree > ONBOARD_DEGREE_MAX) {
        return fault(f, "field_degree", p->field_degree, "1 to 13");
    }
    if (p->search_iterations < 1 || p->search_iterations > SEARCH_ITERATIONS_MAX) {
        return fault(f, "search_iterations", p->search_iterations, "1 to 1000");
    }
    return true;
}

/* About its equilibrium the law [8] on sampled errors is J a = -L v - S x, S = tr(K) I - K, held for T. An
 * eigenvector q of its motion from sample to sample makes numbers of the matrices, d = T q*L q/q*J q and s = T^2 q*S
 * q/q*J q, and its roots are those of z^2 + (d + s/2 - 2) z + 1 - d + s/2: within the unit circle exactly where d <
 * 2 and s < 2 d. So the law is stable where T L < 2 J and T S < 2 L as matrices; where J, L and S have the same
 * axes, nowhere else. */
static bool check_gains(const ControllerPlannedParameters *p, Fault *f)
{
    const double T = p->control_period;
    const Matrix J = matrix(p->J_B), L = matrix(p->L0);
    if (controller_planned_has_L0(p)) {
        if (!is_positive_definite(L, "L0", f)) {
            return false;
        }
        const double damping = T * controller_planned_largest_of(J, L);
        if (!(damping < 2.0)) {
            return fault(f, "L0", damping,
                         "L0 control_period/J_B below 2 about each axis (this is the largest), or 0: computed");
        }
    }
    return !controller_planned_has_K0(p) || is_ascending(p->K0, f);
}

bool controller_planned_gains_fit(ControllerPlannedLaw *law, const Scales *scales, Fault *f)
{
    const ControllerPlannedParameters *p = &law->p;
    const bool has_K0 = controller_planned_has_K0(p), has_L0 = controller_planned_has_L0(p);
    if (law->gains_fit) {
        return true;
    }
    const Vector K = has_K0 ? vector(p->K0) : scales->K;
    const Matrix L = has_L0 ? matrix(p->L0) : scales->L;
    const Matrix S = {{K.y + K.z, 0.0, 0.0}, {0.0, K.z + K.x, 0.0}, {0.0, 0.0, K.x + K.y}};
    const double stiffness = p->control_period * controller_planned_largest_of(L, S);
    law->gains_fit = stiffness < 2.0;
    return law->gains_fit || fault(f, has_K0 ? "K0" : "L0", stiffness,
                                   "(K0[i] + K0[j]) control_period/L0 below 2 about each axis, with the gains as given "
                                   "or computed (this is the "
                                   "largest): smaller K0, larger L0 or a shorter control_period");
}

/* A plan is renewed five times in T, and no oftener than the control samples. */
static bool check_period(const ControllerPlannedParameters *p, Fault *f)
{
    const double share = p->control_period / controller_planned_scales(p, LOW_ORBIT).time;
    return share <= PLAN_PERIOD ||
           fault(f, "control_period", share,
                 "at most 0.2 of sqrt(J/(dipole_max B)), in which the rods turn the satellite (this is the share)");
}

/* T, rms over the Earth's surface of the degrees above `degree` (Lowes, 1966). */
static double left_out(const GaussModel *model, int degree)
{
    const double *g = model->g[model->epochs - 1], *h = model->h[model->epochs - 1];
    double square = 0.0;
    for (int n = degree + 1; n <= ONBOARD_DEGREE_MAX; ++n) {
        for (int k = (n - 1) * (n + 2) / 2; k < n * (n + 3) / 2; ++k) {
            square += (n + 1) * (g[k] * g[k] + h[k] * h[k]);
        }
    }
    return 1e-9 * sqrt(square);
}

static bool check_rods(const ControllerPlannedParameters *p, Fault *f)
{
    const Vector gains = vector(p->rod_gains0);
    return are_rod_limits(p->rod_limits, f) &&
           (norm(gains) > 0.0 || fault(f, "rod_gains0", 0.0, "at least one rod that is not dead"));
}

bool controller_planned_check(const ControllerPlannedParameters *p, Fault *f)
{
    const Named positive[] = {
        {"control_period", p->control_period},
        {"dipole_max", p->dipole_max},
        {"wheel_torque_max", p->wheel_torque_max},
        {"wheel_momentum_max", p->wheel_momentum_max},
        {"gravitational_parameter", p->gravitational_parameter},
    };
    const Named not_negative[] = {
        {"attitude_noise", p->attitude_noise},   {"rate_noise", p->rate_noise},
        {"plan_period", p->plan_period},         {"steering_limit", p->steering_limit},
        {"identify_spread", p->identify_spread}, {"rate_bias_max", p->rate_bias_max},
        {"momentum_weight", p->momentum_weight}, {"disturbance_time", p->disturbance_time},
    };
    const Named bounds[] = {{"disturbance_max", p->disturbance_max}, {"residual_dipole_max", p->residual_dipole_max}};
    const NamedVector vectors[] = {{"field_error", vector(p->field_error)}, {"rod_gains0", vector(p->rod_gains0)}};
    static const char *const rotation = "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001";
    return all_positive(positive, COUNT(positive), f) && all_not_negative(not_negative, COUNT(not_negative), f) &&
           all_finite(bounds, COUNT(bounds), f) && all_finite_vectors(vectors, COUNT(vectors), f) &&
           check_choices(p, f) && check_rods(p, f) && is_inertia(matrix(p->J_B), "J_B", f) && check_gains(p, f) &&
           check_period(p, f) && is_unit_vector(vector(p->wheel_axis), "wheel_axis", f) &&
           has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) &&
           is_covered_epoch(p->epoch, &gauss_models[p->field_model - 1], f) &&
           is_rotation(matrix(p->R_d0), REFERENCE_PARAMETER_TOLERANCE, "R_d0", rotation, f);
}

void controller_planned_prepare(const ControllerPlannedParameters *p, ControllerPlannedLaw *law)
{
    law->p = *p;
    law->gains_fit = false;
    law->R_d0 = nearest_rotation(matrix(p->R_d0));
    law->rod_axes = with_unit_rows(matrix(p->rod_axes));
    law->wheel_axis = unit_vector(vector(p->wheel_axis));
    law->beside_B = (Vector){0.0, 0.0, 0.0};
    onboard_field(&gauss_models[p->field_model - 1], days_of_text(p->epoch), p->field_degree, p->field_error,
                  &law->field);
    law->field_tolerance = FIELD_WRONG + LEFT_OUT * left_out(&gauss_models[p->field_model - 1], p->field_degree);
}
