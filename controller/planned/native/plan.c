#include "plan.h"

#include <string.h>

/* In the satellite's time T. */
static const double HORIZON = 30.0, FINE_UNTIL = 10.0;
static const double STAGE_FINE = 0.2, STAGE_COARSE = 0.5; /* before and after FINE_UNTIL */
static const double FAST = 0.4, FASTER = 0.8;             /* rad in STAGE_FINE; stages are halved and quartered */
static const double EARLY = 1e-7;                         /* of its length: an end is reached that much before its time */

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
    *work -= plan->stages * WORK_SURVEY;
}

void controller_planned_lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, const Plan *was,
                                   Plan *plan, Stage stage[STAGES + 1], int32_t *work)
{
    const double T = model->scales.time, fine = STAGE_FINE * T, coarse = STAGE_COARSE * T;
    const double fine_until = FINE_UNTIL * T, horizon = HORIZON * T, early = EARLY * fine_until;
    Motion now = *x;
    Place place = {0, was != NULL ? was->start : 0.0};
    double s = 0.0;
    memset(plan, 0, sizeof *plan); /* to the last byte: plans are part of a saved state */
    plan->start = t;
    while (s < horizon - early) {
        const double whole = s < fine_until - early ? fine : coarse;
        /* A stage is divided while enough stages are left for the rest of the horizon. */
        const int left = STAGES - plan->stages - (int)((fine_until - smaller(s, fine_until)) / fine) -
                         (int)((horizon - larger(s, fine_until)) / coarse) - 1;
        const double turn = norm(now.Omega) * whole;
        const int wanted = turn > FASTER ? 4 : turn > FAST ? 2 : 1;
        const int parts = left >= 4 ? wanted : 1;
        for (int i = 0; i < parts; ++i) {
            const double h = whole / parts;
            const int k = plan->stages++;
            plan->h[k] = h;
            survey_stage(ahead, t + s, h, &stage[k]);
            double *u = plan->u[k];
            memset(u, 0, sizeof plan->u[0]);
            if (was != NULL) {
                controls_at(was, t + s + 0.5 * h, &place, u);
            }
            now = controller_planned_advanced(model, &stage[k].around, &now, u, h);
            s += h;
        }
    }
    stage[plan->stages].target = controller_planned_target_at(ahead, t + s);
    *work -= plan->stages * WORK_LAY;
}
