/* Requirements: AL-1, AL-2. Tests: tests/native/test_flavours.py. */
#include "allocator.h"

#include "allocator_guard.h"
#include "rotation.h"

static const double FIELD_MIN = 1e-12;  /* T; a weaker field has no direction to allocate by */
static const double B_WHEEL_MIN = 1e-9; /* |b1| below which [20] divides by rounding errors */
static const double RANK_MIN = 1e-12;   /* det(A^T A) below which the rods span only a line across the field */
static const double ACROSS_MIN = 1e-3;  /* share of the demand across the field; a smaller one has rounding errors */
static const double FRACTION_CAP = 1e6; /* largest demand over limit that is reported */

typedef struct {
    Vector dipole; /* A m2 along the rods */
    double dh_w;   /* dl_w/dt, N m */
} Commands;

bool allocator_check(const AllocatorParameters *p, Fault *f)
{
    const Named limits[] = {{"dipole_max", p->dipole_max},
                            {"wheel_torque_max", p->wheel_torque_max},
                            {"wheel_momentum_max", p->wheel_momentum_max}};
    if (!has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) ||
        !is_unit_vector(vector(p->wheel_axis), "wheel_axis", f) || !all_positive(limits, COUNT(limits), f)) {
        return false;
    }
    if (!(p->hold_fraction > 0.0 && p->hold_fraction <= 1.0)) {
        return fault(f, "hold_fraction", p->hold_fraction, "above 0 and at most 1");
    }
    return true;
}

void allocator_prepare(const AllocatorParameters *p, AllocatorLaw *law)
{
    law->p = *p;
    store_matrix(with_unit_rows(matrix(p->rod_axes)), law->U);
    store(unit_vector(vector(p->wheel_axis)), law->axis);
}

/* tau_RW = -(dl_w/dt e1 + l_w Omega x e1) [14], N m on the body. */
static Vector wheel_reaction(Vector axis, double dh_w, double h_w, Vector Omega)
{
    return subtract(scale(-dh_w, axis), scale(h_w, cross(Omega, axis)));
}

/* Some vector across the field: the demand's own part [21], or, where it has none, that of the body axis most nearly
 * across. The least-norm dipole does not depend on the basis. */
static Vector across_field(Vector tau, Vector b)
{
    const Vector across = subtract(tau, scale(dot(tau, b), b));
    if (norm(across) > ACROSS_MIN * norm(tau)) {
        return across;
    }
    const double x = fabs(b.x), y = fabs(b.y), z = fabs(b.z);
    const Vector axis = x <= y && x <= z ? (Vector){1.0, 0.0, 0.0}
                        : y <= z         ? (Vector){0.0, 1.0, 0.0}
                                         : (Vector){0.0, 0.0, 1.0};
    return subtract(axis, scale(dot(axis, b), b));
}

/* Commands that together give tau on the body, no limit acting; false where the allocation is singular. */
static bool allocate(const AllocatorLaw *law, const AllocatorInputs *u, Commands *commands)
{
    const Matrix U = matrix(law->U);
    const Vector axis = vector(law->axis), tau = vector(u->tau_cmd_B), b_B = vector(u->b_B), Omega = vector(u->omega_B);
    const double B = norm(b_B);
    if (B < FIELD_MIN) {
        return false;
    }
    const Vector b = direction(B, b_B);

    /* Wheel: the demand's part along the field [20]. Normal to the wheel, it can only give nothing. */
    const Vector spin = scale(u->h_w, cross(Omega, axis));
    const double along = dot(tau, b) + spin.x * b.x + spin.y * b.y + spin.z * b.z, b_wheel = dot(b, axis);
    double dh_w = 0.0;
    if (along != 0.0) {
        if (b_wheel < B_WHEEL_MIN && b_wheel > -B_WHEEL_MIN) {
            return false;
        }
        dh_w = -along / b_wheel;
    }

    /* Rods: the rest, which lies across the field, with the least dipole [24]. */
    const Vector tau_MT = subtract(tau, wheel_reaction(axis, dh_w, u->h_w, Omega));
    const Vector across = across_field(tau, b);
    const double size = norm(across);
#ifdef PROOF_WITHIN_LIMITS
    //@ assert across: size >= 0x1p-537;
#endif
    const Vector n = direction(size, across);
    const Vector c = cross(b, n);
    /* Columns of A = M_B^T N_p [22]: (u_i x b).n = u_i.c and (u_i x b).c = -u_i.n. */
    const Vector A_n = apply(U, c);
    const Vector A_c = scale(-1.0, apply(U, n));
    const double nn = dot(A_n, A_n), nc = dot(A_n, A_c), cc = dot(A_c, A_c);
    const double det = nn * cc - nc * nc;
    if (det < RANK_MIN) {
        return false;
    }
    const double t_n = dot(n, tau_MT), t_c = dot(c, tau_MT);
    const double y_n = (cc * t_n - nc * t_c) / (B * det);
    const double y_c = (nn * t_c - nc * t_n) / (B * det);
    commands->dipole = add(scale(y_n, A_n), scale(y_c, A_c));
    commands->dh_w = dh_w;
    return true;
}

/* Largest demand of an actuator over its limit, at most the cap. */
static double demand_fraction(const Commands *wanted, const AllocatorParameters *p)
{
    if (!is_finite(wanted->dipole)) { /* so are the dipoles where dh_w is not */
        return FRACTION_CAP;
    }
    const double fraction = larger(largest(wanted->dipole) / p->dipole_max, fabs(wanted->dh_w) / p->wheel_torque_max);
    return smaller(fraction, FRACTION_CAP);
}

/* Torque on the body once each actuator has met its limits; the motor gives nothing past wheel_momentum_max. */
static Vector achieved(const AllocatorLaw *law, const AllocatorInputs *u, const Commands *given)
{
    const AllocatorParameters *p = &law->p;
    const double limit = p->dipole_max;
    const Vector dipole = {clip(given->dipole.x, -limit, limit), clip(given->dipole.y, -limit, limit),
                           clip(given->dipole.z, -limit, limit)};
    double dh_w = clip(given->dh_w, -p->wheel_torque_max, p->wheel_torque_max);
    if (fabs(u->h_w) >= p->wheel_momentum_max && dh_w * u->h_w > 0.0) {
        dh_w = 0.0;
    }
    const Vector rods = cross(apply_transposed(matrix(law->U), dipole), vector(u->b_B)); /* [16] to [18] */
    return add(rods, wheel_reaction(vector(law->axis), dh_w, u->h_w, vector(u->omega_B)));
}

/*@ requires \separated(x, y, f);
    ALLOCATOR_FINITE */
bool allocator_outputs(const AllocatorLaw *law, const AllocatorState *x, const AllocatorInputs *u, AllocatorOutputs *y,
                       Fault *f)
{
    const NamedVector inputs[] = {
        {"tau_cmd_B", vector(u->tau_cmd_B)}, {"b_B", vector(u->b_B)}, {"omega_B", vector(u->omega_B)}};
    const Named h_w = {"h_w", u->h_w};
    if (!all_finite_vectors(inputs, COUNT(inputs), f) || !all_finite(&h_w, 1, f)) {
        return false;
    }

    Commands wanted = {{0.0, 0.0, 0.0}, 0.0};
    const bool regular = allocate(law, u, &wanted);
    const double fraction = regular ? demand_fraction(&wanted, &law->p) : FRACTION_CAP;
    const bool holding = !(fraction < law->p.hold_fraction);
    const Commands held = {vector(x->dipole), x->wheel_torque};
    const Commands given = holding ? held : wanted;

    const Vector b_B = vector(u->b_B);
    const double B = norm(b_B);
    store(given.dipole, y->dipole_cmd);
    y->wheel_torque_cmd = given.dh_w;
    y->holding = holding;
    y->demand_fraction = fraction;
    store(subtract(vector(u->tau_cmd_B), achieved(law, u, &given)), y->tau_residual_B);
    y->b_wheel = B < FIELD_MIN ? 0.0 : dot(b_B, vector(law->axis)) / B;
    return allocator_guard(y, f);
}

/*@ assigns \nothing; */
static AllocatorState remember(double t, const AllocatorOutputs *y)
{
    return (AllocatorState){t, {y->dipole_cmd[0], y->dipole_cmd[1], y->dipole_cmd[2]}, y->wheel_torque_cmd, y->holding};
}

bool allocator_start(const AllocatorLaw *law, const AllocatorInputs *u, AllocatorState *x, Fault *f)
{
    const AllocatorState nothing_yet = {0.0, {0.0, 0.0, 0.0}, 0.0, false};
    AllocatorOutputs y;
    if (!allocator_outputs(law, &nothing_yet, u, &y, f)) {
        return false;
    }
    *x = remember(0.0, &y);
    return true;
}

/*@ requires \separated(x, y, f);
    ALLOCATOR_FINITE */
bool allocator_step(const AllocatorLaw *law, AllocatorState *x, const AllocatorInputs *u, double h, AllocatorOutputs *y,
                    Fault *f)
{
    if (!allocator_outputs(law, x, u, y, f)) {
        return false;
    }
    *x = remember(x->t + h, y);
    return true;
}
