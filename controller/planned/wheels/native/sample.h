/* What the parts of a sample share: docs/how/planned-wheels.md. */
#ifndef CONTROLLER_PLANNED_WHEELS_SAMPLE_H
#define CONTROLLER_PLANNED_WHEELS_SAMPLE_H

#include "controller_planned_wheels.h"

/* What is wanted at a sample. */
typedef struct {
    bool attitude; /* else only the rate counts */
    Matrix R;
    Vector Omega, dOmega; /* in axes of the desired body */
} Target;

/* What there is at a sample. */
typedef struct {
    Target target;
    Matrix Q;          /* body to desired body; one without an attitude */
    Vector zeta, rate; /* errors from the target, in its axes and in body axes: (5) */
    double angle;      /* pi without an attitude */
    Vector h, H;       /* of the wheels, and of all beyond the target: (6) */
    bool works[WHEELS_MAX];
    Zonotope torque, momentum; /* of the wheels that work */
    bool reduced;              /* they leave a direction out */
    double most, held;         /* N m, N m s, in any direction */
    double k;                  /* bandwidth, rad/s */
} Sample;

/* The errors from the plan, in body axes: (5). */
typedef struct {
    Vector zeta, omega, dOmega_d_B;
} Errors;

/* What the inputs are, with the wheels that have not failed. */
bool controller_planned_wheels_take_sample(const ControllerPlannedWheelsLaw *law, const bool failed[WHEELS_MAX],
                                           const ControllerPlannedWheelsInputs *u, Sample *s, Fault *f);

/* (4), (5): the plan, which is the target but for the angle that is left of a turn. `mean` s are those over which its
 * acceleration is the mean. */
Target controller_planned_wheels_plan_at(const ControllerPlannedWheelsState *x, const Target *target, double mean);

Errors controller_planned_wheels_errors_of(const Target *plan, Matrix R, Vector Omega);

/* What is done from this sample on: (8). */
void controller_planned_wheels_decide(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsInputs *u, bool first,
                                      ControllerPlannedWheelsState *x);

/* (10): each wheel's part of their torque `wanted` on the body, and what evens out their momenta. */
void controller_planned_wheels_share(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                     const double h_w[WHEELS_MAX], Vector wanted, double of_wheels[WHEELS_MAX]);

#endif
