/* Requirements: CT-1, CT-2, CT-3. Tests: tests/native/test_flavours.py. */
#include "controller.h"

#include "controller_guard.h"
#include "reference.h"

static const Vector zero = {0.0, 0.0, 0.0};

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
    return is_reference(p->reference, f) && is_inertia(matrix(p->J_B), "J_B", f) &&
           is_positive_definite(matrix(p->L0), "L0", f) && is_ascending(p->K0, f) &&
           is_reference_start(p->R_d0, p->Omega_d0, f);
}

void controller_prepare(const ControllerParameters *p, ControllerLaw *law)
{
    law->p = *p;
    store_matrix(nearest_rotation(matrix(p->R_d0)), law->R_d0);
}

/* Whether the inputs have numbers, and all of a reference or nothing of it. */
static bool inputs_fit(const ControllerInputs *u, Fault *f)
{
    static const char *const all = "to be connected: connect R_ref, Omega_ref and dOmega_ref, or none of them";
    const NamedVector given[] = {{"R_ref", vector(u->R_ref[0])},
                                 {"R_ref", vector(u->R_ref[1])},
                                 {"R_ref", vector(u->R_ref[2])},
                                 {"Omega_ref", vector(u->Omega_ref)},
                                 {"dOmega_ref", vector(u->dOmega_ref)}};
    const bool attitude = controller_has_R_ref(u), rate = controller_has_Omega_ref(u),
               change = controller_has_dOmega_ref(u);
    if (!are_finite_rate_and_orbit(u->omega_B, u->r_N, u->v_N, f) || !all_finite_vectors(given, COUNT(given), f)) {
        return false;
    }
    if (attitude != rate || rate != change) {
        const char *missing = !attitude ? "R_ref" : !rate ? "Omega_ref" : "dOmega_ref";
        return fault(f, missing, CONTROLLER_ABSENT_MIN, all);
    }
    return true;
}

/* The reference of the inputs where it is connected, else what the parameter `reference` says. */
static bool desired(const ControllerLaw *law, double t, const ControllerInputs *u, Reference *reference, Fault *f)
{
    if (!controller_has_R_ref(u)) {
        return reference_at(law->p.reference, matrix(law->R_d0), vector(law->p.Omega_d0), t, vector(u->r_N),
                            vector(u->v_N), reference, f);
    }
    *reference = (Reference){matrix(u->R_ref), vector(u->Omega_ref), vector(u->dOmega_ref)};
    return is_rotation(reference->R_d, REFERENCE_ATTITUDE_TOLERANCE, "R_ref",
                       "a rotation matrix, max |R_ref^T R_ref - I| at most 0.0001, or zeros", f);
}

/* Q = R_d^T R = exp(zeta^), omega = Omega - Q^T Omega_d [4]. */
static bool tracking_errors(const ControllerLaw *law, double t, const ControllerInputs *u, Errors *e, Fault *f)
{
    const Matrix R = matrix(u->R_NB);
    Reference reference;
    if (!is_attitude(R, f) || !desired(law, t, u, &reference, f)) {
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
    if (r < REFERENCE_R_MIN) {
        return fault(f, "r_N", r, "at least 1 m from the Earth's centre, for compensate_gravity");
    }
    const Vector r_B = scale(1.0 / r, apply_transposed(matrix(u->R_NB), r_N));
    *M_g = scale(3.0 * law->p.gravitational_parameter / (r * r * r), cross(r_B, apply(J, r_B)));
    return true;
}

/* Whether there is none: a matrix of zeros, as simple masters give before the first value. Once flown, only where a
 * reference is connected: who gives it knows of an attitude that is lost. */
static bool no_attitude(const ControllerState *x, const ControllerInputs *u)
{
    return is_zero_matrix(matrix(u->R_NB)) && (!x->flown || controller_has_R_ref(u));
}

/* Whether attitude or reference is missing. */
static bool damps_only(const ControllerState *x, const ControllerInputs *u)
{
    return no_attitude(x, u) || is_zero_matrix(matrix(u->R_ref));
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

/* tau = -L omega with |omega(0)| = |omega| in [10]; the error of attitude is unknown, and given as the largest.
 * omega is the rate, less the one that is asked for where only the attitude of the reference is missing. */
static void damp(const ControllerParameters *p, const ControllerInputs *u, ControllerOutputs *y)
{
    const Vector wanted = is_zero_matrix(matrix(u->R_ref)) ? vector(u->Omega_ref) : zero;
    const Vector omega = subtract(vector(u->omega_B), wanted);
    const double rate = norm(omega);
    const bool scheduled = p->gain_schedule == CONTROLLER_GAIN_SCHEDULE_ERROR;
    y->gain_k = 0.0;
    y->gain_l = scheduled ? p->lambda0 * (p->c1 + rate) / (p->c2 + rate) : p->lambda0;
    y->attitude_error = REFERENCE_NO_ATTITUDE;
    y->lyapunov = 0.5 * dot(omega, apply(matrix(p->J_B), omega));
    store(omega, y->rate_error_B);
    store(scale(-y->gain_l, apply(matrix(p->L0), omega)), y->tau_cmd_B);
}

bool controller_start(const ControllerLaw *law, const ControllerInputs *u, ControllerState *x, Fault *f)
{
    *x = (ControllerState){0.0, 0.0, 0.0, false, false};
    return inputs_fit(u, f) && (damps_only(x, u) || latch(law, u, x, f));
}

/* Of inputs that fit. */
/*@ requires \separated(y, f);
    CONTROLLER_FINITE */
static bool outputs_of(const ControllerLaw *law, const ControllerState *x, const ControllerInputs *u,
                       ControllerOutputs *y, Fault *f)
{
    const ControllerParameters *p = &law->p;
    const Matrix J = matrix(p->J_B);
    Errors e;
    Vector M_g = zero;
    y->no_attitude = no_attitude(x, u);
    if (damps_only(x, u)) {
        damp(p, u, y);
        return controller_guard(y, f);
    }
    ControllerState now = *x;
    if (!latch(law, u, &now, f) || !tracking_errors(law, x->t, u, &e, f) ||
        (p->compensate_gravity && !gravity_gradient(law, u, J, &M_g, f))) {
        return false;
    }

    /* K = k K0, L = l L0 [9], with k and l by [10]. */
    const bool scheduled = p->gain_schedule == CONTROLLER_GAIN_SCHEDULE_ERROR;
    const double k = scheduled ? p->kappa0 / (p->a2 + now.attitude_error_0) * (p->a1 + e.angle) : p->kappa0;
    const double l = scheduled ? p->lambda0 / (p->c2 + now.rate_error_0) * (p->c1 + norm(e.omega)) : p->lambda0;
    const Vector K = scale(k, vector(p->K0));

    /* sum k_i e_i x Q^T e_i [7]; Q^T e_i is row i of Q. */
    const Vector gradient = {K.y * e.Q.b.z - K.z * e.Q.c.y, K.z * e.Q.c.x - K.x * e.Q.a.z,
                             K.x * e.Q.a.y - K.y * e.Q.b.x};
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
    return controller_guard(y, f);
}

/*@ requires \separated(x, y, f);
    CONTROLLER_FINITE */
bool controller_outputs(const ControllerLaw *law, const ControllerState *x, const ControllerInputs *u,
                        ControllerOutputs *y, Fault *f)
{
    return inputs_fit(u, f) && outputs_of(law, x, u, y, f);
}

/*@ requires \separated(x, y, f);
    CONTROLLER_FINITE */
bool controller_step(const ControllerLaw *law, ControllerState *x, const ControllerInputs *u, double h,
                     ControllerOutputs *y, Fault *f)
{
    ControllerState next = *x;
    const bool damping = damps_only(x, u);
    next.t = x->t + h;
    next.latched = x->latched && !damping;
    next.flown = !no_attitude(x, u);
    if (!inputs_fit(u, f) || (!damping && !latch(law, u, &next, f)) || !outputs_of(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
