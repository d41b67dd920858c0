/* The planned controller of a satellite with up to four reaction wheels: momentum that the wheels cannot hold is shed
 * by the rods, the turn of least time that they can give is tracked by the wheels. docs/how/planned-wheels.md has its
 * equations, (n) in the comments.  Flight code: plain functions of plain structures, bounded time, no recursion. Use:
 * check and prepare once (and again after a change of parameters), start once, then step at every sample. SI units;
 * frames as at the ports. A function that returns false has noted a fault. */
#ifndef CONTROLLER_PLANNED_WHEELS_H
#define CONTROLLER_PLANNED_WHEELS_H

#include "controller_planned.h"
#include "controller_planned_wheels_ports.h"
#include "shedding.h"
#include "turn.h"
#include "wheel_set.h"

#define CONTROLLER_PLANNED_WHEELS_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

typedef enum { WHEELS_SHEDDING = 1, WHEELS_TURN = 2, WHEELS_HOLD = 3, WHEELS_DAMPING = 4 } WheelsPhase;

enum { AIM_COURSE_KNOTS = 2 };

/* How momentum is shed. */
typedef struct {
    Vector knots[AIM_COURSE_KNOTS]; /* N m s, of the wheels together, in body axes, one after the other */
    Vector lambda;                  /* unit, in N: along it the rods shed */
} AimCourse;

typedef struct {
    AimCourse course, other; /* that is taken, and one that is tried beside */
    double segment, since;   /* s, from knot to knot, 0 without a course; since the begin of the first */
    double left, whole;      /* s, to the end of shedding and of the turn that follows; infinite: not known */
    int32_t tries;
    bool given_up; /* that end did not come */
} Aim;

typedef struct {
    double t; /* s */
    int32_t phase;
    bool failed[WHEELS_MAX]; /* of the last sample */
    double begun;            /* s, of the turn */
    Vector axis;             /* of the turn, unit, in the frame of the desired body */
    SlewTurn turn;
    Aim aim;              /* while momentum is shed */
    Vector shedding;      /* unit, in N: along it momentum is shed, (7) */
    Vector disturbance_B; /* N m, what the hold has to counter */
    Matrix across;        /* in N: the mean of 1 - b b' over the orbit behind, (12) */
    Matrix along;         /* in axes of the target: the mean of b b' over the orbit behind */
    int32_t few;          /* 1 to WHEELS_MAX: the one wheel that is planned; above: there is none; 0: all are */
    Vector rod_gains;     /* that are believed */
    double shown;         /* s, for which samples have shown what rods do */
    Vector h;             /* N m s, of the wheels at the last of them */
    double lowest[WHEELS_MAX], highest[WHEELS_MAX]; /* N m s, of each wheel since then */
    ControllerPlannedState planned;                 /* with one wheel or none; else its filter, for the rods */
} ControllerPlannedWheelsState;

/* Parameters and what follows from them alone. */
typedef struct {
    ControllerPlannedWheelsParameters p;
    Matrix J, R_d0, rods;    /* rods: rows, unit */
    Matrix rods_inverse;     /* body to rods: a dipole along the rods */
    double J_bound;          /* kg m2, not below any principal moment */
    double rods_dipole;      /* A m2, of the mean rod at its limit */
    Vector axes[WHEELS_MAX]; /* unit; zero of a wheel that is not there */
    Vector h_target;         /* N m s, of the wheels together */
    int32_t few;             /* for which `planned` is prepared: as in the state, but not 0 */
    ControllerPlannedLaw planned;
} ControllerPlannedWheelsLaw;

bool controller_planned_wheels_check(const ControllerPlannedWheelsParameters *p, Fault *f);

/* p must have passed the check; before the first time planned.workspace and planned.steering_field are zero. */
void controller_planned_wheels_prepare(const ControllerPlannedWheelsParameters *p, ControllerPlannedWheelsLaw *law);

/* The state at t = 0; the first command is that of these inputs. */
bool controller_planned_wheels_start(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u,
                                     ControllerPlannedWheelsState *x, Fault *f);

/* The commands at the time of x. */
bool controller_planned_wheels_outputs(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x,
                                       const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y,
                                       Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool controller_planned_wheels_step(ControllerPlannedWheelsLaw *law, ControllerPlannedWheelsState *x,
                                    const ControllerPlannedWheelsInputs *u, double h, ControllerPlannedWheelsOutputs *y,
                                    Fault *f);

#endif
