/* docs/how/planned-plan.md, Renewal. Tests: test_renew.py. */
#include "renew.h"

static const double HOLD_ORBITS = 0.25; /* that a hold's plan sees at least */
static const double STAGE_LONG = 1.0;   /* T, of the stages that this takes */
static const double LONGER_MAX = 80.0;  /* so many of them at most: else they are longer */

enum { ITERATIONS = 5 }; /* of a plan at every renewal */

/* What a hold's plan lacks: the stages behind the usual horizon, and how long each is, s. */
static int32_t behind(const Model *model, bool strained, double *stage)
{
    const double T = model->scales.time, orbits = strained ? STRAINED_ORBITS_AHEAD : HOLD_ORBITS;
    const double wanted = orbits * model->scales.period;
    const double lacks = larger(wanted - model->horizon.until[PIECES - 1], 0.0);
    *stage = larger(STAGE_LONG * T, lacks / LONGER_MAX);
    return whole_part(lacks / *stage + 0.5, STAGES);
}

/* The horizon longer by so many stages at its end; or shorter, but for its first piece. */
static Horizon with_stages(const Horizon *usual, int32_t longer, double stage)
{
    Horizon horizon = *usual;
    if (longer > 0) {
        horizon.until[2] += longer * stage;
        horizon.stage[2] = stage;
    } else {
        horizon.until[1] += longer * horizon.stage[1];
        horizon.until[2] = horizon.until[1];
    }
    return horizon;
}

/* law->trial over the model's horizon, from the motion that was kept, or else from the controls that were; whether
 * from the motion. */
static bool improve(ControllerPlannedLaw *law, const ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                    const Motion *expected, const Motion *now, bool urgent, const Plan *was, int32_t *work)
{
    Workspace *w = &law->workspace;
    const bool kept = x->strained && x->planned.nodes > 0 && was == &x->plan;
    controller_planned_lay_stages(model, ahead, kept ? NULL : now, x->t, urgent, was, &law->trial, w->stage, work);
    if (kept) {
        spend(work, law->trial.stages * WORK_GUESS);
        controller_planned_guess(&x->planned, w->stage, &law->trial, w->x[0]);
        controller_planned_improve_guess(model, now, ITERATIONS, &law->trial, w, work);
    } else {
        controller_planned_improve(model, expected, now, ITERATIONS, &law->trial, w, work);
    }
    return kept;
}

bool controller_planned_renew(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *usual,
                              const Ahead *ahead, const Motion *expected, const Motion *now, const Plan *was,
                              int32_t *work)
{
    const bool urgent = controller_planned_is_urgent(x, usual), hold = x->phase == PHASE_HOLD && has_wheel(usual);
    double stage;
    const int32_t most = behind(usual, x->strained, &stage);
    const double second = usual->horizon.until[1] - usual->horizon.until[0];
    const int32_t least = -whole_part(second / usual->horizon.stage[1] + 0.5, STAGES);
    Model model = *usual;
    x->longer = !hold ? 0 : x->longer < most ? x->longer + 1 : most;
    for (;;) {
        model.horizon = hold ? with_stages(&usual->horizon, x->longer, stage) : usual->horizon;
        const bool kept = improve(law, x, &model, ahead, expected, now, urgent, was, work);
        controller_planned_hasten(&law->trial);
        const bool lost =
            hold && (x->strained ? !may_be_flown(&law->trial) : law->trial.cost > HOLD_COST * x->scales.time);
        if (lost && kept && x->longer <= 0) {
            x->planned.nodes = 0;
        }
        if (!lost || x->longer <= least) {
            return true;
        }
        x->longer = (x->longer + least - 1) / 2;
        if (*work < STAGES * (WORK_LAY + WORK_ROLLOUT + WORK_OF_ITERATION)) {
            return false;
        }
    }
}
