/* Steering, acquisition or hold, and the plan that is flown. */
#include "state.h"

#include <string.h>

enum { ITERATIONS = 5 };                    /* of a plan at every renewal */
static const double RATE_MAX = 3.0;         /* 1/T, from which a plan of all its stages still succeeds */
static const double EARLY = 1e-6;           /* of the control period: a plan is due that much before its time */
static const double CHALLENGE_PERIOD = 0.6; /* T */
static const double HOLD_COST = 0.2;        /* T, of a plan that is challenged in the hold too: it has a turn in it */
static const double CHALLENGE_GAIN = 0.97;  /* a challenger is adopted below this share of the plan's cost */
static const double STEERING_DIPOLE = 1.12; /* of dipole_max: what three rods give across the field */
static const double STEERING_AGAIN = 2.0;   /* of steering_limit: back to steering beyond it */
static const double STEERING_LEFT = 3.0;    /* T of steering, beyond which it goes on down to the next share */
static const double STEERING_DONE = 0.4;    /* of steering_limit */
static const double SETTLED_ANGLE = 0.0174532925, SETTLED_TIME = 1.2; /* rad (1 deg), T */
static const double SETTLED_RATE_TIME = 20.0;                         /* T, in which the rate may turn by a radian */
static const double LOST_ANGLE = 0.0872664626;                        /* rad (5 deg) */

/* Where the satellite stands against its target. */
typedef struct {
    Target target;
    double angle, rate; /* rad, rad/s */
    Vector D_N;         /* momentum to be given, N m s */
    bool lost;          /* too far for a plan: the momentum has to be steered first */
} Standing;

/* N m s, N: what the total momentum lacks to the target's. */
static Vector momentum_to_give(const Model *model, const Motion *now, const Target *target)
{
    return subtract(apply(target->R, apply(model->J, target->Omega)), apply(now->R, momentum_of(model, now)));
}

static Standing standing_of(const ControllerPlannedState *x, const Model *model, const Ahead *ahead, const Motion *now)
{
    const Target target = controller_planned_target_at(ahead, x->t);
    const Matrix Q = multiply(transposed(target.R), now->R);
    const Vector D_N = momentum_to_give(model, now, &target);
    const double left = norm(D_N) / smaller(x->scales.steering_limit, RATE_MAX * x->scales.least_moment / x->scales.time);
    const bool far = x->steering.time > STEERING_LEFT * x->scales.time && left > STEERING_DONE;
    return (Standing){
        .target = target,
        .angle = principal_angle(Q),
        .rate = norm(subtract(now->Omega, apply_transposed(Q, target.Omega))),
        .D_N = D_N,
        .lost = x->phase == PHASE_STEERING ? left > 1.0 || far : left > STEERING_AGAIN,
    };
}

/* Where there is no reference: rates are damped, and all that was planned is given up. */
static void give_up(ControllerPlannedState *x, const Motion *now)
{
    x->phase = PHASE_DAMPING;
    x->settled_since = INFINITY;
    x->search.active = x->search.ready = false;
    x->plan.stages = 0;
    x->plan.cost = 0.0;
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
    x->steering.time = 0.0;
    x->reference = *now;
}

/* The phase from now on; whether a plan or a steering is due. */
static bool change_phase(ControllerPlannedState *x, const Standing *s, double early)
{
    const bool steering = x->phase == PHASE_STEERING;
    bool due = x->t >= x->next_plan - early;
    if (s->lost) {
        due = due || !steering;
        x->phase = PHASE_STEERING;
    } else if (steering && x->search.ready) {
        due = true;
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_HOLD && s->angle > LOST_ANGLE) {
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_ACQUISITION && x->t - x->settled_since >= SETTLED_TIME * x->scales.time - early) {
        x->phase = PHASE_HOLD;
    }
    return due;
}

/* The plan that was, from here and now on. */
static void renew(ControllerPlannedLaw *law, const Model *model, const Ahead *ahead, const Motion *now, double t,
                  const Plan *was, Plan *plan)
{
    controller_planned_lay_stages(model, ahead, now, t, was, plan, law->workspace.stage);
    controller_planned_improve(model, now, ITERATIONS, plan, &law->workspace);
}

/* The plan from now on: the one that was, or the one that the search has found. */
static void replan(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                   const Motion *now)
{
    const bool fresh = x->plan.stages == 0;
    if (!fresh) {
        renew(law, model, ahead, now, x->t, &x->plan, &law->trial);
        memcpy(&x->plan, &law->trial, sizeof x->plan);
    }
    if (x->search.ready) {
        renew(law, model, ahead, now, x->t, &x->search.best, &law->trial);
        if (fresh || law->trial.cost < CHALLENGE_GAIN * x->plan.cost) {
            memcpy(&x->plan, &law->trial, sizeof x->plan);
        }
        x->search.ready = false;
        x->next_challenge = x->t + CHALLENGE_PERIOD * x->scales.time;
    }
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
    x->reference = *now;
}

void controller_planned_decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Motion *now,
                               double dt, bool first)
{
    const ControllerPlannedParameters *p = &law->p;
    const Model model = controller_planned_believed(law, x);
    if (ahead->target_kind == ONBOARD_TARGET_NONE) {
        give_up(x, now);
        return;
    }
    if (x->phase == PHASE_DAMPING) {
        x->phase = PHASE_STEERING;
        x->next_plan = x->t;
    }
    const Standing s = standing_of(x, &model, ahead, now);
    const double early = EARLY * p->control_period;
    if (!(s.angle < SETTLED_ANGLE && s.rate < 1.0 / (SETTLED_RATE_TIME * x->scales.time))) {
        x->settled_since = INFINITY;
    } else if (x->settled_since > x->t) {
        x->settled_since = x->t;
    }

    /* A search for a plan from nothing ends after some samples; until then all goes on as it was. */
    Search *search = &x->search;
    const bool challenge = x->phase == PHASE_ACQUISITION || x->plan.cost > HOLD_COST * x->scales.time;
    if (s.lost) {
        search->active = search->ready = false;
    } else if (!search->active && !search->ready &&
               (x->phase == PHASE_STEERING || (challenge && x->t >= x->next_challenge - early))) {
        controller_planned_search_begin(now, x->t, search);
    }
    controller_planned_search_on(&model, ahead, first ? INT32_MAX : p->search_iterations, search, &law->workspace);

    const bool due = change_phase(x, &s, early);
    if (due) {
        x->next_plan = x->t + x->scales.plan_period;
    }
    if (x->phase != PHASE_STEERING) {
        if (due) {
            replan(law, x, &model, ahead, now);
        }
        return;
    }
    if (due) {
        const double dipole = STEERING_DIPOLE * p->dipole_max * x->identification.p[GAIN];
        controller_planned_steer(ahead, x->t, s.D_N, dipole, x->scales.time, law->steering_field, &x->steering);
    } else {
        x->steering.time = larger(x->steering.time - dt, 0.0);
    }
    x->reference = (Motion){s.target.R, s.target.Omega, 0.0};
    x->plan.stages = 0;
    x->plan.cost = 0.0;
}
