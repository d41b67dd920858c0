/* Requirements: AB-1, AB-2. Tests: tests/native/test_flavours.py. */
#include "allocator_bounded.h"

#include "allocator_bounded_guard.h"
#include <string.h>

#include "actuators.h"
#include "rotation.h"

static const double FIELD_MIN = 1e-12;  /* T; a weaker field counts as none, and nothing is asked of the rods */
static const double FRACTION_CAP = 1e6; /* largest demand_fraction that is reported */

typedef struct {
    double dipole[3];                      /* A m2 along the rods */
    double dh_w[ALLOCATOR_BOUNDED_WHEELS]; /* dl_w/dt, N m */
    double fraction;                       /* largest command over its limit, were there no limits */
} Commands;

/* The commands that give r, N m, as nearly as the limits and the preference let them: in shares of the limits,
 * minimise |A x - r|^2 + sum w_i^2 (x_i - p_i)^2. The columns of A are the torques of the actuators at their limits. */
static Commands allocate(const Actuators *a, Vector r)
{
    Commands given = {.fraction = FRACTION_CAP};
    Box box;
    (void)memset(&box, 0, sizeof box);
    box.n = a->n;
    for (int i = 0; i < a->n; ++i) {
        const double square = a->weight[i] * a->weight[i];
        box.low[i] = a->low[i];
        box.high[i] = a->high[i];
        box.g[i] = dot(a->torque[i], r) + square * clip(a->preferred[i], box.low[i], box.high[i]);
        for (int k = 0; k < a->n; ++k) {
            box.H[i][k] = dot(a->torque[i], a->torque[k]) + (i == k ? square : 0.0);
        }
    }
    double x[BOX_N] = {0.0}, unbounded[BOX_N] = {0.0};
    if (!allocator_bounded_box_minimum(&box, x, unbounded)) {
        return given;
    }
    double fraction = 0.0;
    for (int i = 0; i < a->n; ++i) {
        //@ assert share: \is_finite(x[i]) && -1.0 <= x[i] <= 1.0;
        fraction = larger(fraction, fabs(unbounded[i]));
    }
    for (int i = 0; i < a->rods; ++i) {
        given.dipole[i] = a->limit[i] * x[i];
    }
    for (int k = 0; k < a->wheels; ++k) {
        given.dh_w[k] = a->limit[a->rods + k] * x[a->rods + k];
    }
    given.fraction = smaller(fraction, FRACTION_CAP);
    //@ assert fraction: \is_finite(given.fraction);
    return given;
}

/* Whether all inputs are finite. */
static bool are_inputs(const AllocatorBoundedInputs *u, Fault *f)
{
    const NamedVector vectors[] = {{"tau_cmd_B", vector(u->tau_cmd_B)},
                                   {"b_B", vector(u->b_B)},
                                   {"omega_B", vector(u->omega_B)},
                                   {"dipole_ff", vector(u->dipole_ff)},
                                   {"rod_gains", vector(u->rod_gains)}};
    if (!all_finite_vectors(vectors, COUNT(vectors), f)) {
        return false;
    }
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        const Named numbers[] = {
            {"h_w", u->h_w[i]},
            {"wheel_torque_ff", u->wheel_torque_ff[i]},
#if ALLOCATOR_BOUNDED_WHEELS > 1
            {"wheel_gains", u->wheel_gains[i]},
#endif
        };
        if (!all_finite(numbers, COUNT(numbers), f)) {
            return false;
        }
    }
    return true;
}

static bool outputs_of(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, const AllocatorBoundedInputs *u,
                       AllocatorBoundedOutputs *y, Fault *f)
{
    if (!are_inputs(u, f)) {
        return false;
    }
    const Vector tau = vector(u->tau_cmd_B), b_B = vector(u->b_B), Omega = vector(u->omega_B);
    const Matrix U = matrix(law->U);
    const double B = norm(b_B);
    const bool with_field = B >= FIELD_MIN;
    const Vector field = with_field ? b_B : (Vector){0.0, 0.0, 0.0};
    const bool with_gains = allocator_bounded_has_rod_gains(u);
    const Vector gains = with_gains ? vector(u->rod_gains) : (Vector){1.0, 1.0, 1.0};
    const Vector rods[3] = {scale(gains.x, cross(U.a, field)), scale(gains.y, cross(U.b, field)),
                            scale(gains.z, cross(U.c, field))}; /* [16] */
    Vector spin = {0.0, 0.0, 0.0};
    for (int i = 0; i < WHEELS(&law->p); ++i) {
        spin = subtract(
            spin, scale(WHEEL_MOMENTUM(law, x, u, i), cross(Omega, vector(law->axis[i])))); /* -l_w Omega x e1 [14] */
#if ALLOCATOR_BOUNDED_WHEELS > 1
        spin = subtract(spin, scale(allocator_bounded_by_trial(law, x, u, i), vector(law->axis[i])));
#endif
    }
    Actuators actuators;
    allocator_bounded_actuators(law, x, u, rods, with_field && allocator_bounded_has_dipole_ff(u), &actuators);
    const Commands given = allocate(&actuators, subtract(tau, spin));

    const Vector dipole = {gains.x * given.dipole[0], gains.y * given.dipole[1], gains.z * given.dipole[2]};
    const Vector by_rods = cross(apply_transposed(U, dipole), field);
    Vector by_wheels = spin;
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        const Vector axis = vector(law->axis[i]);
        by_wheels = subtract(by_wheels, scale(WHEEL_GAIN(law, x, u, i) * given.dh_w[i], axis));
        y->wheel_torque_cmd[i] = given.dh_w[i];
        y->b_wheel[i] = i < WHEELS(&law->p) && with_field ? dot(b_B, axis) / B : 0.0;
#if ALLOCATOR_BOUNDED_WHEELS > 1
        y->wheel_torque_cmd[i] = allocator_bounded_with_friction(law, x, u, i, given.dh_w[i]);
        y->wheel_failed[i] = allocator_bounded_wheel_failed(law, x, i);
        y->wheel_reversed[i] = allocator_bounded_wheel_reversed(law, x, i);
        y->h_w_failed[i] = law->p.find_failures && x->telemetry[i].frozen;
        y->h_w_estimate[i] = x->expected[i];
#endif
    }
    store(vector(given.dipole), y->dipole_cmd);
    y->holding = false;
    y->demand_fraction = given.fraction;
    store(subtract(tau, add(by_rods, by_wheels)), y->tau_residual_B);
    return true;
}

/*@ requires \separated(x, y, f);
    ALLOCATOR_BOUNDED_FINITE */
bool allocator_bounded_outputs(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                               const AllocatorBoundedInputs *u, AllocatorBoundedOutputs *y, Fault *f)
{
    return outputs_of(law, x, u, y, f) && allocator_bounded_guard(y, f);
}

bool allocator_bounded_start(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, AllocatorBoundedState *x,
                             Fault *f)
{
    AllocatorBoundedState now = {.t = 0.0};
    AllocatorBoundedOutputs y;
    if (!allocator_bounded_outputs(law, &now, u, &y, f)) {
        return false;
    }
#if ALLOCATOR_BOUNDED_WHEELS > 1
    allocator_bounded_begin(law, u, &y, &now);
#endif
    *x = now;
    return true;
}

/*@ requires \separated(x, y, f);
    ALLOCATOR_BOUNDED_FINITE */
bool allocator_bounded_step(const AllocatorBoundedLaw *law, AllocatorBoundedState *x, const AllocatorBoundedInputs *u,
                            double h, AllocatorBoundedOutputs *y, Fault *f)
{
    const AllocatorBoundedState before = *x;
#if ALLOCATOR_BOUNDED_WHEELS > 1
    allocator_bounded_watch(law, u, h, x);
#endif
    bool ok = outputs_of(law, x, u, y, f);
    if (ok) {
#if ALLOCATOR_BOUNDED_WHEELS > 1
        allocator_bounded_keep(law, u, y, x);
#endif
        x->t += h;
        ok = allocator_bounded_guard(y, f);
    }
    if (!ok) {
        *x = before;
    }
    return ok;
}
