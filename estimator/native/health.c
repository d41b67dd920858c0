/* Requirement: ES-4. Tests: tests/native/test_flavours.py; docs/how/health.md derives each threshold. */
#include "health.h"

enum { FEW = 3, REPEATS = 20 };      /* measurements that repeat the last one, for each that did so before in turn */
static const double AVERAGED = 60.0; /* s over which innovations are averaged */
static const double LIMIT = 5.0;     /* of an innovation over its deviation, in the average */
static const double WRONG = 1.5;     /* length of the average from which on a sensor is wrong */
static const double RIGHT = 0.75;    /* and below which it is right again */
static const double JUMP = 8.0;      /* of the root mean square of what is usual */
static const double USUAL = 10.0;    /* s over which that is averaged */
static const double JUST = 30.0;     /* s from a jump until the sensor is found to be frozen */

void estimator_notice(const double v[3], bool every, Watch *w)
{
    int still = 0, moved = 0;
    for (int i = 0; i < 3; ++i) {
        if (w->seen && v[i] == w->last[i]) {
            w->run[i] = w->run[i] < INT32_MAX ? w->run[i] + 1 : INT32_MAX;
        } else {
            w->longest[i] = !w->frozen && w->run[i] > w->longest[i] ? w->run[i] : w->longest[i];
            w->run[i] = 0;
            ++moved;
        }
        still += w->run[i] / REPEATS > w->longest[i] ? 1 : 0;
        w->last[i] = v[i];
    }
    w->seen = true;
    const bool stands = still >= (every ? 3 : 1), changed = moved >= (every ? 1 : 3);
    if (changed && w->changes < REPEATS) {
        ++w->changes;
    }
    if (w->changes == REPEATS && stands != w->frozen) {
        w->frozen = stands;
        w->changes = stands ? 0 : REPEATS;
        w->mean[0] = w->mean[1] = w->mean[2] = 0.0;
    }
}

bool estimator_jumps(Vector off, double least, Watch *w)
{
    const double square = dot(off, off), most = JUMP * JUMP * w->usual;
    const bool jumps = w->changes == REPEATS && square > least * least && square > most;
    w->usual += (w->since < 1.0 ? w->since : 1.0) / USUAL * ((jumps ? most : square) - w->usual);
    if (jumps) {
        w->jump = off;
        w->jumped = 0.0;
    }
    return jumps;
}

bool estimator_jumped_to_rest(const Watch *w)
{
    return w->frozen && w->jumped < JUST;
}

void estimator_average(const double value[3], double since, double mean[3])
{
    const double share = (since < 1.0 ? since : 1.0) / AVERAGED;
    for (int i = 0; i < 3; ++i) {
        const double bounded = value[i] > LIMIT ? LIMIT : value[i] < -LIMIT ? -LIMIT : value[i];
        mean[i] += share * (bounded - mean[i]);
    }
}

bool estimator_weigh(const double scaled[3], double since, bool within_gate, Watch *w)
{
    estimator_average(scaled, since, w->mean);
    const double size = norm(vector(w->mean));
    w->calm = within_gate && size < RIGHT ? w->calm + since : 0.0;
    if (w->suspect && w->calm > ESTIMATOR_CALM) {
        w->suspect = false;
    }
    return size > WRONG;
}

bool estimator_repeats(const Watch *w)
{
    return w->changes == REPEATS && (w->run[0] >= FEW || w->run[1] >= FEW || w->run[2] >= FEW);
}

bool estimator_trusted(const Watch *w)
{
    return !w->frozen && !w->suspect;
}

int32_t estimator_health(const Watch *w)
{
    if (w->frozen) {
        return HEALTH_FROZEN;
    }
    if (w->suspect) {
        return HEALTH_INCONSISTENT;
    }
    if (w->jumped < ESTIMATOR_CALM) {
        return HEALTH_JUMPED;
    }
    return w->seen ? HEALTH_GOOD : HEALTH_NONE;
}
