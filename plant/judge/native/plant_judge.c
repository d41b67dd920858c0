#include "plant_judge.h"

#include "rotation.h"

static const double PI = 3.14159265358979323846;
static const double R_MIN = 1.0;                /* m; nearer to the Earth's centre a position has no direction */
static const double COLLINEAR = 1e-9;           /* |r x v|/(|r||v|) below which the orbit has no plane */
static const double ATTITUDE_TOLERANCE = 1e-4;  /* of R_NB and R_d: single precision stays well below it */
static const double REFERENCE_TOLERANCE = 1e-3; /* of R_d0, which may be typed from four printed decimals */

/* Attitude (N from desired body) and rate in desired body axes [3]. */
typedef struct {
    Matrix R_d;
    Vector Omega_d;
} Reference;

bool plant_judge_check(const PlantJudgeParameters *p, Fault *f)
{
    if (p->reference < PLANT_JUDGE_REFERENCE_LVLH || p->reference > PLANT_JUDGE_REFERENCE_RATE) {
        return fault(f, "reference", p->reference, "1 (lvlh), 2 (inertial) or 3 (rate)");
    }
    return all_finite_vectors(&(NamedVector){"Omega_d0", vector(p->Omega_d0)}, 1, f) &&
           is_rotation(matrix(p->R_d0), REFERENCE_TOLERANCE, "R_d0", "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001",
                       f);
}

void plant_judge_prepare(const PlantJudgeParameters *p, PlantJudgeLaw *law)
{
    law->p = *p;
    store_matrix(nearest_rotation(matrix(p->R_d0)), law->R_d0);
}

/* Z to nadir, Y = -orbit normal, X = Y x Z, on any orbit: it turns with n = |r x v|/r^2 about -Y. */
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
    *reference = (Reference){lvlh_axes(r_N, v_N), {0.0, -h / (r * r), 0.0}};
    return true;
}

/* R_d and Omega_d where both are connected, else what the parameter `reference` says. */
static bool desired(const PlantJudgeLaw *law, double t, const PlantJudgeInputs *u, Reference *reference, Fault *f)
{
    const bool has_attitude = plant_judge_has_R_d(u), has_rate = plant_judge_has_Omega_d(u);
    const Matrix R_d0 = matrix(law->R_d0);
    const Vector Omega_d0 = vector(law->p.Omega_d0);
    if (has_attitude && !has_rate) {
        return fault(f, "Omega_d", norm(vector(u->Omega_d)), "to be connected, since R_d is: connect both or neither");
    }
    if (has_rate && !has_attitude) {
        return fault(f, "R_d", largest_element(matrix(u->R_d)), "to be connected, since Omega_d is: connect both or neither");
    }
    if (has_attitude) {
        *reference = (Reference){matrix(u->R_d), vector(u->Omega_d)};
        return all_finite_vectors(&(NamedVector){"Omega_d", reference->Omega_d}, 1, f) &&
               is_rotation(reference->R_d, ATTITUDE_TOLERANCE, "R_d", "a rotation matrix, max |R_d^T R_d - I| at most 0.0001",
                           f);
    }
    switch (law->p.reference) {
    case PLANT_JUDGE_REFERENCE_LVLH:
        return lvlh(vector(u->r_N), vector(u->v_N), reference, f);
    case PLANT_JUDGE_REFERENCE_RATE:
        *reference = (Reference){multiply(R_d0, rotation_exp(scale(t, Omega_d0))), Omega_d0};
        return true;
    default:
        *reference = (Reference){R_d0, {0.0, 0.0, 0.0}};
        return true;
    }
}

bool plant_judge_start(const PlantJudgeLaw *law, const PlantJudgeInputs *u, PlantJudgeState *x, Fault *f)
{
    (void)law, (void)u, (void)f;
    *x = (PlantJudgeState){0.0, false};
    return true;
}

/* Whether there is none yet: a matrix of zeros, as simple masters give before the first value. */
static bool no_attitude(const PlantJudgeState *x, const PlantJudgeInputs *u)
{
    return !x->flown && is_zero_matrix(matrix(u->R_NB));
}

/* Q = R_d^T R = exp(zeta^), omega = Omega - Q^T Omega_d [4]. */
bool plant_judge_outputs(const PlantJudgeLaw *law, const PlantJudgeState *x, const PlantJudgeInputs *u, PlantJudgeOutputs *y,
                         Fault *f)
{
    const NamedVector inputs[] = {{"omega_B", vector(u->omega_B)}, {"r_N", vector(u->r_N)}, {"v_N", vector(u->v_N)}};
    const Matrix R = matrix(u->R_NB);
    Reference reference;
    if (!all_finite_vectors(inputs, COUNT(inputs), f)) {
        return false;
    }
    y->no_attitude = no_attitude(x, u);
    if (y->no_attitude) {
        y->attitude_error = PI;
        store(vector(u->omega_B), y->rate_error_B);
        return true;
    }
    if (!is_rotation(R, ATTITUDE_TOLERANCE, "R_NB", "a rotation matrix, max |R_NB^T R_NB - I| at most 0.0001", f) ||
        !desired(law, x->t, u, &reference, f)) {
        return false;
    }
    const Matrix Q = multiply(transposed(reference.R_d), R);
    y->attitude_error = principal_angle(Q);
    store(subtract(vector(u->omega_B), apply_transposed(Q, reference.Omega_d)), y->rate_error_B);
    return true;
}

bool plant_judge_step(const PlantJudgeLaw *law, PlantJudgeState *x, const PlantJudgeInputs *u, double h, PlantJudgeOutputs *y,
                      Fault *f)
{
    const PlantJudgeState next = {x->t + h, !no_attitude(x, u)};
    if (!plant_judge_outputs(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
