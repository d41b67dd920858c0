/* Acquisition and hold within the limits of rods and wheel: the total momentum is steered first, then a receding-horizon
 * plan brings the satellite to its target, and the law [8] of Sanyal and Lee-Ho, AIAA 2009-5902, tracks the plan.
 *
 * Flight code: plain functions of plain structures, no memory but `ControllerPlannedState` (and the workspace in
 * `ControllerPlannedLaw`, whose content matters within one call only), bounded time, no recursion.
 * Use: check and prepare once (and again after a change of parameters), start once, then step at every sample.
 * SI units and radians; frames as in ports.h. A function that returns false has noted a fault.
 */
#ifndef CONTROLLER_PLANNED_H
#define CONTROLLER_PLANNED_H

#include "fault.h"
#include "identification.h"
#include "plan.h"
#include "ports.h"
#include "steering.h"

typedef enum { PHASE_STEERING = 1, PHASE_ACQUISITION = 2, PHASE_HOLD = 3 } Phase;

typedef struct {
    double t;              /* s */
    double until_sample;   /* s, until the control acts next */
    double next_plan;      /* s */
    double next_challenge; /* s */
    double settled_since;  /* s; beyond t while not settled */
    int32_t phase;
    bool sampled;          /* whether the control has acted at t */
    Steering steering;
    Plan plan;
    Search search;
    Motion reference;      /* of the plan, at t_sample */
    Vector field_bias_N;   /* measured field less that of the onboard model */
    double l_own;          /* wheel momentum by the controller's own account */
    Identification identification;
    /* The last sample. */
    double t_sample;
    Motion measured;
    /* The estimate at the sample: before the measurement, how far the measurement moved it, after it. */
    Motion predicted, estimate;
    double attitude_gain, rate_gain;
    Vector B_B;
    double u[CONTROLS];    /* asked for since */
    ControllerPlannedOutputs held;
} ControllerPlannedState;

/* Parameters and what follows from them alone. */
typedef struct {
    ControllerPlannedParameters p;
    Matrix R_d0;        /* projected onto SO(3) */
    Vector rod_axes[3]; /* unit */
    OnboardField field;
    Workspace workspace;
    Plan trial;
    Vector steering_field[STEERING_NODES];
} ControllerPlannedLaw;

bool controller_planned_check(const ControllerPlannedParameters *p, Fault *f);

/* p must have passed the check. */
void controller_planned_prepare(const ControllerPlannedParameters *p, ControllerPlannedLaw *law);

/* The state at t = 0, with the first steering or plan. */
bool controller_planned_start(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x, Fault *f);

/* The law [8] at x->t on the plan that is flown, or what is held between two samples. */
bool controller_planned_outputs(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, ControllerPlannedOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool controller_planned_step(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, double h,
                             ControllerPlannedOutputs *y, Fault *f);

#endif
