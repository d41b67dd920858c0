/* The table of phases: docs/how/planned.md, Phases. Requirement: PL-2.
 * Tests: test_hold.py, test_strained.py, test_block.py, test_reference_ports.py. */
#include "phases.h"

#include "../plan/rods_alone.h"

static const double RATE_MAX = 3.0;       /* 1/T, from which a plan of all its stages still succeeds */
static const double STEERING_AGAIN = 2.0; /* of steering_limit: back to steering beyond it */
static const double SETTLED_ANGLE = 0.0174532925, SETTLED_TIME = 1.2; /* rad (1 deg), T */
static const double SETTLED_RATE_TIME = 20.0;                         /* T, in which the rate may turn by a radian */
static const double LOST_ANGLE = 0.0872664626;                        /* rad (5 deg) */
/* A hold is strained where it has been loaded, by an angle or a share of what the wheel is let hold, for so many orbits;
 * with a larger angle sooner: after so many T, in which an ordinary plan undoes what was sudden. */
static const double STRAINED_ANGLE = 0.0174532925, STRAINED_TIME = 2.0;                          /* rad (1 deg), T */
static const double LASTING_ANGLE = 0.0087266463, LASTING_MOMENTUM = 0.6, LASTING_ORBITS = 0.05; /* rad (0.5 deg) */
static const double STRAINED_ORBITS = 1.0; /* without a cause, until it is not */
static const double STRAINED_LOST = 1.0;   /* rad (57 deg) */

/* rad (30 deg): a torque may be half across what was meant; rad in T beyond the target's turn: more is no hold. */
static const double DOUBTED = 0.5235987756, TURNS = 0.3;
static const double GROWN = 2.0; /* of the least rate: a field that is more than a right angle off drives it */

enum { ANY = 0 };

/* The first row that holds is taken. */
static const struct {
    int from;
    unsigned on;
    Phase to;
    bool due; /* a plan or a steering, where the phase is another one */
} TRANSITIONS[] = {
    {ANY, EVENT_NO_ATTITUDE | EVENT_NO_TARGET | EVENT_WHEEL, PHASE_DAMPING, false},
    {PHASE_DAMPING, EVENT_TARGET, PHASE_STEERING, true},
    {ANY, EVENT_LOST, PHASE_STEERING, true},
    {PHASE_STEERING, EVENT_PLAN, PHASE_ACQUISITION, true},
    {PHASE_HOLD, EVENT_TURNED_AWAY, PHASE_ACQUISITION, false},
    {PHASE_ACQUISITION, EVENT_SETTLED, PHASE_HOLD, false},
};

/* N m s, N: what the total momentum lacks to the target's, with the wheel at rest or with the momentum that it
 * keeps. */
static Vector momentum_to_give(const Model *model, const Motion *now, const Target *target)
{
    Vector wanted = add(apply(model->J, target->Omega), model->beside_B);
    if (!has_wheel(model)) {
        wanted = add(wanted, scale(now->l, model->wheel_axis));
    }
    return subtract(apply(target->R, wanted), apply(now->R, momentum_of(model, now)));
}

/* N m s: of that, what the wheel cannot keep at the attitude R. */
static double beyond_wheel(const Model *model, Matrix R, Vector D_N)
{
    const Vector axis_N = apply(R, model->wheel_axis);
    const double l = clip(-dot(D_N, axis_N), -model->wheel_momentum_max, model->wheel_momentum_max);
    return norm(add(D_N, scale(l, axis_N)));
}

Standing controller_planned_standing(const ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                                     const Motion *now, double search_time)
{
    const Target target = controller_planned_target_at(ahead, x->t);
    const Matrix Q = multiply(transposed(target.R), now->R);
    const Vector D_N = momentum_to_give(model, now, &target);
    const bool steered = x->phase == PHASE_STEERING, wheel = has_wheel(model);
    const double whole = x->scales.steering_limit,
                 limit = wheel ? smaller(whole, RATE_MAX * x->scales.turning_moment / x->scales.time)
                               : controller_planned_rods_limit(model, now->l, steered);
    double left = norm(D_N) / limit;
    if (wheel && !steered) {
        /* A loaded wheel that is off its target's axis turns nothing: the rods have time for it. */
        const double there = beyond_wheel(model, target.R, D_N), here = beyond_wheel(model, now->R, D_N);
        left = larger(there / whole, smaller(there, here) / limit);
    }
    const double angle = principal_angle(Q), time = x->steering.time, later = larger(time - search_time, 0.0);
    const bool lost = left > (!steered && wheel ? STEERING_AGAIN : 1.0);
    return (Standing){
        .target = target,
        .angle = angle,
        .rate = norm(subtract(now->Omega, apply_transposed(Q, target.Omega))),
        .D_N = D_N,
        .lost = lost,
        .near = !lost || (steered && left * later <= time),
        .loaded = fabs(now->l) > LASTING_MOMENTUM * x->scales.wheel_momentum || angle > LASTING_ANGLE,
    };
}

void controller_planned_doubt(ControllerPlannedState *x, bool field_lost, double bound, double rate, double wanted)
{
    const bool turns = (rate - wanted) * x->scales.time > TURNS;
    x->may_doubt = x->may_doubt || x->phase == PHASE_HOLD || field_lost;
    x->doubted = x->may_doubt && bound > DOUBTED && (x->doubted || turns);
    x->least_rate = x->doubted ? smaller(x->least_rate, rate) : INFINITY;
    x->drives = x->doubted && (x->drives || rate > GROWN * x->least_rate + TURNS / x->scales.time);
}

bool controller_planned_plan_has_come(const ControllerPlannedState *x, double early)
{
    return x->search.ready && x->t >= x->search.t - early;
}

/* s: since when it lasts, by when it did so before; infinite where it does not. */
static double since(bool lasts, double before, double t)
{
    return lasts ? smaller(before, t) : INFINITY;
}

unsigned controller_planned_events(ControllerPlannedState *x, const Standing *s, double early)
{
    const bool settled = s->angle < SETTLED_ANGLE && s->rate < 1.0 / (SETTLED_RATE_TIME * x->scales.time);
    x->settled_since = since(settled, x->settled_since, x->t);
    x->loaded_since = since(s->loaded && x->phase == PHASE_HOLD, x->loaded_since, x->t);
    return (s->lost ? EVENT_LOST : 0u) | (controller_planned_plan_has_come(x, early) ? EVENT_PLAN : 0u) |
           (s->angle > (x->strained ? STRAINED_LOST : LOST_ANGLE) ? EVENT_TURNED_AWAY : 0u) |
           (x->t - x->settled_since >= SETTLED_TIME * x->scales.time - early ? EVENT_SETTLED : 0u);
}

/* All that was planned is given up; `now` is the reference. */
static void give_up(ControllerPlannedState *x, const Motion *now)
{
    x->settled_since = x->loaded_since = INFINITY;
    x->strained_until = 0.0;
    x->planned.nodes = 0;
    x->search.active = x->search.ready = x->challenged = x->provisional = x->strained = false;
    x->plan.stages = 0;
    x->plan.cost = 0.0;
    x->steering = (Steering){{0.0, 0.0, 0.0}, 0.0};
    x->reference = *now;
}

bool controller_planned_change_phase(ControllerPlannedState *x, unsigned events, const Motion *now)
{
    for (size_t i = 0; i < sizeof TRANSITIONS / sizeof TRANSITIONS[0]; ++i) {
        if ((TRANSITIONS[i].from == ANY || TRANSITIONS[i].from == x->phase) && (TRANSITIONS[i].on & events) != 0) {
            const Phase to = TRANSITIONS[i].to;
            const bool due = TRANSITIONS[i].due && x->phase != (int32_t)to;
            if (to == PHASE_DAMPING) {
                give_up(x, now);
            } else if (due && to == PHASE_STEERING) {
                x->search.active = x->search.ready = false;
            }
            x->phase = (int32_t)to;
            return due;
        }
    }
    return false;
}

void controller_planned_update_strain(ControllerPlannedState *x, const Standing *s)
{
    const double lasts = x->t - x->loaded_since, period = x->scales.period;
    const bool far = s->angle > STRAINED_ANGLE && lasts > STRAINED_TIME * x->scales.time;
    const bool beyond = x->strained && norm(vector(x->identification.p + TORQUE)) > x->scales.disturbance_max;
    const bool stuck_on = controller_planned_stuck_on(&x->identification);
    if (far || beyond || stuck_on ||
        lasts > LASTING_ORBITS * period) { /* the wheel possibly cannot keep the hold close */
        x->strained_until = x->t + STRAINED_ORBITS * period;
    }
    x->strained = x->phase == PHASE_HOLD && !x->rods_alone && x->t < x->strained_until;
}
