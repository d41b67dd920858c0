/* Differential dynamic programming with bounded controls: Tassa, Mansard and Todorov, ICRA 2014; errors of attitude in
 * body axes, R exp(d^). */
#include "ilqr.h"

#include <string.h>

static const double FINAL = 6.0, FINAL_WHEEL = 0.6; /* T, by which the last stage counts */
static const double TURN_MAX = 1.5;                 /* rad in a stage; a motion beyond is no plan */
static const double GAIN_MIN = 1e-6;                /* of the cost: an iteration that gains less is the last */
enum { QP_PASSES = 6 };

/* u + share k + K errors, within the limits, where errors are those of x from x0. */
static void add_feedback(const Motion *x, const Motion *x0, double share, const double k[CONTROLS], double K[CONTROLS][ERRORS],
                         double u[CONTROLS])
{
    double error[ERRORS];
    store(rotation_log(multiply(transposed(x0->R), x->R)), error);
    store(subtract(x->Omega, x0->Omega), error + 3);
    error[6] = x->l - x0->l;
    for (int j = 0; j < CONTROLS; ++j) {
        double change = share * k[j];
        for (int m = 0; m < ERRORS; ++m) {
            change += K[j][m] * error[m];
        }
        u[j] = clip(u[j] + change, -1.0, 1.0);
    }
}

/* Motion and cost of the controls in `from` plus share k + K errors, into `to`; NEVER where it turns too fast. */
static double rollout(const Model *model, const Plan *plan, Workspace *w, int from, int to, double share)
{
    double cost = 0.0;
    for (int i = 0; i < plan->stages; ++i) {
        const Motion *x = &w->x[to][i], *x0 = &w->x[from][i];
        const double h = plan->h[i];
        double *u = w->u[to][i];
        memcpy(u, w->u[from][i], sizeof w->u[from][i]);
        if (share > 0.0) {
            add_feedback(x, x0, share, w->k[i], w->K[i], u);
        }
        u[3] = controller_planned_wheel_within(model, x->l, u[3], h);
        if (!(norm(x->Omega) * h < TURN_MAX)) {
            return NEVER;
        }
        cost += h * (controller_planned_cost_of(model, &w->stage[i].target, x, 1.0, 1.0, NULL, NULL) + control_cost(u));
        w->x[to][i + 1] = controller_planned_moved(model, &w->stage[i].around, x, u, h);
    }
    const double T = model->scales.time;
    cost += controller_planned_cost_of(model, &w->stage[plan->stages].target, &w->x[to][plan->stages], FINAL * T,
                                       FINAL_WHEEL * T, NULL, NULL);
    return cost == cost ? cost : NEVER;
}

/* C += A B; A is n x m, B is m x p, each by rows. */
static inline void add_product(int n, int m, int p, const double *A, const double *B, double *C)
{
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < p; ++j) {
            double x = C[i * p + j];
            for (int k = 0; k < m; ++k) {
                x += A[i * m + k] * B[k * p + j];
            }
            C[i * p + j] = x;
        }
    }
}

/* C += A^T B; A is m x n, B is m x p. */
static inline void add_transposed_product(int n, int m, int p, const double *A, const double *B, double *C)
{
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < p; ++j) {
            double x = C[i * p + j];
            for (int k = 0; k < m; ++k) {
                x += A[k * n + i] * B[k * p + j];
            }
            C[i * p + j] = x;
        }
    }
}

/* C += A^T B + D^T E; A and D are m x n, B and E are m x p. */
static inline void add_transposed_products(int n, int m, int p, const double *A, const double *B, const double *D,
                                           const double *E, double *C)
{
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < p; ++j) {
            double x = C[i * p + j];
            for (int k = 0; k < m; ++k) {
                x += A[k * n + i] * B[k * p + j] + D[k * n + i] * E[k * p + j];
            }
            C[i * p + j] = x;
        }
    }
}

/* Q = L + V of what follows, to second order in the errors at the stage's beginning and the changes of its controls. */
static void expand(const Model *model, const Stage *stage, const Motion *x, const Motion *next, const double u[CONTROLS],
                   double h, BackwardPass *s)
{
    double *A = (double *)s->A, *G = (double *)s->G, *VA = s->VA[0], *VG = s->VG[0];
    controller_planned_linearise(model, &stage->around, x, next, u, h, s->A, s->G);
    controller_planned_cost_of(model, &stage->target, x, h, h, s->Qx, s->Lxx);
    memset(s->Qux, 0, sizeof s->Qux);
    memset(s->Quu, 0, sizeof s->Quu);
    for (int a = 0; a < CONTROLS; ++a) {
        s->Qu[a] = 2.0 * WEIGHT_CONTROL * h * u[a];
        s->Quu[a][a] = 2.0 * WEIGHT_CONTROL * h;
    }
    memset(VA, 0, sizeof s->VA);
    memset(VG, 0, sizeof s->VG);
    add_product(ERRORS, ERRORS, ERRORS, s->V[0], A, VA);
    add_product(ERRORS, ERRORS, CONTROLS, s->V[0], G, VG);
    add_transposed_product(ERRORS, ERRORS, 1, A, s->v, s->Qx);            /* Qx = Lx + A'v */
    add_transposed_product(CONTROLS, ERRORS, 1, G, s->v, s->Qu);          /* Qu = Lu + G'v */
    add_transposed_product(CONTROLS, ERRORS, CONTROLS, G, VG, s->Quu[0]); /* Quu = Luu + G'V G */
    add_transposed_product(CONTROLS, ERRORS, ERRORS, G, VA, s->Qux[0]);   /* Qux = G'V A */
}

/* k = argmin 1/2 k'Quu k + Qu'k in the box of the limits, K = -Quu^-1 Qux in the controls that are free. */
static void gains(const Model *model, double l, const double u[CONTROLS], double h, const BackwardPass *s, double k[CONTROLS],
                  double K[CONTROLS][ERRORS])
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
    controller_planned_box_qp(s->Quu, s->Qu, low, high, QP_PASSES, k, free);
    controller_planned_solve_free(s->Quu, free, ERRORS, K[0]);
}

/* v = Qx + K'(Qu + Quu k) + Qux'k, V = Lxx + A'V A + K'(Qux + Quu K) + Qux'K. */
static void carry_back(const double k[CONTROLS], const double *K, BackwardPass *s)
{
    double QuuK[CONTROLS][ERRORS];
    memcpy(QuuK, s->Qux, sizeof QuuK);
    add_product(CONTROLS, CONTROLS, 1, s->Quu[0], k, s->Qu);
    add_product(CONTROLS, CONTROLS, ERRORS, s->Quu[0], K, QuuK[0]);
    memcpy(s->v, s->Qx, sizeof s->v);
    memset(s->V, 0, sizeof s->V);
    for (int a = 0; a < ERRORS; ++a) {
        s->V[a][a] = s->Lxx[a];
    }
    add_transposed_products(ERRORS, CONTROLS, 1, K, s->Qu, s->Qux[0], k, s->v);
    add_transposed_product(ERRORS, ERRORS, ERRORS, s->A[0], s->VA[0], s->V[0]);
    add_transposed_products(ERRORS, CONTROLS, ERRORS, K, QuuK[0], s->Qux[0], K, s->V[0]);
    for (int a = 0; a < ERRORS; ++a) { /* symmetric to the last bit */
        for (int b = 0; b < a; ++b) {
            s->V[a][b] = s->V[b][a];
        }
    }
}

/* Gains of all stages for the motion in `at`. */
static void backward_pass(const Model *model, const Plan *plan, Workspace *w, int at)
{
    BackwardPass *s = &w->pass;
    double hessian[ERRORS];
    const int n = plan->stages;
    const double T = model->scales.time;
    memset(s->V, 0, sizeof s->V);
    controller_planned_cost_of(model, &w->stage[n].target, &w->x[at][n], FINAL * T, FINAL_WHEEL * T, s->v, hessian);
    for (int i = 0; i < ERRORS; ++i) {
        s->V[i][i] = hessian[i];
    }
    for (int i = n - 1; i >= 0; --i) {
        const Motion *x = &w->x[at][i];
        const double *u = w->u[at][i], h = plan->h[i];
        expand(model, &w->stage[i], x, x + 1, u, h, s);
        gains(model, x->l, u, h, s, w->k[i], w->K[i]);
        carry_back(w->k[i], w->K[i][0], s);
    }
}

int controller_planned_improve(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w)
{
    static const double shares[] = {1.0, 0.5, 0.25, 0.1, 0.02};
    int now = 0, used = 0;
    w->x[0][0] = w->x[1][0] = *x;
    memcpy(w->u[0], plan->u, (size_t)plan->stages * sizeof plan->u[0]);
    plan->cost = rollout(model, plan, w, 0, 0, 0.0);
    while (used < iterations && may_be_flown(plan)) {
        ++used;
        backward_pass(model, plan, w, now);
        double cost = NEVER;
        for (size_t k = 0; k < sizeof shares / sizeof shares[0]; ++k) {
            cost = rollout(model, plan, w, now, 1 - now, shares[k]);
            if (cost < plan->cost) {
                break;
            }
        }
        if (!(cost < plan->cost)) {
            used = iterations;
            break;
        }
        const bool done = plan->cost - cost < GAIN_MIN * cost;
        plan->cost = cost;
        now = 1 - now;
        if (done) {
            used = iterations;
        }
    }
    if (may_be_flown(plan)) {
        memcpy(plan->u, w->u[now], (size_t)plan->stages * sizeof plan->u[0]);
    } else {
        used = iterations;
    }
    return used;
}
