/* Backward pass of the iterative LQR: the cost from each stage on, to second order, and the best changes of its
 * controls: docs/how/planned-plan.md, Iterative LQR. Box-constrained as by Tassa, Mansard and Todorov, ICRA 2014;
 * errors of attitude in body axes, R exp(d^). Tests: test_gains.py. */
#include "ilqr.h"

#include <string.h>

/* A column without the wheel's element, which few have. */
typedef struct {
    Vector angle, rate;
} Column;

static inline Column column(const double a[ERRORS])
{
    return (Column){vector(a), vector(a + 3)};
}

static inline double along(Column a, const double b[ERRORS])
{
    return dot(a.angle, vector(b)) + dot(a.rate, vector(b + 3));
}

/* Q = L + V of what follows, to second order in the errors at the stage's beginning and the changes of its controls. */
static void expand(const Model *model, const Stage *stage, const Motion *x, const Motion *next,
                   const double u[CONTROLS], double h, double weight, double caution, BackwardPass *s)
{
    controller_planned_linearise(model, &stage->around, x, next, u, h, s->A, s->G);
    controller_planned_cost_of(model, &stage->target, x, h * weight, h, s->Qx, s->Lxx, NULL);
    for (int j = 0; j < ERRORS; ++j) { /* Qx = Lx + A'v */
        const Column A = column(s->A[j]);
        s->Qx[j] += along(A, s->v) + (j == 6 ? s->v[6] : 0.0);
        for (int i = 0; i < ERRORS; ++i) {
            s->VA[j][i] = along(A, s->V[i]);
        }
    }
    for (int i = 0; i < ERRORS; ++i) {
        s->VA[6][i] += s->V[i][6];
    }
    for (int a = 0; a < CONTROLS; ++a) {
        const Column G = column(s->G[a]);
        const double wheel = s->G[a][6];
        double VG[ERRORS];
        for (int i = 0; i < ERRORS; ++i) {
            VG[i] = along(G, s->V[i]) + wheel * s->V[i][6];
        }
        const Column row = column(VG);
        const double effort = a < 3 ? model->scales.weight_control : model->scales.weight_motor_control;
        s->Qu[a] = 2.0 * effort * h * u[a] + along(G, s->v) + wheel * s->v[6]; /* Qu = Lu + G'v */
        for (int b = 0; b <= a; ++b) {                                         /* Quu = Luu + G'V G */
            s->Quu[a][b] = s->Quu[b][a] = along(row, s->G[b]) + VG[6] * s->G[b][6];
        }
        s->Quu[a][a] += (2.0 * effort + caution) * h;
        for (int j = 0; j < ERRORS; ++j) { /* Qux = G'V A */
            s->Qux[a][j] = along(row, s->A[j]) + (j == 6 ? VG[6] : 0.0);
        }
    }
}

/* k = argmin 1/2 k'Quu k + Qu'k in the box of the limits, K = -Quu^-1 Qux in the controls that are free. Returns the
 * work. */
static int gains(const Model *model, double l, const double u[CONTROLS], double h, const BackwardPass *s,
                 double k[CONTROLS], double K[CONTROLS][ERRORS])
{
    double low[CONTROLS], high[CONTROLS];
    bool free[CONTROLS];
    for (int a = 0; a < CONTROLS; ++a) {
        low[a] = -1.0 - u[a];
        high[a] = 1.0 - u[a];
        k[a] = 0.0;
        for (int b = 0; b < ERRORS; ++b) {
            K[a][b] = -s->Qux[a][b];
        }
    }
    low[3] = smaller(larger(low[3], controller_planned_wheel_within(model, l, -1.0, h) - u[3]), 0.0);
    high[3] = larger(smaller(high[3], controller_planned_wheel_within(model, l, 1.0, h) - u[3]), 0.0);
    const int work = controller_planned_box_qp(&(BoxQp){s->Quu, s->Qu, low, high}, QP_PASSES, k, free);
    controller_planned_solve_free(s->Quu, free, ERRORS, K[0]);
    return work;
}

/* v = Qx + K'(Qu + Quu k) + Qux'k, V = Lxx + A'V A + Qux'K: in the controls that are free Qux + Quu K is zero, in
 * the others K. */
static void carry_back(const double k[CONTROLS], double K[CONTROLS][ERRORS], BackwardPass *s)
{
    for (int a = 0; a < CONTROLS; ++a) {
        for (int b = 0; b < CONTROLS; ++b) {
            s->Qu[a] += s->Quu[a][b] * k[b];
        }
    }
    for (int a = 0; a < ERRORS; ++a) {
        const Column A = column(s->A[a]);
        const double Qux[CONTROLS] = {s->Qux[0][a], s->Qux[1][a], s->Qux[2][a], s->Qux[3][a]};
        double v = s->Qx[a];
        for (int c = 0; c < CONTROLS; ++c) {
            v += K[c][a] * s->Qu[c] + Qux[c] * k[c];
        }
        s->v[a] = v;
        for (int b = 0; b <= a; ++b) {
            const double by_controls = Qux[0] * K[0][b] + Qux[1] * K[1][b] + Qux[2] * K[2][b] + Qux[3] * K[3][b];
            s->V[a][b] = s->V[b][a] = along(A, s->VA[b]) + (a == 6 ? s->VA[b][6] : 0.0) + by_controls;
        }
        s->V[a][a] += s->Lxx[a];
    }
}

/* v of what follows, where the motion comes to another state than that from which the next stage begins. Returns
 * where it comes to. */
static Motion across_gap(const Model *model, const Stage *stage, const Motion *x, const double u[CONTROLS], double h,
                         BackwardPass *s)
{
    const Motion next = controller_planned_advanced(model, &stage->around, x, u, h);
    double gap[ERRORS];
    store(rotation_log(multiply(transposed(x[1].R), next.R)), gap);
    store(subtract(next.Omega, x[1].Omega), gap + 3);
    gap[6] = next.l - x[1].l;
    for (int i = 0; i < ERRORS; ++i) {
        for (int j = 0; j < ERRORS; ++j) {
            s->v[i] += s->V[i][j] * gap[j];
        }
    }
    return next;
}

bool controller_planned_backward_pass(const Model *model, const Plan *plan, Workspace *w, int at, bool gaps,
                                      int32_t kept, int32_t *work)
{
    BackwardPass *s = &w->pass;
    double hessian[ERRORS];
    const int n = plan->stages;
    memset(s->V, 0, sizeof s->V);
    controller_planned_cost_of(model, &w->stage[n].target, &w->x[at][n], model->scales.final_errors,
                               model->scales.final_wheel, s->v, hessian, NULL);
    for (int i = 0; i < ERRORS; ++i) {
        s->V[i][i] = hessian[i];
    }
    for (int i = n - 1; i >= 0; --i) {
        const Motion *x = &w->x[at][i];
        const double *u = w->u[at][i], h = plan->h[i];
        if (*work < (gaps ? WORK_ROLLOUT : 0) + WORK_BACKWARD + WORK_QP + kept) {
            return false;
        }
        Motion next = x[1];
        if (gaps) {
            spend(work, WORK_ROLLOUT);
            next = across_gap(model, &w->stage[i], x, u, h, s);
        }
        expand(model, &w->stage[i], x, &next, u, h, w->weight[i], plan->caution, s);
        spend(work, WORK_BACKWARD + gains(model, x->l, u, h, s, w->k[i], w->K[i]));
        carry_back(w->k[i], w->K[i], s);
    }
    return true;
}
