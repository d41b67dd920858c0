/* docs/how/planned-plan.md, Search. Tests: test_plan.py. */
#include "search.h"

#include <string.h>

static const int ITERATIONS = 30, RODS_ITERATIONS = 60; /* of a start of a search, with a wheel and without */
static const int ITERATIONS_AT_ONCE = 10;               /* until a start is hastened */
/* A start with a wheel: T to turn by a radian (the first has no controls), whether the long way, T to reach the
 * target in. */
static const struct {
    double radian;
    bool round;
    double until;
} STRAIGHT[STARTS] = {{0.0, false, 2.0}, {2.5, false, 3.0}, {1.0, false, 2.0},
                      {2.5, true, 3.0},  {1.0, true, 3.0},  {1.0, false, 4.0}};
static const double STIFFNESS = 1.0, STIFFNESS_STEP = 0.2; /* of the cascade: 1/T, and at most this over a stage */
static const double DAMPING = 2.5, DAMPING_STEP = 0.5;     /* the same of the rate */
static const double ANGLE_MIN = 1e-9;                      /* rad, below which an error has no direction */
static const double WHEEL_REST = 1.2;                      /* T, over which the wheel would come to rest */

int controller_planned_controls_for(const Model *model, Vector tau, Vector B_B, double l, double u[CONTROLS])
{
    /* |A u - tau|^2 in units of the largest torques, with a little of |u|^2 and of the wheel's rest. */
    Vector A[CONTROLS];
    for (int j = 0; j < 3; ++j) {
        A[j] = cross(model->rods[j], B_B);
    }
    A[3] = scale(-model->wheel_torque_max, model->wheel_axis);
    double H[CONTROLS][CONTROLS], g[CONTROLS];
    const double low[CONTROLS] = {-1.0, -1.0, -1.0, -1.0}, high[CONTROLS] = {1.0, 1.0, 1.0, 1.0};
    bool free[CONTROLS];
    const double rest = wheel_to_rest(model, l, WHEEL_REST * model->scales.time);
    for (int i = 0; i < CONTROLS; ++i) {
        const double weight = i < 3 ? model->scales.weight_rods : model->scales.weight_motor;
        for (int j = 0; j < CONTROLS; ++j) {
            H[i][j] = dot(A[i], A[j]) + (i == j ? weight : 0.0);
        }
        g[i] = -dot(A[i], tau) - (i < 3 ? 0.0 : weight * rest);
        u[i] = 0.0;
    }
    return controller_planned_box_qp(&(BoxQp){(const double (*)[CONTROLS])H, g, low, high}, 2 * QP_PASSES, u, free);
}

void controller_planned_cascade(const Model *model, const Motion *x, const Turn *turn, Plan *plan,
                                const Stage stages[STAGES + 1], int32_t *work)
{
    const double T = model->scales.time;
    double s = 0.0;
    bool round = turn->round;
    Vector last = {0.0, 0.0, 0.0};
    Motion now = *x;
    for (int i = 0; i < plan->stages; ++i) {
        const double stiffness = smaller(STIFFNESS / T, STIFFNESS_STEP / plan->h[i]),
                     damping = smaller(DAMPING / T, DAMPING_STEP / plan->h[i]);
        const Stage *stage = &stages[i];
        Matrix R = stage->target.R;
        if (s < turn->until) {
            R = multiply(R, rotation_exp(scale(1.0 - s / turn->until, turn->by)));
        }
        const Matrix Q = multiply(transposed(R), now.R);
        const Vector zeta = rotation_log(Q);
        const double size = norm(zeta);
        round = round && !(dot(zeta, last) < 0.0); /* from half a turn on the long way is the short one */
        last = zeta;
        const double speed = round ? -turn->rate : smaller(stiffness * size, turn->rate);
        const Vector wanted =
            subtract(apply_transposed(Q, stage->target.Omega), scale(size > ANGLE_MIN ? speed / size : 0.0, zeta));
        Vector tau = scale(-damping, apply(model->J, subtract(now.Omega, wanted)));
        tau = subtract(tau, cross(momentum_of(model, &now), now.Omega));
        const Vector B_B = apply_transposed(now.R, stage->around.B_N);
        spend(work, WORK_CASCADE + controller_planned_controls_for(model, tau, B_B, now.l, plan->u[i]));
        now = controller_planned_advanced(model, &stage->around, &now, plan->u[i], plan->h[i]);
        s += plan->h[i];
    }
}

/* To the target itself. */
static Turn straight(const Model *model, int start)
{
    return (Turn){.rate = 1.0 / (STRAIGHT[start].radian * model->scales.time), .round = STRAIGHT[start].round};
}

void controller_planned_search_begin(const Motion *x, double t, bool urgent, Search *search)
{
    search->active = true;
    search->ready = false;
    search->urgent = urgent;
    search->start = 0;
    search->left = 0;
    search->x = *x;
    search->t = t;
}

void controller_planned_search_on(const Model *model, const Ahead *ahead, int iterations, Search *search, Workspace *w,
                                  int32_t *work)
{
    while (search->active && iterations > 0) {
        const bool fresh = search->left == 0, wheel = has_wheel(model);
        const int stages = fresh ? STAGES : search->trial.stages;
        const int before = fresh ? WORK_LAY + WORK_CASCADE + 2 * WORK_QP : WORK_SURVEY;
        if (*work < stages * (before + WORK_ROLLOUT + WORK_OF_ITERATION)) {
            return;
        }
        if (search->left == 0) { /* fresh: asked of what it sets, as the proof follows it */
            search->left = wheel ? ITERATIONS : RODS_ITERATIONS;
            controller_planned_lay_stages(model, ahead, &search->x, search->t, search->urgent, NULL, &search->trial,
                                          w->stage, work);
            if (search->urgent) {
                search->trial.until += STRAIGHT[search->start % STARTS].until * model->scales.time;
            }
            if (search->start > 0) {
                const Turn turn = wheel ? straight(model, search->start % STARTS)
                                        : controller_planned_random_turn(model, &search->random);
                controller_planned_cascade(model, &search->x, &turn, &search->trial, w->stage, work);
            }
        } else {
            controller_planned_survey(ahead, &search->trial, w->stage, work);
        }
        const int until_hastened = (search->left - 1) % ITERATIONS_AT_ONCE + 1;
        const int used = controller_planned_improve(model, NULL, &search->x,
                                                    iterations < until_hastened ? iterations : until_hastened,
                                                    &search->trial, w, work);
        const int left = search->left - used;
        search->left = left > 0 ? left : 0;
        iterations -= used;
        const bool compared = search->left % ITERATIONS_AT_ONCE == 0;
        if ((fresh && search->start == 0) ||
            (compared && controller_planned_better(&search->trial, &search->best, search->t, 1.0))) {
            memcpy(&search->best, &search->trial, sizeof search->best);
        }
        if (compared) {
            controller_planned_hasten(&search->trial);
        }
        if (search->left == 0) {
            const int last = wheel ? STARTS - 1 : RODS_STARTS - 1;
            search->active = search->start < last;
            search->start = search->start < last ? search->start + 1 : last + 1;
            search->ready = !search->active && may_be_flown(&search->best);
        }
    }
}
