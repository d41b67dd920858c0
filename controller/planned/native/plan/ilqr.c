/* Differential dynamic programming with bounded controls: Tassa, Mansard and Todorov, ICRA 2014; errors of attitude in
 * body axes, R exp(d^). The backward pass is in backward.c. docs/how/planned-plan.md, Iterative LQR.
 * Tests: test_plan.py. */
#include "ilqr.h"

#include <string.h>

static const double TURN_MAX = 1.5;      /* rad in a stage; a motion beyond is no plan */
static const double GAIN_MIN = 1e-6;     /* of the cost: an iteration that gains less is the last */
static const double WEIGHT_BEFORE = 0.1; /* of the errors before the plan's `until` */
static const double CAUTION_LEAST = 0.1, CAUTION_MOST = 1000.0,
                    CAUTION_STEP = 10.0; /* 1/s, after an iteration without gain */

/* u + share k + K errors, within the limits, where errors are those of x from x0. */
static void add_feedback(const Motion *x, const Motion *x0, double share, const double k[CONTROLS],
                         double K[CONTROLS][ERRORS], double u[CONTROLS])
{
    double error[ERRORS];
    const Matrix back = transposed(x0->R);
    store(rotation_log(product_of(&back, &x->R)), error);
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

/* Motion and cost of the controls in `from`, into `to`, and when it settles; where these are two, of the controls plus
 * share k + K errors. NEVER where it turns too fast or costs more than the limit before its end. */
static double rollout(const Model *model, const Plan *plan, Workspace *w, int from, int to, double share, double limit,
                      double *settles, int32_t *work)
{
    double cost = 0.0, t = plan->start, settled = t;
    bool near;
    *settles = INFINITY;
    for (int i = 0; i < plan->stages; ++i) {
        spend(work, WORK_ROLLOUT);
        const Motion *x = &w->x[to][i], *x0 = &w->x[from][i];
        const double h = plan->h[i];
        double *u = w->u[to][i];
        if (from != to) {
            memcpy(u, w->u[from][i], sizeof w->u[from][i]);
            add_feedback(x, x0, share, w->k[i], w->K[i], u);
        }
        u[3] = controller_planned_wheel_within(model, x->l, u[3], h);
        if (!(norm(x->Omega) * h < TURN_MAX)) {
            return NEVER;
        }
        cost += h * (controller_planned_cost_of(model, &w->stage[i].target, x, w->weight[i], 1.0, NULL, NULL, &near) +
                     control_cost(model, u));
        t += h;
        settled = near ? settled : t;
        if (cost > limit) {
            return NEVER;
        }
        controller_planned_moved(model, &w->stage[i].around, x, u, h, &w->x[to][i + 1]);
    }
    cost += controller_planned_cost_of(model, &w->stage[plan->stages].target, &w->x[to][plan->stages],
                                       model->scales.final_errors, model->scales.final_wheel, NULL, NULL, &near);
    if (!(cost < NEVER)) {
        return NEVER;
    }
    *settles = near ? settled : INFINITY;
    return cost;
}

/* The rollout of the first step length that costs less than the plan, into the motion that is not `now`: its cost,
 * NEVER where none does or the account ends before, and when it settles. */
static double line_search(const Model *model, const Plan *plan, Workspace *w, int now, double *settles, int32_t *work)
{
    static const double shares[] = {1.0, 0.5, 0.25, 0.1, 0.02};
    for (size_t k = 0; k < sizeof shares / sizeof shares[0] && *work >= plan->stages * WORK_ROLLOUT; ++k) {
        const double cost = rollout(model, plan, w, now, 1 - now, shares[k], plan->cost, settles, work);
        if (cost < plan->cost) {
            return cost;
        }
    }
    return NEVER;
}

/* What the errors of each stage count. */
static void weigh(const Plan *plan, double weight[STAGES])
{
    double t = plan->start;
    for (int i = 0; i < plan->stages; ++i) {
        weight[i] = 1.0 - (1.0 - WEIGHT_BEFORE) * clip((plan->until - t) / plan->h[i], 0.0, 1.0);
        t += plan->h[i];
    }
}

/* Cost of the motion from x that follows the plan's from `expected`, into the second, and when it settles. */
static double follow(const Model *model, const Plan *plan, const Motion *expected, const Motion *x, Workspace *w,
                     double *settles, int32_t *work)
{
    const int32_t kept = 2 * plan->stages * WORK_ROLLOUT; /* for the rollouts after the backward pass */
    double settles_there;
    w->x[0][0] = *expected;
    w->x[1][0] = *x;
    if (*work < plan->stages * WORK_OF_ITERATION + kept ||
        !(rollout(model, plan, w, 0, 0, 0.0, NEVER, &settles_there, work) < NEVER)) {
        return NEVER;
    }
    return controller_planned_backward_pass(model, plan, w, 0, false, kept, work)
               ? rollout(model, plan, w, 0, 1, 0.0, NEVER, settles, work)
               : NEVER;
}

/* Up to so many iterations from the motion in `now`, which settles then; returns how many it took. */
static int iterate(const Model *model, int now, double settles, int iterations, Plan *plan, Workspace *w, int32_t *work)
{
    int used = 0;
    while (used < iterations && *work >= plan->stages * WORK_OF_ITERATION) {
        const double cost = controller_planned_backward_pass(model, plan, w, now, false, 0, work)
                                ? line_search(model, plan, w, now, &settles, work)
                                : NEVER;
        if (!(cost < plan->cost)) {
            if (*work < plan->stages * WORK_ROLLOUT) {
                break;
            }
            used = plan->urgent && plan->caution < CAUTION_MOST ? used + 1 : iterations;
            plan->caution = smaller(CAUTION_MOST, larger(CAUTION_LEAST, CAUTION_STEP * plan->caution));
            continue;
        }
        const bool done = plan->cost - cost < GAIN_MIN * cost;
        plan->caution = plan->caution > CAUTION_LEAST ? plan->caution / CAUTION_STEP : 0.0;
        plan->cost = cost;
        plan->settles = settles;
        now = 1 - now;
        used = done ? iterations : used + 1;
    }
    memcpy(plan->u, w->u[now], (size_t)plan->stages * sizeof plan->u[0]);
    w->now = now;
    return used;
}

/* The plan's controls and what its errors count. */
static void begin(const Plan *plan, Workspace *w)
{
    memcpy(w->u[0], plan->u, (size_t)plan->stages * sizeof plan->u[0]);
    weigh(plan, w->weight);
}

int controller_planned_improve(const Model *model, const Motion *expected, const Motion *x, int iterations, Plan *plan,
                               Workspace *w, int32_t *work)
{
    int now = 0;
    double settles = INFINITY;
    begin(plan, w);
    const double followed = expected != NULL ? follow(model, plan, expected, x, w, &settles, work) : NEVER;
    w->x[0][0] = w->x[1][0] = *x;
    plan->cost = rollout(model, plan, w, 0, 0, 0.0, NEVER, &plan->settles, work);
    if ((plan->urgent && settles != plan->settles) ? settles < plan->settles : followed < plan->cost) {
        now = 1;
        plan->cost = followed;
        plan->settles = settles;
    }
    return may_be_flown(plan) ? iterate(model, now, settles, iterations, plan, w, work) : iterations;
}

void controller_planned_improve_guess(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w,
                                      int32_t *work)
{
    begin(plan, w);
    w->x[0][0] = w->x[1][0] = *x;
    const int32_t kept = plan->stages * WORK_ROLLOUT; /* for the rollout after the backward pass */
    plan->settles = INFINITY;
    plan->cost = controller_planned_backward_pass(model, plan, w, 0, true, kept, work)
                     ? rollout(model, plan, w, 0, 1, 1.0, NEVER, &plan->settles, work)
                     : NEVER;
    if (may_be_flown(plan)) {
        iterate(model, 1, plan->settles, iterations - 1, plan, w, work);
    }
}
