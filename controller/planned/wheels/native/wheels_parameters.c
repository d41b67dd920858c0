/* The parameters of the controller: their check, and what follows from them alone. */
#include <string.h>

#include "reference.h"
#include "sample.h"

/* Whether there is room beside the wheels' target, in any direction: (2). */
static bool bears_target(const ControllerPlannedWheelsParameters *p, Fault *f)
{
    Vector axes[WHEELS_MAX], h = {0.0, 0.0, 0.0};
    (void)memset(axes, 0, sizeof axes);
    for (int i = 0; i < p->wheels; ++i) {
        axes[i] = unit_vector(vector(p->wheel_axis[i]));
        h = add(h, scale(p->wheel_momentum_target[i], axes[i]));
    }
    const Zonotope z = zonotope_of(p->wheels, axes, p->wheel_momentum_max);
    if (z.inradius > 0.0 && !(norm(h) <= 0.5 * z.inradius)) {
        return fault(f, "wheel_momentum_target", norm(h),
                     "a sum of at most half of what the wheels hold in any direction");
    }
    return true;
}

bool controller_planned_wheels_check(const ControllerPlannedWheelsParameters *p, Fault *f)
{
    const Named positive[] = {{"dipole_max", p->dipole_max},         {"bandwidth", p->bandwidth},
                              {"torque_share", p->torque_share},     {"momentum_share", p->momentum_share},
                              {"unloading_time", p->unloading_time}, {"command_period", p->command_period}};
    const double none[3] = {0.0, 0.0, 0.0};
    if (!is_reference(p->reference, f) || !is_inertia(matrix(p->J_B), "J_B", f) ||
        !has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) || !are_rod_limits(p->rod_limits, f) ||
        !are_wheels(p->wheels, p->wheel_axis, p->wheel_torque_max, p->wheel_momentum_max, f) ||
        !all_positive(positive, COUNT(positive), f) || !is_reference_start(p->R_d0, none, f)) {
        return false;
    }
    if (p->reference == REFERENCE_RATE) {
        return fault(f, "reference", p->reference, "1 (lvlh) or 2 (inertial)");
    }
    for (int i = 0; i < p->wheels; ++i) {
        if (!(fabs(p->wheel_momentum_target[i]) <= p->wheel_momentum_max[i])) {
            return fault(f, "wheel_momentum_target", p->wheel_momentum_target[i], "within wheel_momentum_max");
        }
    }
    if (!bears_target(p, f)) {
        return false;
    }
    const ControllerPlannedParameters few = controller_planned_wheels_few_parameters(p, WHEELS_MAX + 1);
    const bool fits = controller_planned_check(&few, f);
    f->text = !fits && f->text != NULL ? p->epoch : NULL; /* the only text; that of `few` is gone after the return */
    return fits;
}

void controller_planned_wheels_prepare(const ControllerPlannedWheelsParameters *p, ControllerPlannedWheelsLaw *law)
{
    const double *limits = p->rod_limits;
    law->p = *p;
    law->J = matrix(p->J_B);
    law->J_bound = 0.5 * (law->J.a.x + law->J.b.y + law->J.c.z); /* no moment is above the sum of the others */
    law->R_d0 = nearest_rotation(matrix(p->R_d0));
    law->rods = with_unit_rows(matrix(p->rod_axes));
    law->rods_inverse = inverse(transposed(law->rods));
    law->rods_dipole = p->dipole_max * (limits[0] + limits[1] + limits[2]) / 3.0;
    law->h_target = (Vector){0.0, 0.0, 0.0};
    for (int i = 0; i < WHEELS_MAX; ++i) {
        law->axes[i] = i < p->wheels ? unit_vector(vector(p->wheel_axis[i])) : (Vector){0.0, 0.0, 0.0};
        law->h_target = add(law->h_target, scale(p->wheel_momentum_target[i], law->axes[i]));
    }
    controller_planned_wheels_prepare_few(law, WHEELS_MAX + 1);
}
