/* Tests: tests/native/test_flavours.py. */
#include "allocator_bounded.h"

#include "box.h"
#include "rotation.h"

static const double FIELD_MIN = 1e-12;     /* T; a weaker field counts as none, and nothing is asked of the rods */
static const double ROD_WEIGHT_MIN = 1e-8; /* T; below, the preference along the field drowns in rounding */
static const double FRACTION_CAP = 1e6;    /* largest demand_fraction that is reported */

typedef struct {
    Vector dipole;   /* A m2 along the rods */
    double dh_w;     /* dl_w/dt, N m */
    double fraction; /* largest command over its limit, were there no limits */
} Commands;

bool allocator_bounded_check(const AllocatorBoundedParameters *p, Fault *f)
{
    const Named positive[] = {{"dipole_max", p->dipole_max},
                              {"wheel_torque_max", p->wheel_torque_max},
                              {"wheel_momentum_max", p->wheel_momentum_max},
                              {"command_period", p->command_period},
                              {"desaturation_time", p->desaturation_time}};
    if (!has_independent_unit_rows(matrix(p->rod_axes), "rod_axes", f) ||
        !is_unit_vector(vector(p->wheel_axis), "wheel_axis", f) || !are_rod_limits(p->rod_limits, f) ||
        !all_positive(positive, COUNT(positive), f)) {
        return false;
    }
    if (!(p->rod_weight >= ROD_WEIGHT_MIN && isfinite(p->rod_weight))) {
        return fault(f, "rod_weight", p->rod_weight, "a finite number of at least 1e-08");
    }
    const Named weights[] = {{"wheel_weight", p->wheel_weight}, {"wheel_weight_ff", p->wheel_weight_ff}};
    return all_not_negative(weights, COUNT(weights), f);
}

void allocator_bounded_prepare(const AllocatorBoundedParameters *p, AllocatorBoundedLaw *law)
{
    law->p = *p;
    store_matrix(with_unit_rows(matrix(p->rod_axes)), law->U);
    store(unit_vector(vector(p->wheel_axis)), law->axis);
}

/* The commands that give r, N m, as nearly as the limits and the preference let them: in shares of the limits,
 * minimise |A x - r|^2 + sum w_i^2 (x_i - p_i)^2. The columns of A are the torques of the actuators at their limits. */
static Commands allocate(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, const Vector rods[3],
                         Vector r, bool with_rods_ff)
{
    const AllocatorBoundedParameters *p = &law->p;
    const bool with_wheel_ff = allocator_bounded_has_wheel_torque_ff(u);
    const double h_w = u->h_w;
    const double torque_max = p->wheel_torque_max;
    const Vector limit = scale(p->dipole_max, vector(p->rod_limits));
    const Vector A[BOX_N] = {scale(limit.x, rods[0]), scale(limit.y, rods[1]), scale(limit.z, rods[2]),
                             scale(-torque_max, vector(law->axis))};
    const double wheel_weight = (with_wheel_ff ? p->wheel_weight_ff : p->wheel_weight) * torque_max;
    const double weight[BOX_N] = {p->rod_weight * limit.x, p->rod_weight * limit.y, p->rod_weight * limit.z,
                                  wheel_weight};
    const double dh_w_p = with_wheel_ff ? u->wheel_torque_ff : -h_w / p->desaturation_time;
    const Vector m_p = with_rods_ff ? vector(u->dipole_ff) : (Vector){0.0, 0.0, 0.0};
    const double preferred[BOX_N] = {m_p.x / limit.x, m_p.y / limit.y, m_p.z / limit.z, dh_w_p / torque_max};

    /* The wheel stays within its momentum over a period. Zero is always allowed, so the box is never empty. */
    const double down = larger((p->wheel_momentum_max + h_w) / p->command_period, 0.0);
    const double up = larger((p->wheel_momentum_max - h_w) / p->command_period, 0.0);
    Box box = {.low = {-1.0, -1.0, -1.0, -smaller(down / torque_max, 1.0)},
               .high = {1.0, 1.0, 1.0, smaller(up / torque_max, 1.0)}};
    for (int i = 0; i < BOX_N; ++i) {
        const double square = weight[i] * weight[i];
        box.g[i] = dot(A[i], r) + square * clip(preferred[i], box.low[i], box.high[i]);
        for (int k = 0; k < BOX_N; ++k) {
            box.H[i][k] = dot(A[i], A[k]) + (i == k ? square : 0.0);
        }
    }

    double x[BOX_N] = {0.0}, unbounded[BOX_N];
    if (!allocator_bounded_box_minimum(&box, x, unbounded)) {
        return (Commands){{0.0, 0.0, 0.0}, 0.0, FRACTION_CAP};
    }
    double fraction = 0.0;
    for (int i = 0; i < BOX_N; ++i) {
        fraction = larger(fraction, fabs(unbounded[i]));
    }
    const Vector dipole = {limit.x * x[0], limit.y * x[1], limit.z * x[2]};
    return (Commands){dipole, torque_max * x[3], smaller(fraction, FRACTION_CAP)};
}

bool allocator_bounded_outputs(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                               const AllocatorBoundedInputs *u, AllocatorBoundedOutputs *y, Fault *f)
{
    (void)x;
    const Vector tau = vector(u->tau_cmd_B), b_B = vector(u->b_B), Omega = vector(u->omega_B),
                 dipole_ff = vector(u->dipole_ff);
    const NamedVector vectors[] = {{"tau_cmd_B", tau},
                                   {"b_B", b_B},
                                   {"omega_B", Omega},
                                   {"dipole_ff", dipole_ff},
                                   {"rod_gains", vector(u->rod_gains)}};
    const Named numbers[] = {{"h_w", u->h_w}, {"wheel_torque_ff", u->wheel_torque_ff}};
    if (!all_finite_vectors(vectors, COUNT(vectors), f) || !all_finite(numbers, COUNT(numbers), f)) {
        return false;
    }

    const Matrix U = matrix(law->U);
    const double B = norm(b_B);
    const bool with_field = B >= FIELD_MIN;
    const Vector field = with_field ? b_B : (Vector){0.0, 0.0, 0.0};
    const bool with_gains = allocator_bounded_has_rod_gains(u);
    const Vector gains = with_gains ? vector(u->rod_gains) : (Vector){1.0, 1.0, 1.0};
    const Vector rods[3] = {scale(gains.x, cross(U.a, field)), scale(gains.y, cross(U.b, field)),
                            scale(gains.z, cross(U.c, field))};                       /* [16] */
    const Vector axis = vector(law->axis), spin = scale(-u->h_w, cross(Omega, axis)); /* -l_w Omega x e1 [14] */
    const bool with_rods_ff = with_field && allocator_bounded_has_dipole_ff(u);
    const Commands given = allocate(law, u, rods, subtract(tau, spin), with_rods_ff);

    const Vector dipole = {gains.x * given.dipole.x, gains.y * given.dipole.y, gains.z * given.dipole.z};
    const Vector by_rods = cross(apply_transposed(U, dipole), field);
    const Vector by_wheel = subtract(spin, scale(given.dh_w, axis));
    store(given.dipole, y->dipole_cmd);
    y->wheel_torque_cmd = given.dh_w;
    y->holding = false;
    y->demand_fraction = given.fraction;
    store(subtract(tau, add(by_rods, by_wheel)), y->tau_residual_B);
    y->b_wheel = with_field ? dot(b_B, axis) / B : 0.0;
    return true;
}

bool allocator_bounded_start(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, AllocatorBoundedState *x,
                             Fault *f)
{
    const AllocatorBoundedState now = {0.0};
    AllocatorBoundedOutputs y;
    if (!allocator_bounded_outputs(law, &now, u, &y, f)) {
        return false;
    }
    *x = now;
    return true;
}

bool allocator_bounded_step(const AllocatorBoundedLaw *law, AllocatorBoundedState *x, const AllocatorBoundedInputs *u,
                            double h, AllocatorBoundedOutputs *y, Fault *f)
{
    if (!allocator_bounded_outputs(law, x, u, y, f)) {
        return false;
    }
    x->t += h;
    return true;
}
