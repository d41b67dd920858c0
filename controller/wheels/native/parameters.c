/* The parameters of the controller: their check, and what follows from them alone. */
#include "controller_wheels.h"
#include "reference.h"

bool controller_wheels_check(const ControllerWheelsParameters *p, Fault *f)
{
    const Named positive[] = {{"dipole_max", p->dipole_max},         {"bandwidth", p->bandwidth},
                              {"torque_share", p->torque_share},     {"momentum_share", p->momentum_share},
                              {"unloading_time", p->unloading_time}, {"command_period", p->command_period}};
    return is_reference(p->reference, f) && is_inertia(matrix(p->J_B), "J_B", f) &&
           has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) && are_rod_limits(p->rod_limits, f) &&
           are_wheels(p->wheels, p->wheel_axis, p->wheel_torque_max, p->wheel_momentum_max, f) &&
           all_positive(positive, COUNT(positive), f) && is_reference_start(p->R_d0, p->Omega_d0, f);
}

void controller_wheels_prepare(const ControllerWheelsParameters *p, ControllerWheelsLaw *law)
{
    law->p = *p;
    law->J = matrix(p->J_B);
    law->R_d0 = nearest_rotation(matrix(p->R_d0));
    law->rods_inverse = inverse(transposed(with_unit_rows(matrix(p->rod_axes))));
    for (int i = 0; i < WHEELS_MAX; ++i) {
        law->axes[i] = i < p->wheels ? unit_vector(vector(p->wheel_axis[i])) : (Vector){0.0, 0.0, 0.0};
    }
    distribute(p->wheels, law->axes, p->wheel_torque_max, law->share_of);
}
