/* What surrounds the satellite as a function of time alone: field and air along its orbit.
 *
 * Both are evaluated at nodes 10 s apart and interpolated by degree 5 through the six nearest, which errs by less than
 * 1e-3 nT. The nodes follow from the parameters alone, so keeping some of them is no memory of the block. */
#ifndef ENVIRONMENT_H
#define ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "atmosphere.h"
#include "geomagnetic.h"
#include "orbit.h"

enum { NODES = 16 };

typedef struct {
    int64_t number; /* its time over the interval */
    bool known;
    Vector b_N;     /* T */
    Vector flow_N;  /* velocity relative to the air, m/s */
    double log_density;
} Node;

/* At a time. */
typedef struct {
    double t;
    bool known;
    Motion motion;  /* of the satellite, N */
    Vector b_N;     /* T */
    Vector flow_N;  /* m/s */
    double density; /* kg/m3; 0 without air */
} Surroundings;

typedef struct {
    Orbit orbit;
    double gmst0; /* rad, at t = 0 */
    double day0;  /* of the year, 1.0 at its start, at t = 0 */
    Field field;
    bool has_air;
    Activity activity;
    Node nodes[NODES];  /* that of a number in the place number mod NODES */
    Surroundings last;  /* a step ends where the next one starts */
} Environment;

/* Forgets what was kept; to be called when anything above `nodes` has been set. */
void forget_surroundings(Environment *environment);

/* Valid until the next call. */
const Surroundings *surroundings_at(Environment *environment, double t);

#endif
