/* The parameters of the controller: their check, and what follows from them alone. */
#include "controller_wheels.h"
#include "reference.h"

/* Share of the mean stiffness of the wheels' axes below which a direction counts as one without wheels. */
static const double REGULAR = 1e-9;

static bool are_wheels(const ControllerWheelsParameters *p, Fault *f)
{
    static const char *const axes[] = {"wheel_axis[1]", "wheel_axis[2]", "wheel_axis[3]", "wheel_axis[4]"};
    if (!(p->wheels >= 0 && p->wheels <= WHEELS_MAX)) {
        return fault(f, "wheels", p->wheels, "0 to 4");
    }
    for (int i = 0; i < p->wheels; ++i) {
        const Named positive[] = {{"wheel_torque_max", p->wheel_torque_max[i]},
                                  {"wheel_momentum_max", p->wheel_momentum_max[i]}};
        if (!is_unit_vector(vector(p->wheel_axis[i]), axes[i], f) || !all_positive(positive, COUNT(positive), f)) {
            return false;
        }
    }
    return true;
}

bool controller_wheels_check(const ControllerWheelsParameters *p, Fault *f)
{
    const Named positive[] = {{"dipole_max", p->dipole_max},         {"bandwidth", p->bandwidth},
                              {"torque_share", p->torque_share},     {"momentum_share", p->momentum_share},
                              {"unloading_time", p->unloading_time}, {"command_period", p->command_period}};
    return is_reference(p->reference, f) && is_inertia(matrix(p->J_B), "J_B", f) &&
           has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) && are_rod_limits(p->rod_limits, f) &&
           are_wheels(p, f) && all_positive(positive, COUNT(positive), f) &&
           is_reference_start(p->R_d0, p->Omega_d0, f);
}

/* Of all wheel torques that give a torque on the body the one with the least sum of (dl_i / torque_max_i)^2:
 * dl = -S^2 A^T (A S^2 A^T)^-1 tau, the axes being the columns of A. In a direction without wheels it gives nothing. */
static void distribute(ControllerWheelsLaw *law)
{
    const double *limit = law->p.wheel_torque_max;
    Matrix stiffness = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int i = 0; i < law->p.wheels; ++i) {
        const Vector a = scale(limit[i], law->axes[i]);
        stiffness = add_scaled(stiffness, 1.0, (Matrix){scale(a.x, a), scale(a.y, a), scale(a.z, a)});
    }
    const double regular = REGULAR * (stiffness.a.x + stiffness.b.y + stiffness.c.z) / 3.0;
    stiffness.a.x += regular;
    stiffness.b.y += regular;
    stiffness.c.z += regular;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        law->share_of[i] = (Vector){0.0, 0.0, 0.0};
        if (i < law->p.wheels) {
            law->share_of[i] = scale(-limit[i] * limit[i], solve(stiffness, law->axes[i]));
        }
    }
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
    distribute(law);
}
