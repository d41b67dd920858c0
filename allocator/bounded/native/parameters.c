/* The parameters of the allocator: their check, and what follows from them alone. Of a set, rods and wheels that are
 * not there are not checked. Tests: tests/native/test_allocator_wheels.py. */
#include "actuators.h"
#include "rotation.h"

static const double ROD_WEIGHT_MIN = 1e-8;   /* T; below, the preference along the field drowns in rounding */
static const double WHEEL_WEIGHT_MIN = 1e-4; /* of several wheels; below, their null space drowns in rounding */

#if ALLOCATOR_BOUNDED_WHEELS > 1
#define OF_EACH(name) {name "[1]", name "[2]", name "[3]", name "[4]"}
#else
#define OF_EACH(name) {name}
#endif

static bool are_rods(const AllocatorBoundedParameters *p, Fault *f)
{
    static const char *const axes[] = {"rod_axes[1]", "rod_axes[2]", "rod_axes[3]"};
    if (!(RODS(p) >= 0 && RODS(p) <= 3)) {
        return fault(f, "rods", RODS(p), "0 to 3");
    }
    if (RODS(p) == 3) {
        return has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f);
    }
    for (int i = 0; i < RODS(p); ++i) {
        if (!is_unit_vector(vector(p->rod_axes[i]), axes[i], f)) {
            return false;
        }
    }
    return true;
}

#if ALLOCATOR_BOUNDED_WHEELS > 1
#define IS_INERTIA(p, f) (is_zero_matrix(matrix((p)->J_B)) || is_inertia(matrix((p)->J_B), "J_B", f))
#else
#define IS_INERTIA(p, f) true
#endif

static bool are_wheels(const AllocatorBoundedParameters *p, Fault *f)
{
    static const char *const axes[] = OF_EACH("wheel_axis");
    if (!(WHEELS(p) >= 0 && WHEELS(p) <= ALLOCATOR_BOUNDED_WHEELS)) {
        return fault(f, "wheels", WHEELS(p), "0 to 4");
    }
    for (int i = 0; i < WHEELS(p); ++i) {
        const Named positive[] = {{"wheel_torque_max", p->wheel_torque_max[i]},
                                  {"wheel_momentum_max", p->wheel_momentum_max[i]}};
        if (!is_unit_vector(vector(p->wheel_axis[i]), axes[i], f) || !all_positive(positive, COUNT(positive), f)) {
            return false;
        }
        if (!(fabs(WHEEL_TARGET(p, i)) <= p->wheel_momentum_max[i])) {
            return fault(f, "wheel_momentum_target", WHEEL_TARGET(p, i), "within wheel_momentum_max");
        }
        if (!(2.0 * NULL_SPACE_MOMENTUM(p) <= p->wheel_momentum_max[i])) {
            return fault(f, "null_space_momentum", NULL_SPACE_MOMENTUM(p), "at most half of each wheel_momentum_max");
        }
    }
    return true;
}

bool allocator_bounded_check(const AllocatorBoundedParameters *p, Fault *f)
{
    const Named positive[] = {{"dipole_max", p->dipole_max},
                              {"command_period", p->command_period},
                              {"desaturation_time", p->desaturation_time}};
    if (!are_rods(p, f) || !are_wheels(p, f) || !IS_INERTIA(p, f) || !are_rod_limits(p->rod_limits, f) ||
        !all_positive(positive, COUNT(positive), f)) {
        return false;
    }
    if (!(p->rod_weight >= ROD_WEIGHT_MIN && isfinite(p->rod_weight))) {
        return fault(f, "rod_weight", p->rod_weight, "a finite number of at least 1e-08");
    }
    const Named weights[] = {{"wheel_weight", p->wheel_weight}, {"wheel_weight_ff", p->wheel_weight_ff}};
    for (size_t i = 0; i < COUNT(weights) && WHEELS(p) > 1; ++i) {
        if (!(weights[i].value >= WHEEL_WEIGHT_MIN)) {
            return fault(f, weights[i].name, weights[i].value, "at least 0.0001 with several wheels");
        }
    }
    return all_not_negative(weights, COUNT(weights), f);
}

/* The torques of four wheels that cancel on the body, a unit vector: of each wheel the volume of the others' axes. */
static void find_null_space(AllocatorBoundedLaw *law)
{
    law->has_null_space = false;
#if ALLOCATOR_BOUNDED_WHEELS > 1
    double square = 0.0;
    for (int i = 0; i < 4; ++i) {
        const Matrix others = {vector(law->axis[i < 1 ? 1 : 0]), vector(law->axis[i < 2 ? 2 : 1]),
                               vector(law->axis[i < 3 ? 3 : 2])};
        law->null_space[i] = i % 2 == 0 ? determinant(others) : -determinant(others);
        square += law->null_space[i] * law->null_space[i];
    }
    law->has_null_space = law->p.wheels == 4 && square > 1e-12; /* else the axes lie in one plane */
    for (int i = 0; i < 4 && law->has_null_space; ++i) {
        law->null_space[i] /= sqrt(square);
    }
#endif
}

void allocator_bounded_prepare(const AllocatorBoundedParameters *p, AllocatorBoundedLaw *law)
{
    const double any[3] = {1.0, 0.0, 0.0}; /* of a part that is not there */
    law->p = *p;
    for (int i = 0; i < 3; ++i) {
        store(unit_vector(vector(i < RODS(p) ? p->rod_axes[i] : any)), law->U[i]);
    }
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        store(unit_vector(vector(i < WHEELS(p) ? p->wheel_axis[i] : any)), law->axis[i]);
    }
    find_null_space(law);
}
