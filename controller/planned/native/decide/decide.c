/* The sample's decision: the phase, and the plan or the steering that is flown. docs/how/planned.md, Phases.
 * It gives up a wheel that is stuck, and takes it again. A rod that has failed needs no decision: plan and steering use
 * the gains that are estimated, and the output `failed_rod` only reports it.
 * Tests: test_closed_loop.py, test_block.py. */
#include "../plan/cost.h"
#include "../plan/renew.h"
#include "phases.h"

#include <string.h>

static const int SEARCH_SAMPLES = 16;       /* that a search is expected to take */
static const double CHALLENGE_PERIOD = 0.6; /* T */
static const double CHALLENGE_GAIN = 0.97;  /* a challenger is adopted below this share of the plan's time, or cost */
static const double STEERING_DIPOLE = 1.12; /* of dipole_max: what three rods give across the field */
static const double SEARCH_KEPT = 0.4;      /* T, for which the plan of a search is good enough to begin with */

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
            u[3] = wheel_to_rest(model, then.l, PLAN_PERIOD * model->scales.time);
            steering.time = larger(steering.time - h, 0.0);
        } else {
            controller_planned_plan_at(plan, t + (i + 0.5) * h, u);
        }
        then = controller_planned_advanced(model, &around, &then, u, h);
    }
    return then;
}

/* The plan from now on: the one that was; or the one of the search, where there is none, or in the sample after
 * where it is better. */
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
    x->challenged = !of_search && controller_planned_plan_has_come(x, early);
    if (of_search) {
        x->search.ready = x->provisional = false;
        const double rest = CHALLENGE_PERIOD * x->scales.time;
        const bool rests = !has_wheel(model) && !controller_planned_rods_are_poor(model, &x->plan);
        x->next_challenge = x->t + (rests ? controller_planned_rods_rest(model) : rest);
    }
    x->steering.lambda_N = (Vector){0.0, 0.0, 0.0};
}

/* The search goes on, or begins where a plan is wanted or challenged: at the first sample from where the satellite
 * is, then from where it is expected to be when the search ends. Until then all goes on as it was. */
static void go_on_searching(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *model,
                            const Ahead *ahead, const Motion *now, const Standing *s, double search_time, int32_t *work)
{
    Search *search = &x->search;
    const double T = x->scales.time, early = SAMPLE_EARLY * law->p.control_period;
    const bool challenge = has_wheel(model)
                               ? x->phase == PHASE_ACQUISITION || (x->longer <= 0 && x->plan.cost > HOLD_COST * T)
                               : x->plan.cost > controller_planned_rods_cost(model);
    const bool poor = !has_wheel(model) && controller_planned_rods_are_poor(model, &x->plan);
    if (s->lost && search->ready && x->t > search->t + SEARCH_KEPT * T) {
        search->ready = false;
    }
    if (s->near && !search->active && !search->ready &&
        (x->phase == PHASE_STEERING || (challenge && (poor || x->t >= x->next_challenge - early)))) {
        const Motion then = expected(x, model, ahead, &x->plan, now, x->t, search_time);
        controller_planned_search_begin(&then, x->t + search_time, controller_planned_is_urgent(x, model), search);
    }
    controller_planned_search_on(model, ahead, law->p.search_iterations, search, &law->workspace, work);
}

/* Without an earlier command to go on with: what the search has come to in the first sample is flown until it ends. */
static void fly_what_there_is(ControllerPlannedState *x, const Motion *now)
{
    if (may_be_flown(&x->search.best)) {
        controller_planned_change_phase(x, EVENT_PLAN, now);
        memcpy(&x->plan, &x->search.best, sizeof x->plan);
        x->provisional = true;
        x->reference = *now;
        x->steering = (Steering){{0.0, 0.0, 0.0}, 0.0};
    }
}

static void steer(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Standing *s,
                  double dt, bool due, int32_t *work)
{
    if (due) {
        spend(work, WORK_STEERING);
        const double share = controller_planned_rods_share(&law->p, x->identification.p + GAINS);
        const double dipole = STEERING_DIPOLE * law->p.dipole_max * share;
        controller_planned_steer(ahead, x->t, s->D_N, dipole, x->scales.time, law->steering_field, &x->steering);
    } else {
        x->steering.time = larger(x->steering.time - dt, 0.0);
    }
    x->reference = (Motion){s->target.R, s->target.Omega, 0.0};
    x->plan.stages = 0;
    x->plan.cost = 0.0;
    x->challenged = x->provisional = false;
}

void controller_planned_decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead,
                               const Motion *now, double dt, bool first)
{
    if (x->rods_alone == x->friction.stuck && law->p.find_failures && controller_planned_wheel_changes(&x->friction)) {
        x->rods_alone = x->friction.stuck;
        controller_planned_change_phase(x, EVENT_WHEEL, now);
    }
    const Model model = controller_planned_estimated(law, x);
    const bool target = ahead->target_kind != ONBOARD_TARGET_NONE;
    const bool flies = target && !x->doubted;
    bool due = controller_planned_change_phase(x, flies ? EVENT_TARGET : EVENT_NO_TARGET, now);
    if (!flies) {
        return;
    }
    const int samples = first ? 0 : has_wheel(&model) ? SEARCH_SAMPLES : RODS_SEARCH_SAMPLES;
    const double search_time = samples * law->p.control_period, early = SAMPLE_EARLY * law->p.control_period;
    const Standing s = controller_planned_standing(x, &model, ahead, now, search_time);
    const unsigned events = controller_planned_events(x, &s, early);
    due = due || x->t >= x->next_plan - early || (x->provisional && x->search.ready);
    due = controller_planned_change_phase(x, events, now) || due;
    controller_planned_update_strain(x, &s);

    int32_t work = WORK_OF_SAMPLE;
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
