/* What there is at a sample, and the errors from target and plan: docs/how/planned-wheels.md. */
#include "reference.h"
#include "sample.h"

#include <string.h>

static bool is_finite_input(const ControllerPlannedWheelsInputs *u, Fault *f)
{
    const NamedVector given[] = {
        {"b_B", vector(u->b_B)},
        {"dipole_applied", vector(u->dipole_applied)},
        {"Omega_ref", vector(u->Omega_ref)},
        {"dOmega_ref", vector(u->dOmega_ref)},
    };
    return are_wheel_momenta(u->h_w, f) && all_finite_vectors(given, COUNT(given), f) &&
           are_finite_rate_and_orbit(u->omega_B, u->r_N, u->v_N, f);
}

/* The target of the parameters, or that of the inputs where they are connected. */
static bool target_of(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u, Wanted *target,
                      Fault *f)
{
    const bool given[] = {controller_planned_wheels_has_R_ref(u), controller_planned_wheels_has_Omega_ref(u),
                          controller_planned_wheels_has_dOmega_ref(u)};
    if (given[0] != given[1] || given[0] != given[2]) {
        return fault(f, "R_ref", given[0], "R_ref, Omega_ref and dOmega_ref connected, or none of them");
    }
    if (!given[0]) {
        const Vector rest = {0.0, 0.0, 0.0};
        Reference r;
        if (!reference_at(law->p.reference, law->R_d0, rest, 0.0, vector(u->r_N), vector(u->v_N), &r, f)) {
            return false;
        }
        *target = (Wanted){true, r.R_d, r.Omega_d, r.dOmega_d};
        return true;
    }
    *target =
        (Wanted){!is_zero_matrix(matrix(u->R_ref)), matrix(u->R_ref), vector(u->Omega_ref), vector(u->dOmega_ref)};
    return !target->attitude || is_rotation(target->R, REFERENCE_ATTITUDE_TOLERANCE, "R_ref", "a rotation matrix", f);
}

/* (1), (2) for the wheels that work. */
static void take_wheels(const ControllerPlannedWheelsLaw *law, const bool failed[WHEELS_MAX], Sample *s)
{
    const ControllerPlannedWheelsParameters *p = &law->p;
    Vector axes[WHEELS_MAX];
    double torque[WHEELS_MAX] = {0.0, 0.0, 0.0, 0.0}, momentum[WHEELS_MAX] = {0.0, 0.0, 0.0, 0.0};
    int n = 0;
    (void)memset(axes, 0, sizeof axes);
    for (int i = 0; i < WHEELS_MAX; ++i) {
        s->works[i] = i < p->wheels && !failed[i];
        if (s->works[i]) {
            axes[n] = law->axes[i];
            torque[n] = p->wheel_torque_max[i];
            momentum[n] = p->wheel_momentum_max[i];
            n += 1;
        }
    }
    s->torque = zonotope_of(n, axes, torque);
    s->momentum = zonotope_of(n, axes, momentum);
    s->reduced = !(s->torque.inradius > 0.0 && s->momentum.inradius > 0.0);
    s->most = p->torque_share * s->torque.inradius;
}

/* (5), (6). */
bool controller_planned_wheels_take_sample(const ControllerPlannedWheelsLaw *law, const bool failed[WHEELS_MAX],
                                           const ControllerPlannedWheelsInputs *u, Sample *s, Fault *f)
{
    const Matrix R = matrix(u->R_NB);
    const Vector Omega = vector(u->omega_B);
    *s = (Sample){.angle = REFERENCE_NO_ATTITUDE, .Q = identity};
    if (!is_finite_input(u, f) || (!is_zero_matrix(R) && !is_attitude(R, f)) || !target_of(law, u, &s->target, f)) {
        return false;
    }
    s->b = vector(u->b_B);
    for (int i = 0; i < law->p.wheels; ++i) {
        s->h = add(s->h, scale(u->h_w[i], law->axes[i]));
    }
    Vector of_target = {0.0, 0.0, 0.0}; /* momentum that the body is to have, in body axes */
    s->rate = Omega;
    if (is_zero_matrix(R)) {
        s->target.attitude = false;
    } else if (!s->target.attitude) {
        s->rate = subtract(Omega, s->target.Omega);
        of_target = apply(law->J, s->target.Omega);
    } else {
        s->Q = multiply(transposed(s->target.R), R);
        s->zeta = rotation_log(s->Q);
        s->angle = norm(s->zeta);
        s->rate = subtract(Omega, apply_transposed(s->Q, s->target.Omega));
        of_target = apply_transposed(s->Q, apply(law->J, s->target.Omega));
    }
    s->H = subtract(subtract(add(apply(law->J, Omega), s->h), law->h_target), of_target);
    take_wheels(law, failed, s);
    return true;
}

Wanted controller_planned_wheels_plan_at(const ControllerPlannedWheelsState *x, const Wanted *target, double mean)
{
    Wanted plan = *target;
    if ((x->phase == WHEELS_TURN || x->phase == WHEELS_HOLD) && target->attitude) {
        const double time = x->t - x->begun;
        const TurnPoint now = turn_at(&x->turn, time), then = turn_at(&x->turn, time + mean);
        const Matrix left = rotation_exp(scale(now.left, x->axis));
        const Vector moved = apply_transposed(left, target->Omega);
        plan.R = multiply(target->R, left);
        plan.Omega = add(moved, scale(now.rate, x->axis));
        plan.dOmega = subtract(apply_transposed(left, target->dOmega), scale(now.rate, cross(x->axis, moved)));
        plan.dOmega = add(plan.dOmega, scale((then.rate - now.rate) / mean, x->axis));
    }
    return plan;
}

Errors controller_planned_wheels_errors_of(const Wanted *plan, Matrix R, Vector Omega)
{
    const Matrix Q = multiply(transposed(plan->R), R);
    const Vector Omega_d_B = apply_transposed(Q, plan->Omega), omega = subtract(Omega, Omega_d_B);
    return (Errors){rotation_log(Q), omega, subtract(apply_transposed(Q, plan->dOmega), cross(omega, Omega_d_B))};
}
