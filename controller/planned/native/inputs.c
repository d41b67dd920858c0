/* Whether the controller can work with the inputs: docs/how/planned.md, References by the ports.
 * Tests: test_refusals.py, test_optional_inputs.py, test_reference_ports.py. */
#include "state.h"

#include "fault.h"
#include "reference.h"

static const double CLOSED = 0.999; /* of the energy that escapes: the orbit's largest */

/* Whether the reference to come has numbers and is given in full, or not at all. */
static bool ahead_fits(const ControllerPlannedInputs *u, Fault *f)
{
    static const char *const all =
        "to be connected: connect t_ahead, turn_ahead and Omega_ahead with R_ref, or none of the three";
    const bool times = controller_planned_has_t_ahead(u), turns = controller_planned_has_turn_ahead(u);
    int given_times = AHEAD_TIMES;
    while (given_times > 0 && u->t_ahead[given_times - 1] == 0.0) {
        --given_times;
    }
    for (int k = 0; k < AHEAD_TIMES; ++k) {
        const NamedVector given[] = {{"t_ahead", {u->t_ahead[k], 0.0, 0.0}},
                                     {"turn_ahead", vector(u->turn_ahead[k])},
                                     {"Omega_ahead", vector(u->Omega_ahead[k])}};
        if (!all_finite_vectors(given, COUNT(given), f)) {
            return false;
        }
        if (times && k > 0 && k < given_times && !(u->t_ahead[k] > u->t_ahead[k - 1])) {
            return fault(f, "t_ahead", u->t_ahead[k], "ascending times, zeros at the end where there are fewer");
        }
    }
    if (times != turns || turns != controller_planned_has_Omega_ahead(u) ||
        (times && !controller_planned_has_R_ref(u))) {
        const char *missing = !times                            ? "t_ahead"
                              : !turns                          ? "turn_ahead"
                              : controller_planned_has_R_ref(u) ? "Omega_ahead"
                                                                : "R_ref";
        return fault(f, missing, CONTROLLER_PLANNED_ABSENT_MIN, all);
    }
    return true;
}

bool controller_planned_inputs_finite(const ControllerPlannedInputs *u, Fault *f)
{
    const NamedVector inputs[] = {{"omega_B", vector(u->omega_B)},
                                  {"r_N", vector(u->r_N)},
                                  {"v_N", vector(u->v_N)},
                                  {"b_B", vector(u->b_B)},
                                  {"attitude_sigma_B", vector(u->attitude_sigma_B)},
                                  {"R_ref", vector(u->R_ref[0])},
                                  {"R_ref", vector(u->R_ref[1])},
                                  {"R_ref", vector(u->R_ref[2])},
                                  {"Omega_ref", vector(u->Omega_ref)},
                                  {"dOmega_ref", vector(u->dOmega_ref)}};
    if (!all_finite_vectors(inputs, COUNT(inputs), f)) {
        return false;
    }
    const bool attitude = controller_planned_has_R_ref(u), rate = controller_planned_has_Omega_ref(u);
    if (attitude != rate || rate != controller_planned_has_dOmega_ref(u)) {
        return fault(f,
                     !attitude ? "R_ref"
                     : !rate   ? "Omega_ref"
                               : "dOmega_ref",
                     CONTROLLER_PLANNED_ABSENT_MIN,
                     "to be connected: connect R_ref, Omega_ref and dOmega_ref, or none of them");
    }
    if (!ahead_fits(u, f)) {
        return false;
    }
    if (controller_planned_has_b_B(u) && norm(vector(u->b_B)) > ONBOARD_FIELD_MAX) {
        return fault(f, "b_B", norm(vector(u->b_B)), "a field in tesla, |b_B| at most 0.001 (or 1e9: not connected)");
    }
    const Named scalars[] = {{"h_w", u->h_w}, {"attitude_bound", u->attitude_bound}};
    if (!all_finite(scalars, COUNT(scalars), f)) {
        return false;
    }
    for (int i = 0; i < CONTROLS; ++i) {
        if (!isfinite(u->u_applied[i])) {
            return fault(f, "u_applied", u->u_applied[i], "finite numbers");
        }
    }
    return true;
}

bool controller_planned_inputs_fit(const ControllerPlannedInputs *u, double mu, Fault *f)
{
    if (!controller_planned_inputs_finite(u, f)) {
        return false;
    }
    const Vector r_N = vector(u->r_N), v_N = vector(u->v_N);
    const double r = norm(r_N), v = norm(v_N);
    if (!(r >= ONBOARD_R_MIN)) {
        return fault(f, "r_N", r, "at least 1000 km from the Earth's centre");
    }
    if (!(norm(cross(r_N, v_N)) > REFERENCE_COLLINEAR * r * v)) {
        return fault(f, "v_N", norm(cross(r_N, v_N)),
                     "a velocity that spans the orbit's plane with r_N, |r x v| above 0");
    }
    if (!(0.5 * v * v < CLOSED * mu / r)) {
        return fault(f, "v_N", v, "the velocity of a closed orbit, below that of escape");
    }
    const Matrix R_ref = matrix(u->R_ref);
    return is_attitude(matrix(u->R_NB), f) &&
           (!controller_planned_has_R_ref(u) || is_zero_matrix(R_ref) ||
            is_rotation(R_ref, REFERENCE_ATTITUDE_TOLERANCE, "R_ref",
                        "a rotation matrix, max |R_ref^T R_ref - I| at most 0.0001, or zeros", f));
}
