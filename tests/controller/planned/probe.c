/* The planned controller's inner functions, for tests: flat arrays of doubles in, flat arrays out. */
#include "plan/strained.h"
#include "probe_flat.h"

static const double UNIT = 50.0; /* s, the paper's satellite's T */
static Workspace workspace;
static Plan plans[2];
static int32_t work; /* of the planner, as much as it wants */

/* What a plan is made of. */
typedef struct {
    OnboardField field;
    Model model;
    Ahead ahead;
    Motion now;
} Case;

static const Case *case_of(const FlatModel *m, const FlatAhead *a, const FlatMotion *x)
{
    static Case c;
    work = INT32_MAX;
    c.model = model_of(m);
    c.ahead = ahead_of_flat(a, &c.field);
    c.now = motion_of(x);
    return &c;
}

PROBE void probe_box_qp(int n, const double *H, const double *g, const double *low, const double *high, int passes,
                        double *u, unsigned char *free)
{
    for (int i = 0; i < n; ++i) {
        double h[CONTROLS][CONTROLS];
        bool f[CONTROLS];
        memcpy(h, H + 16 * i, sizeof h);
        controller_planned_box_qp(&(BoxQp){(const double (*)[CONTROLS])h, g + 4 * i, low + 4 * i, high + 4 * i}, passes,
                                  u + 4 * i, f);
        for (int k = 0; k < CONTROLS; ++k) {
            free[4 * i + k] = f[k];
        }
    }
}

PROBE void probe_acceleration(const FlatModel *m, const FlatAround *a, const FlatMotion *x, const double u[4],
                              double out[3])
{
    const Model model = model_of(m);
    const Around around = around_of(a);
    const Motion motion = motion_of(x);
    store(controller_planned_acceleration(&model, &around, &motion, u), out);
}

PROBE void probe_advanced(const FlatModel *m, const FlatAround *a, const FlatMotion *x, const double u[4], double h,
                          FlatMotion *y)
{
    const Model model = model_of(m);
    const Around around = around_of(a);
    const Motion motion = motion_of(x), next = controller_planned_advanced(&model, &around, &motion, u, h);
    flatten(&next, y);
}

PROBE void probe_linearised(const FlatModel *m, const FlatAround *a, const FlatMotion *x, const double u[4], double h,
                            double *A, double *G)
{
    const Model model = model_of(m);
    const Around around = around_of(a);
    const Motion motion = motion_of(x), next = controller_planned_advanced(&model, &around, &motion, u, h);
    Square square;
    double columns[CONTROLS][ERRORS];
    controller_planned_linearise(&model, &around, &motion, &next, u, h, square, columns);
    for (int i = 0; i < ERRORS; ++i) {
        for (int j = 0; j < ERRORS; ++j) {
            A[ERRORS * i + j] = square[j][i];
        }
        for (int j = 0; j < CONTROLS; ++j) {
            G[CONTROLS * i + j] = columns[j][i];
        }
    }
}

PROBE double probe_cost_rate(const FlatModel *m, const double R_d[9], const double Omega_d[3], const FlatMotion *x,
                             double gradient[7])
{
    Model model = model_of(m);
    const Target target = {nine(R_d), vector(Omega_d)};
    const Motion motion = motion_of(x);
    double hessian[ERRORS];
    if (!has_wheel(&model)) {
        const Plan close = {.stages = 1};
        controller_planned_plan_by_rods(&model, &close);
    }
    return controller_planned_cost_of(&model, &target, &motion, 1.0, 1.0, gradient, hessian, NULL);
}

/* The weight of far angles by rods alone after a plan of so many stages, at a share of the cost from which it is
 * challenged. */
PROBE double probe_weight_far(const FlatModel *m, int stages, double share)
{
    Model model = model_of(m);
    const Plan was = {.stages = stages, .cost = share * controller_planned_rods_cost(&model)};
    controller_planned_plan_by_rods(&model, &was);
    return model.scales.weight_far;
}

PROBE void probe_controls_for(const FlatModel *m, const double tau[3], const double B[3], double l, double u[4])
{
    const Model model = model_of(m);
    controller_planned_controls_for(&model, vector(tau), vector(B), l, u);
}

/* Lays stages, fills them by the cascade where `rate` is above 0, improves; returns the number of stages. */
PROBE int probe_plan(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, double t, double rate, int iterations,
                     double *h, double *u, double *cost, FlatMotion *path)
{
    OnboardField field;
    const Model model = model_of(m);
    const Ahead ahead = ahead_of_flat(a, &field);
    Motion now = motion_of(x);
    Plan *plan = &plans[0];
    work = INT32_MAX;
    controller_planned_lay_stages(&model, &ahead, &now, t, false, NULL, plan, workspace.stage, &work);
    if (rate > 0.0) {
        const Turn turn = {.rate = rate};
        controller_planned_cascade(&model, &now, &turn, plan, workspace.stage, &work);
    }
    controller_planned_improve(&model, NULL, &now, iterations, plan, &workspace, &work);
    for (int i = 0; i < plan->stages; ++i) {
        flatten(&now, &path[i]);
        h[i] = plan->h[i];
        memcpy(u + 4 * i, plan->u[i], sizeof plan->u[i]);
        now = controller_planned_advanced(&model, &workspace.stage[i].around, &now, plan->u[i], plan->h[i]);
    }
    flatten(&now, &path[plan->stages]);
    *cost = plan->cost;
    return plan->stages;
}

/* The feedback gains of the first iteration on the plan without controls, by stages; returns the number of stages. */
PROBE int probe_gains(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, double *h, double *K,
                      FlatMotion *path)
{
    double u[STAGES][CONTROLS], cost;
    const int n = probe_plan(m, a, x, a->t, 0.0, 0, h, u[0], &cost, path);
    const Model model = model_of(m);
    const Motion now = motion_of(x);
    controller_planned_improve(&model, NULL, &now, 1, &plans[0], &workspace, &work);
    memcpy(K, workspace.K, (size_t)n * sizeof workspace.K[0]);
    return n;
}

/* The controls of a plan of three stages of 1 s from t = 10 s on, whose first controls are 0.1, 0.2 and 0.3; u holds
 * those before. */
PROBE void probe_controls_at(double t, double u[CONTROLS])
{
    Plan *plan = &plans[0];
    memset(plan, 0, sizeof *plan);
    plan->start = 10.0;
    plan->stages = 3;
    for (int k = 0; k < 3; ++k) {
        plan->h[k] = 1.0;
        plan->u[k][0] = 0.1 * (k + 1);
    }
    controller_planned_plan_at(plan, t, u);
}

/* The cost of given controls on the stages of a plan with none. */
PROBE double probe_plan_cost(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, double t, const double *u)
{
    const Case *c = case_of(m, a, x);
    Plan *plan = &plans[0];
    controller_planned_lay_stages(&c->model, &c->ahead, &c->now, t, false, NULL, plan, workspace.stage, &work);
    memcpy(plan->u, u, (size_t)plan->stages * sizeof plan->u[0]);
    controller_planned_improve(&c->model, NULL, &c->now, 0, plan, &workspace, &work);
    return plan->cost;
}

/* Costs of the last plan of probe_plan from another motion: by its controls alone, and following the motion from
 * `expected`. */
PROBE void probe_followed(const FlatModel *m, const FlatMotion *expected, const FlatMotion *x, double cost[2])
{
    const Model model = model_of(m);
    const Motion there = motion_of(expected), now = motion_of(x);
    work = INT32_MAX;
    for (int i = 0; i < 2; ++i) {
        controller_planned_improve(&model, i > 0 ? &there : NULL, &now, 0, &plans[0], &workspace, &work);
        cost[i] = plans[0].cost;
    }
}

/* The stages and controls that a plan from t becomes when it is laid anew from t_next. */
PROBE int probe_replanned(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, double t, int n, const double *h,
                          const double *u, double t_next, double *h_next, double *u_next)
{
    const Case *c = case_of(m, a, x);
    memset(&plans[0], 0, sizeof plans[0]);
    plans[0].start = t;
    plans[0].stages = n;
    memcpy(plans[0].h, h, (size_t)n * sizeof h[0]);
    memcpy(plans[0].u, u, (size_t)n * sizeof plans[0].u[0]);
    controller_planned_lay_stages(&c->model, &c->ahead, &c->now, t_next, false, &plans[0], &plans[1], workspace.stage,
                                  &work);
    memcpy(h_next, plans[1].h, (size_t)plans[1].stages * sizeof h[0]);
    memcpy(u_next, plans[1].u, (size_t)plans[1].stages * sizeof plans[1].u[0]);
    return plans[1].stages;
}

/* A plan without controls, renewed at a->t in this phase with such an account, of which the rest is given back: its
 * stages, how many `longer` becomes, its cost, when it settles, and when the next one is to do so, which at first is
 * when this one is. */
PROBE int probe_renew(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, int phase, int32_t *account,
                      int32_t *longer, double *h, double found[3])
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState state;
    const Case *c = case_of(m, a, x);
    memset(&plans[0], 0, sizeof plans[0]);
    plans[0].start = state.t = a->t;
    plans[0].until = found[2];
    state.scales = c->model.scales;
    state.phase = phase;
    state.longer = *longer;
    const bool renewed =
        controller_planned_renew(&law, &state, &c->model, &c->ahead, &c->now, &c->now, &plans[0], account);
    memcpy(h, law.trial.h, (size_t)law.trial.stages * sizeof h[0]);
    *longer = state.longer;
    found[0] = law.trial.cost;
    found[1] = law.trial.settles;
    found[2] = law.trial.until;
    return renewed ? law.trial.stages : 0;
}

/* The cost of a plan from a->t after so many iterations from a motion that stays at the target, with the wheel of x. */
PROBE double probe_guessed(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, int iterations)
{
    const Case *c = case_of(m, a, x);
    Plan *plan = &plans[0];
    controller_planned_lay_stages(&c->model, &c->ahead, NULL, a->t, false, NULL, plan, workspace.stage, &work);
    for (int i = 0; i <= plan->stages; ++i) {
        workspace.x[0][i] = (Motion){workspace.stage[i].target.R, workspace.stage[i].target.Omega, c->now.l};
    }
    controller_planned_improve_guess(&c->model, &c->now, iterations, plan, &workspace, &work);
    return plan->cost;
}

/* A strained hold from a->t on that is flown by the planner's own motion, with n renewals: the length of each plan,
 * s, and wheel momentum and attitude error before it. */
PROBE void probe_strained(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, int n, double *length,
                          double *wheel, double *angle)
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState state;
    OnboardField field;
    Model model = model_of(m);
    controller_planned_plan_strained(&model);
    Ahead ahead = ahead_of_flat(a, &field);
    Motion now = motion_of(x);
    memset(&state, 0, sizeof state);
    state.scales = model.scales;
    state.phase = PHASE_HOLD;
    state.strained = true;
    state.t = state.plan.start = a->t;
    for (int k = 0; k < n; ++k) {
        int32_t account = WORK_OF_SAMPLE;
        wheel[k] = now.l;
        angle[k] = principal_angle(multiply(transposed(controller_planned_target_at(&ahead, state.t).R), now.R));
        if (controller_planned_renew(&law, &state, &model, &ahead, &now, &now, &state.plan, &account) &&
            may_be_flown(&law.trial)) {
            memcpy(&state.plan, &law.trial, sizeof state.plan);
            controller_planned_keep_motion(&state.plan, law.workspace.x[law.workspace.now], &state.planned);
        }
        length[k] = 0.0;
        for (int i = 0; i < state.plan.stages; ++i) {
            length[k] += state.plan.h[i];
        }
        for (int i = 0; i < 4; ++i, state.t += 0.25 * model.scales.plan_period) {
            const Around around = controller_planned_around_at(&ahead, state.t);
            double u[CONTROLS];
            controller_planned_plan_at(&state.plan, state.t, u);
            now = controller_planned_advanced(&model, &around, &now, u, 0.25 * model.scales.plan_period);
        }
    }
}

/* Of n estimates d of the disturbance at t, good or not: by how much it changes from the last one to m times ahead. */
PROBE void probe_profile(double period, int n, const double *t, const double *d, const unsigned char *good, int m,
                         const double *ahead, double *change)
{
    Profile profile;
    memset(&profile, 0, sizeof profile);
    for (int i = 0; i < n; ++i) {
        controller_planned_profile_keep(t[i], period, vector(d + 3 * i), good[i], &profile);
    }
    for (int i = 0; i < m; ++i) {
        store(controller_planned_profile_change(&profile, t[n - 1], ahead[i]), change + 3 * i);
    }
}

/* A search from t = 0 with such an account in each call: the calls that it takes, and the least that is left of the
 * account. */
PROBE int probe_search(const FlatModel *m, const FlatAhead *a, const FlatMotion *x, int32_t account, int32_t *least,
                       double *cost, double *u)
{
    static Search search;
    const Case *c = case_of(m, a, x);
    int calls = 0;
    *least = account;
    memset(&search, 0, sizeof search);
    controller_planned_search_begin(&c->now, 0.0, has_wheel(&c->model), &search);
    for (; search.active && calls < 1000; ++calls) {
        int32_t left = account;
        controller_planned_search_on(&c->model, &c->ahead, INT32_MAX, &search, &workspace, &left);
        *least = left < *least ? left : *least;
    }
    *cost = search.best.cost;
    memcpy(u, search.best.u, sizeof search.best.u);
    return calls;
}

PROBE void probe_around(const FlatAhead *a, double t, FlatAround *out, double R_d[9], double Omega_d[3])
{
    OnboardField field;
    const Ahead ahead = ahead_of_flat(a, &field);
    const Around around = controller_planned_around_at(&ahead, t);
    const Target target = controller_planned_target_at(&ahead, t);
    store(around.B_N, out->B_N);
    store(around.r_hat_N, out->r_hat_N);
    out->rate_squared = around.rate_squared;
    nine_of(target.R, R_d);
    store(target.Omega, Omega_d);
}

PROBE double probe_steer(const FlatAhead *a, double t, const double D[3], double dipole, double lambda[3])
{
    static Vector nodes[STEERING_NODES];
    OnboardField field;
    const Ahead ahead = ahead_of_flat(a, &field);
    Steering steering = {vector(lambda), 0.0};
    controller_planned_steer(&ahead, t, vector(D), dipole, UNIT, nodes, &steering);
    store(steering.lambda_N, lambda);
    return steering.time;
}

PROBE void probe_steering_rods(const double lambda[3], double time, const double R[9], const double B[3],
                               const double *rods, double u[3])
{
    const Steering steering = {vector(lambda), time};
    const Vector axes[3] = {vector(rods), vector(rods + 3), vector(rods + 6)};
    controller_planned_steering_rods(&steering, nine(R), vector(B), axes, UNIT, u);
}

PROBE void probe_sizes(size_t sizes[2])
{
    sizes[0] = sizeof(ControllerPlannedState);
    sizes[1] = sizeof(ControllerPlannedLaw);
}

/* Samples of the same inputs, the tenth with another rate about x, and `after` more; whether all went well. */
PROBE int probe_glitch(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u, double rate, int after,
                       ControllerPlannedOutputs *y)
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState x;
    Fault f;
    bool well = controller_planned_check(p, &f);
    controller_planned_prepare(p, &law);
    well = well && controller_planned_start(&law, u, &x, &f);
    for (int i = 0; well && i < 10 + after; ++i) {
        ControllerPlannedInputs v = *u;
        v.omega_B[0] = i == 9 ? rate : u->omega_B[0];
        well = controller_planned_step(&law, &x, &v, p->control_period, y, &f);
    }
    return well;
}
