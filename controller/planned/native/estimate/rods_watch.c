/* docs/how/planned-estimates.md, Failures. Tests: test_failures.py. */
#include "rods_watch.h"

static const double FADES = 4.0;       /* T, over which innovations lose their say */
static const double TOO_FAST = 15.0;   /* 1/T, rate above which nothing is watched */
static const double AFTER_FAST = 10.0; /* T, for which nothing is watched after such a rate */
static const double PAUSE_MAX = 8.0;   /* T, of the pause after a suspicion */
static const double SUSPECTED = 25.0;  /* squared deviations of the gains' changes */

/* The sums begin again, after a pause, s. */
static void begin_anew(double pause, RodsWatch *watch)
{
    watch->M = (Matrix){{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    watch->z = (Vector){0.0, 0.0, 0.0};
    watch->paused = pause;
}

bool controller_planned_watch_rods(double dt, double T, Vector rate, double S, RodsWatch *watch)
{
    if (watch->rate > TOO_FAST / T) { /* an error of the inertia says more than the rods */
        begin_anew(larger(watch->paused, AFTER_FAST * T), watch);
    }
    if (watch->paused > 0.0) {
        watch->paused -= dt;
        return false;
    }
    const double kept = 1.0 - smaller(dt / (FADES * T), 1.0);
    const Matrix E = {watch->effect[0], watch->effect[1], watch->effect[2]};
    watch->M = sum(times(kept, watch->M), times(1.0 / S, multiply(E, transposed(E))));
    watch->z = add(scale(kept, watch->z), scale(1.0 / S, apply(E, rate)));
    return dot(watch->z, solve(sum(watch->M, identity), watch->z)) > SUSPECTED;
}

void controller_planned_pause_watch(double T, RodsWatch *watch)
{
    begin_anew(watch->pause, watch);
    watch->pause = smaller(2.0 * watch->pause, PAUSE_MAX * T);
}
