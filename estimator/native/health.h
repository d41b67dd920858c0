/* Which sensors are to be believed: those that repeat themselves, and those with which the others do not agree. */
#ifndef ESTIMATOR_HEALTH_H
#define ESTIMATOR_HEALTH_H

#include "vector.h"

#include <stdint.h>

/* As the inputs count them, and the output `health`. */
enum { SENSOR_RATE, SENSOR_FIELD, SENSOR_ORBIT, SENSOR_ATTITUDE, SENSOR_SUN, SENSORS };

enum { HEALTH_NONE, HEALTH_GOOD, HEALTH_FROZEN, HEALTH_INCONSISTENT, HEALTH_JUMPED };

/* s for which a sensor that was wrong has to be right: a quarter of an orbit. */
static const double ESTIMATOR_CALM = 1500.0;

/* What is kept of a sensor. */
typedef struct {
    double last[3];             /* of its measurement */
    int32_t run[3], longest[3]; /* measurements in turn that repeat an element; the most that ended by themselves */
    int32_t changes;            /* measurements that did not, up to so many as count */
    bool seen, frozen, suspect;
    double mean[3]; /* of its innovations over their deviations */
    double calm;    /* s for which that mean has been small */
    double since;   /* s from its last measurement */
    double usual;   /* mean square of its changes that are not expected */
    Vector jump;    /* the last one that was far beyond */
    double jumped;  /* s since */
} Watch;

/* A new measurement v, of which `every` element, or one, has to repeat to the bit. */
void estimator_notice(const double v[3], bool every, Watch *w);

/* A new innovation over its deviation, `since` s after the last one. Returns whether its mean is that of a failure. */
bool estimator_weigh(const double scaled[3], double since, bool within_gate, Watch *w);

/* Whether a change of which `off` is not expected is a jump: longer than `least`, and far longer than is usual. */
bool estimator_jumps(Vector off, double least, Watch *w);

/* The mean goes on by a value, each of its elements at most 5, `since` s after the last one. */
void estimator_average(const double value[3], double since, double mean[3]);

/* Whether it repeats itself, but not yet for long: what it says is not weighed meanwhile. */
bool estimator_repeats(const Watch *w);

bool estimator_trusted(const Watch *w);

/* Whether a sensor that is frozen jumped just before: to its last value. */
bool estimator_jumped_to_rest(const Watch *w);

int32_t estimator_health(const Watch *w);

#endif
