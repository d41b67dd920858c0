#include "controller.h"

#include "rotation.h"

static const double R_MIN = 1.0;                /* m; nearer to the Earth's centre a position has no direction */
static const double COLLINEAR = 1e-9;           /* |r x v|/(|r||v|) below which the orbit has no plane */
static const double ATTITUDE_TOLERANCE = 1e-4;  /* of R_NB: a single-precision plant stays well below it */
static const double REFERENCE_TOLERANCE = 1e-3; /* of R_d0, which may be typed from four printed decimals */
static const double PI = 3.14159265358979323846;
static const Vector zero = {0.0, 0.0, 0.0};

/* The desired motion: attitude (N from desired body), rate and its derivative in desired body axes [3]. */
typedef struct {
    Matrix R_d;
    Vector Omega_d, dOmega_d;
} Reference;

typedef struct {
    Matrix Q;
    double angle; /* |zeta| */
    Vector omega;
    Vector Omega_d_B, dOmega_d_B; /* Q^T Omega_d and Q^T dOmega_d/dt */
} Errors;

typedef struct {
    double value, slope;
} Phi;

bool controller_check(const ControllerParameters *p, Fault *f)
{
    const Named positive[] = {
        {"phi_scale", p->phi_scale},
        {"gravitational_parameter", p->gravitational_parameter},
        {"kappa0", p->kappa0},
        {"lambda0", p->lambda0},
        {"a1", p->a1},
        {"a2", p->a2},
        {"c1", p->c1},
        {"c2", p->c2},
    };
    if (!all_positive(positive, COUNT(positive), f)) {
        return false;
    }
    if (p->phi < CONTROLLER_PHI_LINEAR || p->phi > CONTROLLER_PHI_SQUARE_ROOT) {
        return fault(f, "phi", p->phi, "1 (linear), 2 (logarithm) or 3 (square_root)");
    }
    if (p->gain_schedule < CONTROLLER_GAIN_SCHEDULE_ERROR || p->gain_schedule > CONTROLLER_GAIN_SCHEDULE_CONSTANT) {
        return fault(f, "gain_schedule", p->gain_schedule, "1 (error) or 2 (constant)");
    }
    if (p->reference < CONTROLLER_REFERENCE_LVLH || p->reference > CONTROLLER_REFERENCE_RATE) {
        return fault(f, "reference", p->reference, "1 (lvlh), 2 (inertial) or 3 (rate)");
    }
    if (!is_inertia(matrix(p->J_B), "J_B", f) || !is_positive_definite(matrix(p->L0), "L0", f) || !is_ascending(p->K0, f)) {
        return false;
    }
    return all_finite_vectors(&(NamedVector){"Omega_d0", vector(p->Omega_d0)}, 1, f) &&
           is_rotation(matrix(p->R_d0), REFERENCE_TOLERANCE, "R_d0", "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001",
                       f);
}

void controller_prepare(const ControllerParameters *p, ControllerLaw *law)
{
    law->p = *p;
    store_matrix(nearest_rotation(matrix(p->R_d0)), law->R_d0);
}

/* LVLH: Z to nadir, Y = -orbit normal, X = Y x Z; any orbit, not only a circle: n = |r x v|/r^2, and since |r x v|
 * is constant dn/dt = -2 n (r.v)/r^2. */
static bool lvlh(Vector r_N, Vector v_N, Reference *reference, Fault *f)
{
    const double r = norm(r_N);
    const double h = norm(cross(r_N, v_N));
    if (r < R_MIN) {
        return fault(f, "r_N", r, "at least 1 m from the Earth's centre, for the reference 'lvlh'");
    }
    if (!(h > COLLINEAR * r * norm(v_N))) {
        return fault(f, "v_N", h,
                     "a velocity that spans the orbit's plane with r_N, |r x v| above 0, for the reference 'lvlh'");
    }
    const double n = h / (r * r);
    const double dn = -2.0 * n * dot(r_N, v_N) / (r * r);
    reference->R_d = lvlh_axes(r_N, v_N);
    reference->Omega_d = (Vector){0.0, -n, 0.0};
    reference->dOmega_d = (Vector){0.0, -dn, 0.0};
    return true;
}

static bool desired(const ControllerLaw *law, double t, const ControllerInputs *u, Reference *reference, Fault *f)
{
    const Matrix R_d0 = matrix(law->R_d0);
    const Vector Omega_d0 = vector(law->p.Omega_d0);
    switch (law->p.reference) {
    case CONTROLLER_REFERENCE_LVLH:
        return lvlh(vector(u->r_N), vector(u->v_N), reference, f);
    case CONTROLLER_REFERENCE_RATE:
        *reference = (Reference){multiply(R_d0, rotation_exp(scale(t, Omega_d0))), Omega_d0, zero};
        return true;
    default:
        *reference = (Reference){R_d0, zero, zero};
        return true;
    }
}

static bool inputs_finite(const ControllerInputs *u, Fault *f)
{
    const NamedVector inputs[] = {{"omega_B", vector(u->omega_B)}, {"r_N", vector(u->r_N)}, {"v_N", vector(u->v_N)}};
    return all_finite_vectors(inputs, COUNT(inputs), f);
}

/* Q = R_d^T R = exp(zeta^), omega = Omega - Q^T Omega_d [4]. */
static bool tracking_errors(const ControllerLaw *law, double t, const ControllerInputs *u, Errors *e, Fault *f)
{
    if (!inputs_finite(u, f)) {
        return false;
    }
    const Matrix R = matrix(u->R_NB);
    Reference reference;
    if (!is_rotation(R, ATTITUDE_TOLERANCE, "R_NB", "a rotation matrix, max |R_NB^T R_NB - I| at most 0.0001", f) ||
        !desired(law, t, u, &reference, f)) {
        return false;
    }
    e->Q = multiply(transposed(reference.R_d), R);
    e->angle = principal_angle(e->Q);
    e->Omega_d_B = apply_transposed(e->Q, reference.Omega_d);
    e->dOmega_d_B = apply_transposed(e->Q, reference.dOmega_d);
    e->omega = subtract(vector(u->omega_B), e->Omega_d_B);
    return true;
}

/* Phi(x) and Phi'(x); x below 0 can only be rounding. */
static Phi phi_of(const ControllerParameters *p, double x)
{
    x = larger(x, 0.0);
    const double stretch = 1.0 + x / p->phi_scale;
    if (p->phi == CONTROLLER_PHI_LOGARITHM) {
        return (Phi){p->phi_scale * log1p(x / p->phi_scale), 1.0 / stretch};
    }
    if (p->phi == CONTROLLER_PHI_SQUARE_ROOT) {
        return (Phi){2.0 * x / (sqrt(stretch) + 1.0), 1.0 / sqrt(stretch)};
    }
    return (Phi){x, 1.0};
}

/* M_g = 3 mu/r^3 r_B x J r_B, at R_d Q = R. */
static bool gravity_gradient(const ControllerLaw *law, const ControllerInputs *u, Matrix J, Vector *M_g, Fault *f)
{
    const Vector r_N = vector(u->r_N);
    const double r = norm(r_N);
    if (r < R_MIN) {
        return fault(f, "r_N", r, "at least 1 m from the Earth's centre, for compensate_gravity");
    }
    const Vector r_B = scale(1.0 / r, apply_transposed(matrix(u->R_NB), r_N));
    *M_g = scale(3.0 * law->p.gravitational_parameter / (r * r * r), cross(r_B, apply(J, r_B)));
    return true;
}

/* Whether there is none yet: a matrix of zeros, as simple masters give before the first value. */
static bool no_attitude(const ControllerState *x, const ControllerInputs *u)
{
    return !x->flown && is_zero_matrix(matrix(u->R_NB));
}

/* |zeta(0)| and |omega(0)| of the inputs at x->t, where none are latched. */
static bool latch(const ControllerLaw *law, const ControllerInputs *u, ControllerState *x, Fault *f)
{
    Errors e;
    if (x->latched) {
        return true;
    }
    if (!tracking_errors(law, x->t, u, &e, f)) {
        return false;
    }
    *x = (ControllerState){x->t, e.angle, norm(e.omega), true, x->flown};
    return true;
}

bool controller_start(const ControllerLaw *law, const ControllerInputs *u, ControllerState *x, Fault *f)
{
    *x = (ControllerState){0.0, 0.0, 0.0, false, false};
    return no_attitude(x, u) ? inputs_finite(u, f) : latch(law, u, x, f);
}

bool controller_outputs(const ControllerLaw *law, const ControllerState *x, const ControllerInputs *u, ControllerOutputs *y,
                        Fault *f)
{
    const ControllerParameters *p = &law->p;
    const Matrix J = matrix(p->J_B);
    Errors e;
    Vector M_g = zero;
    if (no_attitude(x, u)) {
        *y = (ControllerOutputs){.attitude_error = PI, .no_attitude = true};
        store(vector(u->omega_B), y->rate_error_B);
        return inputs_finite(u, f);
    }
    ControllerState now = *x;
    if (!latch(law, u, &now, f) || !tracking_errors(law, x->t, u, &e, f) ||
        (p->compensate_gravity && !gravity_gradient(law, u, J, &M_g, f))) {
        return false;
    }

    /* K = k K0, L = l L0 [9], with k and l by [10]. */
    const bool scheduled = p->gain_schedule == CONTROLLER_GAIN_SCHEDULE_ERROR;
    const double k = scheduled ? p->kappa0 * (p->a1 + e.angle) / (p->a2 + now.attitude_error_0) : p->kappa0;
    const double l = scheduled ? p->lambda0 * (p->c1 + norm(e.omega)) / (p->c2 + now.rate_error_0) : p->lambda0;
    const Vector K = scale(k, vector(p->K0));

    /* sum k_i e_i x Q^T e_i [7]; Q^T e_i is row i of Q. */
    const Vector gradient = {K.y * e.Q.b.z - K.z * e.Q.c.y, K.z * e.Q.c.x - K.x * e.Q.a.z, K.x * e.Q.a.y - K.y * e.Q.b.x};
    const Phi phi = phi_of(p, dot(K, (Vector){1.0 - e.Q.a.x, 1.0 - e.Q.b.y, 1.0 - e.Q.c.z}));

    /* [8], with M_ad = 0: the law knows no drag. */
    const Vector damping = scale(-l, apply(matrix(p->L0), e.omega));
    const Vector acceleration = apply(J, e.dOmega_d_B);
    const Vector gyroscopic = cross(e.Omega_d_B, apply(J, e.Omega_d_B));
    const Vector attitude = scale(phi.slope, gradient);
    store(subtract(add(add(damping, acceleration), add(gyroscopic, attitude)), M_g), y->tau_cmd_B);

    y->attitude_error = e.angle;
    store(e.omega, y->rate_error_B);
    y->lyapunov = 0.5 * dot(e.omega, apply(J, e.omega)) + phi.value; /* [11] */
    y->gain_k = k;
    y->gain_l = l;
    y->no_attitude = false;
    return true;
}

bool controller_step(const ControllerLaw *law, ControllerState *x, const ControllerInputs *u, double h, ControllerOutputs *y,
                     Fault *f)
{
    ControllerState next = *x;
    next.t = x->t + h;
    next.latched = x->latched && !no_attitude(x, u);
    next.flown = !no_attitude(x, u);
    if ((next.flown && !latch(law, u, &next, f)) || !controller_outputs(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
