/* What the parts of a sample share: docs/how/planned-wheels.md. */
#ifndef CONTROLLER_PLANNED_WHEELS_SAMPLE_H
#define CONTROLLER_PLANNED_WHEELS_SAMPLE_H

#include "controller_planned_wheels.h"

static const double SHED_ABOVE = 0.9;       /* of the momentum that the wheels hold in any direction */
static const double SHED_TO = 0.7;          /* of it, where the attitude is aimed at */
static const double ROOM = 1.15;            /* of the inradius: what a turn has for rates, and momentum */
static const double SHEDDING_RODS = 1.5;    /* of the mean rod's dipole: the most of three, the mean over attitudes */
static const double UNLOADING_SOONER = 0.2; /* of unloading_time, before the hold */

/* What is wanted at a sample. */
typedef struct {
    bool attitude; /* else only the rate counts */
    Matrix R;
    Vector Omega, dOmega; /* in axes of the desired body */
} Wanted;

/* What there is at a sample. */
typedef struct {
    Wanted target;
    Matrix Q;          /* body to desired body; one without an attitude */
    Vector zeta, rate; /* errors from the target, in its axes and in body axes: (5) */
    double angle;      /* pi without an attitude */
    Vector b;          /* T, the field */
    Vector h, H;       /* of the wheels, and of all beyond the target: (6) */
    bool works[WHEELS_MAX];
    Zonotope torque, momentum; /* of the wheels that work */
    bool reduced;              /* they leave a direction out */
    double most;               /* N m, in any direction */
} Sample;

typedef struct {
    SlewTurn turn;
    bool fits;    /* the wheels bear the momentum all the way */
    double coast; /* s, with the rate of all limits from there on */
} TurnLimits;

/* A turn from the rate that there is. */
typedef struct {
    Vector axis;
    SlewTurn turn;       /* as one from rest that began earlier */
    double rate, wanted; /* rad/s, of it now, and the one from which on it is braked */
    Vector across;       /* what the rate is beside that, in body axes */
    double time;         /* s, until it is over */
} TurnWay;

/* The errors from the plan, in body axes: (5). */
typedef struct {
    Vector zeta, omega, dOmega_d_B;
} Errors;

/* What the inputs are, with the wheels that have not failed. */
bool controller_planned_wheels_take_sample(const ControllerPlannedWheelsLaw *law, const bool failed[WHEELS_MAX],
                                           const ControllerPlannedWheelsInputs *u, Sample *s, Fault *f);

/* (4), (5): the plan, which is the target but for the angle that is left of a turn. `mean` s are those over which its
 * acceleration is the mean. */
Wanted controller_planned_wheels_plan_at(const ControllerPlannedWheelsState *x, const Wanted *target, double mean);

Errors controller_planned_wheels_errors_of(const Wanted *plan, Matrix R, Vector Omega);

/* What is done from this sample on: (8). */
void controller_planned_wheels_decide(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsInputs *u, bool first,
                                      ControllerPlannedWheelsState *x);

/* (15), (16): x->aim, where the end of shedding can be seen, and whether it is waited for; `turn`: time of a turn that
 * begins now, s. */
bool controller_planned_wheels_aim(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                   const ControllerPlannedWheelsInputs *u, const FieldAhead *field,
                                   const Shedding *shedding, double turn, bool first, ControllerPlannedWheelsState *x);

/* (4) with the limits of (3) about the axis, a unit vector, over an angle to the target. */
TurnLimits controller_planned_wheels_turn_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis,
                                                double angle);

/* The way that is sooner over, the short one or the other way round; `on`: rather the one of before, about `before`. */
TurnWay controller_planned_wheels_best_way(const ControllerPlannedWheelsLaw *law, const Sample *s, bool on,
                                           Vector before);

/* The rate error that is wanted in phase 4, in body axes: that of the way about x->axis. */
Vector controller_planned_wheels_approach(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                          const ControllerPlannedWheelsState *x);

/* (10): each wheel's part of their torque `wanted` on the body, and what evens out their momenta. */
void controller_planned_wheels_share(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                     const double h_w[WHEELS_MAX], Vector wanted, double of_wheels[WHEELS_MAX]);

/* Which wheel is planned, 1 to WHEELS_MAX, where those that work leave a direction out: the one of before, else the one
 * along which the field lies most; WHEELS_MAX + 1 where none works; 0: they reach all directions. */
int32_t controller_planned_wheels_few(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsState *x);

/* The parameters of controller_planned for the wheel `few`. */
ControllerPlannedParameters controller_planned_wheels_few_parameters(const ControllerPlannedWheelsParameters *p,
                                                                     int32_t few);

/* What the plan sees: the field, the orbit, and the wheel that works. */
ControllerPlannedInputs controller_planned_wheels_seen(const ControllerPlannedWheelsInputs *u,
                                                       const ControllerPlannedWheelsState *x, int32_t few);

/* Prepares the plan with that wheel. */
void controller_planned_wheels_prepare_few(ControllerPlannedWheelsLaw *law, int32_t few);

/* With one wheel or none: from x->t - h, where the state has that number of wheels since before, else the begin. */
bool controller_planned_wheels_step_few(ControllerPlannedWheelsLaw *law, int32_t few, bool first, double h,
                                        const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsState *x,
                                        ControllerPlannedWheelsOutputs *y, Fault *f);

bool controller_planned_wheels_outputs_few(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x,
                                           const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y,
                                           Fault *f);

/* Nothing is known of the rods yet. */
bool controller_planned_wheels_start_rods(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u,
                                          ControllerPlannedWheelsState *x, Fault *f);

/* What the sample, which ends the step h, shows of the rods: x->rod_gains are those that are believed. */
void controller_planned_wheels_watch_rods(ControllerPlannedWheelsLaw *law, const Sample *s, double h,
                                          const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsState *x);

/* The commands, A m2, that give the wanted dipoles along the rods. */
Vector controller_planned_wheels_by_gains(const ControllerPlannedWheelsLaw *law, Vector gains, Vector wanted);

/* The outputs of the rods. */
void controller_planned_wheels_report_rods(Vector gains, ControllerPlannedWheelsOutputs *y);

#endif
