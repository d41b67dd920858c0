/* Steering, acquisition or hold, and the plan that is flown.
 * Longer than 250 lines: phases, plans and searches of a sample work on one state. */
#include "cost.h"
#include "renew.h"

#include <string.h>

static const int SEARCH_SAMPLES = 16;       /* that a search is expected to take */
static const double RATE_MAX = 3.0;         /* 1/T, from which a plan of all its stages still succeeds */
static const double CHALLENGE_PERIOD = 0.6; /* T */
static const double CHALLENGE_GAIN = 0.97;  /* a challenger is adopted below this share of the plan's time, or cost */
static const double STEERING_DIPOLE = 1.12; /* of dipole_max: what three rods give across the field */
static const double STEERING_AGAIN = 2.0;   /* of steering_limit: back to steering beyond it */
static const double SEARCH_KEPT = 0.4;      /* T, for which the plan of a search is good enough to begin with */
static const double SETTLED_ANGLE = 0.0174532925, SETTLED_TIME = 1.2; /* rad (1 deg), T */
static const double SETTLED_RATE_TIME = 20.0;                         /* T, in which the rate may turn by a radian */
static const double LOST_ANGLE = 0.0872664626;                        /* rad (5 deg) */
/* A hold is strained where it has been loaded, by an angle or a share of wheel_momentum_max, for so many orbits; with a larger angle
 * sooner: after so many T, in which an ordinary plan undoes what was sudden. */
static const double STRAINED_ANGLE = 0.0174532925, STRAINED_TIME = 2.0;                          /* rad (1 deg), T */
static const double LASTING_ANGLE = 0.0087266463, LASTING_MOMENTUM = 0.6, LASTING_ORBITS = 0.05; /* rad (0.5 deg) */
static const double STRAINED_ORBITS = 1.0; /* without a cause, until it is not */
static const double STRAINED_LOST = 1.0;   /* rad (57 deg) */

/* Where the satellite stands against its target. */
typedef struct {
    Target target;
    double angle, rate; /* rad, rad/s */
    Vector D_N;         /* momentum to be given, N m s */
    bool lost;          /* too far for a plan: the momentum has to be steered first */
    bool near;          /* not lost at the end of a search that begins now */
    bool loaded;        /* the wheel holds much of its limit, or the angle is not small */
} Standing;

/* N m s, N: what the total momentum lacks to the target's, with the wheel at rest or with the momentum that it keeps. */
static Vector momentum_to_give(const Model *model, const Motion *now, const Target *target)
{
    Vector wanted = apply(model->J, target->Omega);
    if (!has_wheel(model)) {
        wanted = add(wanted, scale(now->l, model->wheel_axis));
    }
    return subtract(apply(target->R, wanted), apply(now->R, momentum_of(model, now)));
}

/* N m s: of that, what the wheel cannot keep at the target's attitude. */
static double beyond_wheel(const Model *model, const Target *target, Vector D_N)
{
    const Vector axis_N = apply(target->R, model->wheel_axis);
    const double l = clip(-dot(D_N, axis_N), -model->wheel_momentum_max, model->wheel_momentum_max);
    return norm(add(D_N, scale(l, axis_N)));
}

static Standing standing_of(const ControllerPlannedState *x, const Model *model, const Ahead *ahead, const Motion *now,
                            double search_time)
{
    const Target target = controller_planned_target_at(ahead, x->t);
    const Matrix Q = multiply(transposed(target.R), now->R);
    const Vector D_N = momentum_to_give(model, now, &target);
    const bool steered = x->phase == PHASE_STEERING;
    const double limit = smaller(x->scales.steering_limit, RATE_MAX * x->scales.turning_moment / x->scales.time);
    const double needed = steered || !has_wheel(model) ? norm(D_N) : beyond_wheel(model, &target, D_N);
    const double left = needed / (has_wheel(model) ? limit : controller_planned_rods_limit(model, now->l, steered));
    const double angle = principal_angle(Q), time = x->steering.time, later = larger(time - search_time, 0.0);
    const bool lost = left > (!steered && has_wheel(model) ? STEERING_AGAIN : 1.0);
    return (Standing){
        .target = target,
        .angle = angle,
        .rate = norm(subtract(now->Omega, apply_transposed(Q, target.Omega))),
        .D_N = D_N,
        .lost = lost,
        .near = !lost || (steered && left * later <= time),
        .loaded = fabs(now->l) > LASTING_MOMENTUM * model->wheel_momentum_max || angle > LASTING_ANGLE,
    };
}

void controller_planned_give_up(ControllerPlannedState *x, const Motion *now)
{
    x->phase = PHASE_DAMPING;
    x->settled_since = x->loaded_since = INFINITY;
    x->strained_until = 0.0;
    x->planned.nodes = 0;
    x->search.active = x->search.ready = x->challenged = x->provisional = x->strained = false;
    x->plan.stages = 0;
    x->plan.cost = 0.0;
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
    x->steering.time = 0.0;
    x->reference = *now;
}

/* Whether the search has a plan, and the time from which it plans has come. */
static bool has_come(const ControllerPlannedState *x, double early)
{
    return x->search.ready && x->t >= x->search.t - early;
}

/* Until when the wheel possibly cannot keep the hold close, s: an orbit after the last cause. */
static double strained_until(const ControllerPlannedState *x, const Standing *s)
{
    const double lasts = x->t - x->loaded_since, period = x->scales.period;
    const bool far = s->angle > STRAINED_ANGLE && lasts > STRAINED_TIME * x->scales.time;
    const bool beyond = x->strained && norm(vector(x->identification.p + TORQUE)) > x->scales.disturbance_max;
    return far || beyond || lasts > LASTING_ORBITS * period ? x->t + STRAINED_ORBITS * period : x->strained_until;
}

/* The phase from now on; whether a plan or a steering is due. */
static bool change_phase(ControllerPlannedState *x, const Standing *s, double early)
{
    const bool steering = x->phase == PHASE_STEERING;
    bool due = x->t >= x->next_plan - early || (x->provisional && x->search.ready);
    if (s->lost) {
        if (!steering) {
            due = true;
            x->search.active = x->search.ready = false;
        }
        x->phase = PHASE_STEERING;
    } else if (steering && has_come(x, early)) {
        due = true;
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_HOLD && s->angle > (x->strained ? STRAINED_LOST : LOST_ANGLE)) {
        x->phase = PHASE_ACQUISITION;
    } else if (x->phase == PHASE_ACQUISITION && x->t - x->settled_since >= SETTLED_TIME * x->scales.time - early) {
        x->phase = PHASE_HOLD;
    }
    x->strained_until = strained_until(x, s);
    x->strained = x->phase == PHASE_HOLD && !x->rods_alone && x->t < x->strained_until;
    return due;
}

/* The motion by the model after a time, about that of a search, under a plan or the steering. */
static Motion expected(const ControllerPlannedState *x, const Model *model, const Ahead *ahead, const Plan *plan,
                       const Motion *from, double t, double time)
{
    const Around around = controller_planned_around_at(ahead, t + 0.5 * time);
    const double h = time / SEARCH_SAMPLES;
    Steering steering = x->steering;
    Motion then = *from;
    for (int i = 0; i < SEARCH_SAMPLES && h > 0.0; ++i) {
        double u[CONTROLS];
        if (x->phase == PHASE_STEERING) {
            const Vector B_B = apply_transposed(then.R, around.B_N);
            controller_planned_steering_rods(&steering, then.R, B_B, model->rods, model->scales.time, u);
            u[3] = controller_planned_wheel_to_rest(model, then.l);
            steering.time = larger(steering.time - h, 0.0);
        } else {
            controller_planned_plan_at(plan, t + (i + 0.5) * h, u);
        }
        then = controller_planned_advanced(model, &around, &then, u, h);
    }
    return then;
}

/* The plan from now on: the one that was; or the one of the search, where there is none, or in the sample after where it is
 * better. */
static void replan(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                   const Motion *now, double early, int32_t *work)
{
    const bool fresh = x->plan.stages == 0, of_search = fresh || x->challenged;
    const Search *search = &x->search;
    const Motion there =
        of_search ? expected(x, model, ahead, &search->best, &search->x, search->t, x->t - search->t) : x->reference;
    if (controller_planned_renew(law, x, model, ahead, &there, now, of_search ? &search->best : &x->plan, work) &&
        (!x->challenged || controller_planned_better(&law->trial, &x->plan, x->t, CHALLENGE_GAIN))) {
        memcpy(&x->plan, &law->trial, sizeof x->plan);
        x->reference = *now;
        x->planned.nodes = 0;
        if (x->strained && may_be_flown(&x->plan)) {
            controller_planned_keep_motion(&x->plan, law->workspace.x[law->workspace.now], &x->planned);
        }
    }
    x->challenged = !of_search && has_come(x, early);
    if (of_search) {
        x->search.ready = x->provisional = false;
        x->next_challenge = x->t + CHALLENGE_PERIOD * x->scales.time;
    }
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
}

/* The search goes on, or begins where a plan is wanted or challenged: at the first sample from where the satellite is, then from
 * where it is expected to be when the search ends. Until then all goes on as it was. */
static void go_on_searching(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                            const Motion *now, const Standing *s, double search_time, int32_t *work)
{
    Search *search = &x->search;
    const double T = x->scales.time, early = SAMPLE_EARLY * law->p.control_period;
    const bool challenge = has_wheel(model) ? x->phase == PHASE_ACQUISITION || (x->longer <= 0 && x->plan.cost > HOLD_COST * T)
                                            : x->plan.cost > controller_planned_rods_cost(model);
    if (s->lost && search->ready && x->t > search->t + SEARCH_KEPT * T) {
        search->ready = false;
    }
    if (s->near && !search->active && !search->ready &&
        (x->phase == PHASE_STEERING || (challenge && x->t >= x->next_challenge - early))) {
        const Motion then = expected(x, model, ahead, &x->plan, now, x->t, search_time);
        controller_planned_search_begin(&then, x->t + search_time, controller_planned_is_urgent(x, model), search);
    }
    controller_planned_search_on(model, ahead, law->p.search_iterations, search, &law->workspace, work);
}

/* Without an earlier command to go on with: what the search has come to in the first sample is flown until it ends. */
static void fly_what_there_is(ControllerPlannedState *x, const Motion *now)
{
    if (may_be_flown(&x->search.best)) {
        memcpy(&x->plan, &x->search.best, sizeof x->plan);
        x->phase = PHASE_ACQUISITION;
        x->provisional = true;
        x->reference = *now;
        x->steering = (Steering){{0.0, 0.0, 0.0}, 0.0};
    }
}

/* What a rod gives of dipole_max on average. */
static double rods_share(const ControllerPlannedLaw *law, const Identification *id)
{
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        sum += law->p.rod_limits[i] * fabs(id->p[GAINS + i]);
    }
    return sum / 3.0;
}

static void steer(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Standing *s, double dt,
                  bool due, int32_t *work)
{
    if (due) {
        *work -= WORK_STEERING;
        const double dipole = STEERING_DIPOLE * law->p.dipole_max * rods_share(law, &x->identification);
        controller_planned_steer(ahead, x->t, s->D_N, dipole, x->scales.time, law->steering_field, &x->steering);
    } else {
        x->steering.time = larger(x->steering.time - dt, 0.0);
    }
    x->reference = (Motion){s->target.R, s->target.Omega, 0.0};
    x->plan.stages = 0;
    x->plan.cost = 0.0;
    x->challenged = x->provisional = false;
}

/* s: since when it lasts, by when it did so before; infinite where it does not. */
static double since(bool lasts, double before, double t)
{
    return lasts ? smaller(before, t) : INFINITY;
}

void controller_planned_decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Motion *now,
                               double dt, bool first)
{
    if (!x->rods_alone && law->p.find_failures && controller_planned_wheel_stuck(&x->friction)) {
        x->rods_alone = true;
        controller_planned_give_up(x, now); /* what was planned with the wheel */
    }
    const Model model = controller_planned_believed(law, x);
    if (ahead->target_kind == ONBOARD_TARGET_NONE) {
        controller_planned_give_up(x, now);
        return;
    }
    if (x->phase == PHASE_DAMPING) {
        x->phase = PHASE_STEERING;
        x->next_plan = x->t;
    }
    const int samples = first ? 0 : has_wheel(&model) ? SEARCH_SAMPLES : RODS_SEARCH_SAMPLES;
    const double search_time = samples * law->p.control_period;
    const Standing s = standing_of(x, &model, ahead, now, search_time);
    const double early = SAMPLE_EARLY * law->p.control_period;
    const bool settled = s.angle < SETTLED_ANGLE && s.rate < 1.0 / (SETTLED_RATE_TIME * x->scales.time);
    x->settled_since = since(settled, x->settled_since, x->t);
    x->loaded_since = since(s.loaded && x->phase == PHASE_HOLD, x->loaded_since, x->t);

    int32_t work = WORK_OF_SAMPLE;
    const bool due = change_phase(x, &s, early);
    if (due) {
        x->next_plan = x->t + model.scales.plan_period;
    }
    if (x->phase == PHASE_STEERING) {
        steer(law, x, ahead, &s, dt, due, &work);
    } else if (due || x->challenged) {
        replan(law, x, &model, ahead, now, early, &work);
    }
    go_on_searching(law, x, &model, ahead, now, &s, search_time, &work);
    if (first && !s.lost) {
        fly_what_there_is(x, now);
    }
}
