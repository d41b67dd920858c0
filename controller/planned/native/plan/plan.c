/* docs/how/planned-plan.md, Acquisition. Tests: test_plan.py. */
#include "plan.h"

#include <string.h>

/* In the satellite's time T. */
static const double HORIZON = 30.0, FINE_UNTIL = 10.0;
static const double STAGE_FINE = 0.2, STAGE_COARSE = 0.5; /* before and after FINE_UNTIL */
static const double FAST = 0.4, FASTER = 0.8;             /* rad in a stage, which is then halved and quartered */
static const double URGENT_HORIZON = 7.0;                 /* of an urgent plan */
static const double SOONER = 0.8; /* of the time that a plan takes, in which the next is to do it */
static const double EARLY = 1e-7; /* of its length: an end is reached that much before its time */

/* A stage of a plan, and when it begins, s. */
typedef struct {
    int stage;
    double begin;
} Place;

/* The controls at t, which does not lie before the place; the place is that of t then. */
static void controls_at(const Plan *plan, double t, Place *place, double u[CONTROLS])
{
    while (place->stage < plan->stages && t >= place->begin + (1.0 - EARLY) * plan->h[place->stage]) {
        place->begin += plan->h[place->stage++];
    }
    if (place->stage < plan->stages) {
        memcpy(u, plan->u[place->stage], sizeof plan->u[0]);
    } else {
        memset(u, 0, sizeof plan->u[0]);
    }
}

void controller_planned_plan_at(const Plan *plan, double t, double u[CONTROLS])
{
    Place place = {0, plan->start};
    controls_at(plan, t, &place, u);
}

bool controller_planned_better(const Plan *plan, const Plan *other, double t, double share)
{
    if (!may_be_flown(plan)) {
        return false;
    }
    if (plan->urgent && plan->settles < t + share * (other->settles - t)) {
        return true;
    }
    return (!plan->urgent || plan->settles <= other->settles) && plan->cost < share * other->cost;
}

void controller_planned_hasten(Plan *plan)
{
    plan->until = smaller(plan->until, plan->start + SOONER * (plan->settles - plan->start));
}

static void survey_stage(const Ahead *ahead, double t, double h, Stage *stage)
{
    stage->around = controller_planned_around_at(ahead, t + 0.5 * h);
    stage->target = controller_planned_target_at(ahead, t);
}

void controller_planned_survey(const Ahead *ahead, const Plan *plan, Stage stage[STAGES + 1], int32_t *work)
{
    double t = plan->start;
    for (int i = 0; i < plan->stages; ++i) {
        survey_stage(ahead, t, plan->h[i], &stage[i]);
        t += plan->h[i];
    }
    stage[plan->stages].target = controller_planned_target_at(ahead, t);
    spend(work, plan->stages * WORK_SURVEY);
}

Horizon controller_planned_horizon(double T)
{
    const double fine_until = FINE_UNTIL * T, end = HORIZON * T, fine = STAGE_FINE * T, coarse = STAGE_COARSE * T;
    return (Horizon){{fine_until, end, end}, {fine, coarse, coarse}}; /* the last piece has no stages */
}

/* How many whole stages are left from s on. */
static int stages_left(const Horizon *horizon, double s, double end)
{
    int stages = 0;
    for (int i = 0; i < PIECES; ++i) {
        const double begin = i > 0 ? horizon->until[i - 1] : 0.0, until = smaller(horizon->until[i], end);
        stages += whole_part(larger(until - larger(s, begin), 0.0) / horizon->stage[i], STAGES);
    }
    return stages;
}

void controller_planned_lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, bool urgent,
                                   const Plan *was, Plan *plan, Stage stage[STAGES + 1], int32_t *work)
{
    const Horizon *horizon = &model->horizon;
    const double early = EARLY * horizon->until[0];
    const double length = urgent ? URGENT_HORIZON * model->scales.time : horizon->until[PIECES - 1];
    Motion now = x != NULL ? *x : (Motion){identity, {0.0, 0.0, 0.0}, 0.0};
    Place place = {0, was != NULL ? was->start : 0.0};
    double s = 0.0;
    int piece = 0, stages = 0;
    memset(plan, 0, sizeof *plan); /* to the last byte: plans are part of a saved state */
    plan->start = t;
    plan->urgent = urgent;
    plan->until = was != NULL ? was->until : t;
    plan->caution = was != NULL ? was->caution : 0.0;
    while (s < length - early && stages < STAGES) {
        while (piece < PIECES - 1 && s >= horizon->until[piece] - early) {
            ++piece;
        }
        const double whole = horizon->stage[piece];
        /* A stage is divided while enough stages are left for the rest of the horizon. */
        const int left = STAGES - stages - stages_left(horizon, s, length) - 1;
        const double turn = x != NULL ? norm(now.Omega) * whole : 0.0;
        const int wanted = turn > FASTER ? 4 : turn > FAST ? 2 : 1;
        const int parts = left >= 4 ? wanted : 1;
        for (int i = 0; i < parts && stages < STAGES; ++i) {
            const double h = whole / parts;
            const int k = stages++;
            plan->h[k] = h;
            survey_stage(ahead, t + s, h, &stage[k]);
            double *u = plan->u[k];
            memset(u, 0, sizeof plan->u[0]);
            if (was != NULL) {
                controls_at(was, t + s + 0.5 * h, &place, u);
            }
            now = x != NULL ? controller_planned_advanced(model, &stage[k].around, &now, u, h) : now;
            s += h;
        }
    }
    plan->stages = stages;
    stage[stages].target = controller_planned_target_at(ahead, t + s);
    spend(work, stages * WORK_LAY);
}
