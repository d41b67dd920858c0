/* Tests: tests/native/test_flavours.py. */
#include "plant_judge.h"

#include "reference.h"

bool plant_judge_check(const PlantJudgeParameters *p, Fault *f)
{
    return is_reference(p->reference, f) && is_reference_start(p->R_d0, p->Omega_d0, f);
}

void plant_judge_prepare(const PlantJudgeParameters *p, PlantJudgeLaw *law)
{
    law->p = *p;
    store_matrix(nearest_rotation(matrix(p->R_d0)), law->R_d0);
}

/* R_d and Omega_d where both are connected, else what the parameter `reference` says. */
static bool desired(const PlantJudgeLaw *law, double t, const PlantJudgeInputs *u, Reference *reference, Fault *f)
{
    const bool has_attitude = plant_judge_has_R_d(u), has_rate = plant_judge_has_Omega_d(u);
    if (has_attitude && !has_rate) {
        return fault(f, "Omega_d", norm(vector(u->Omega_d)), "to be connected, since R_d is: connect both or neither");
    }
    if (has_rate && !has_attitude) {
        return fault(f, "R_d", largest_element(matrix(u->R_d)),
                     "to be connected, since Omega_d is: connect both or neither");
    }
    if (has_attitude) {
        *reference = (Reference){matrix(u->R_d), vector(u->Omega_d), {0.0, 0.0, 0.0}};
        return is_rotation(reference->R_d, REFERENCE_ATTITUDE_TOLERANCE, "R_d",
                           "a rotation matrix, max |R_d^T R_d - I| at most 0.0001", f);
    }
    return reference_at(law->p.reference, matrix(law->R_d0), vector(law->p.Omega_d0), t, vector(u->r_N), vector(u->v_N),
                        reference, f);
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
bool plant_judge_outputs(const PlantJudgeLaw *law, const PlantJudgeState *x, const PlantJudgeInputs *u,
                         PlantJudgeOutputs *y, Fault *f)
{
    const Matrix R = matrix(u->R_NB);
    Reference reference;
    if (!are_finite_rate_and_orbit(u->omega_B, u->r_N, u->v_N, f)) {
        return false;
    }
    y->no_attitude = no_attitude(x, u);
    if (y->no_attitude) {
        y->attitude_error = REFERENCE_NO_ATTITUDE;
        store(vector(u->omega_B), y->rate_error_B);
        return true;
    }
    if (!is_attitude(R, f)) {
        return false;
    }
    if (is_zero_matrix(matrix(u->R_d))) {
        y->attitude_error = REFERENCE_NO_ATTITUDE;
        store(vector(u->omega_B), y->rate_error_B);
        return true;
    }
    if (!desired(law, x->t, u, &reference, f)) {
        return false;
    }
    const Matrix Q = multiply(transposed(reference.R_d), R);
    y->attitude_error = principal_angle(Q);
    store(subtract(vector(u->omega_B), apply_transposed(Q, reference.Omega_d)), y->rate_error_B);
    return true;
}

bool plant_judge_step(const PlantJudgeLaw *law, PlantJudgeState *x, const PlantJudgeInputs *u, double h,
                      PlantJudgeOutputs *y, Fault *f)
{
    const PlantJudgeState next = {x->t + h, !no_attitude(x, u)};
    if (!plant_judge_outputs(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
