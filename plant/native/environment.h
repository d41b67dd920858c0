/* The satellite's surroundings as a function of time alone: gravity, field and air along its orbit.
 *
 * All are evaluated at nodes 10 s apart and interpolated by degree 5 through the six nearest, which errs by less
 * than 1e-3 nT. Nodes and polynomials follow from the parameters alone, so keeping some of them is no memory of the
 * block. */
#ifndef PLANT_ENVIRONMENT_H
#define PLANT_ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "atmosphere.h"
#include "geomagnetic.h"
#include "orbit.h"
#include "sun.h"

enum { NODES = 16 };

/* The quantities that are interpolated. */
typedef struct {
    Vector b_N;    /* T */
    Vector pull_N; /* sqrt(3 mu/r^3) r_hat, 1/s: the gravity gradient's moment is pull x J pull [2] */
    Vector flow_N; /* velocity relative to the air, m/s */
    double log_density;
} Along;

typedef struct {
    int64_t number; /* its time over the interval */
    bool known;
    Along along;
} Node;

enum { POWERS = 6, VALUES = sizeof(Along) / sizeof(double) };

/* From one node to the next: the polynomials of u in [0, 1), each value's coefficient of u^k in row k. */
typedef struct {
    int64_t number; /* of the node at u = 0 */
    bool known;
    double coefficients[POWERS][VALUES];
} Stretch;

/* At a time. */
typedef struct {
    double t;
    bool known;
    Along along;
    double density; /* kg/m3; 0 without air */
} Surroundings;

typedef struct {
    Orbit orbit;
    double gmst0; /* rad, at t = 0 */
    double day0;  /* of the year, 1.0 at its start, at t = 0 */
    Field field;
    bool has_air;
    Activity activity;
    double mu;         /* m3/s2 */
    Node nodes[NODES]; /* that of a number in the place number mod NODES */
    Stretch stretch;   /* the last one asked for */
    Surroundings last; /* a step ends where the next one starts */
    Sun sun;
} Environment;

/* Forgets what was kept; to be called when anything above `nodes` has been set. */
void plant_forget_surroundings(Environment *environment);

/* Valid until the next call. */
const Surroundings *plant_surroundings_at(Environment *environment, double t);

#endif
