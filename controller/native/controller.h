/* Almost-global attitude tracking on SO(3): the law of Sanyal and Lee-Ho, AIAA 2009-5902, equations [3] to [11].
 *
 * Flight code: plain functions of plain structures, no memory but `ControllerState`, fixed time, no recursion. Use:
 * check and prepare once (and again after a change of parameters), start once, then step at every sample. SI units
 * and radians; frames as at the ports. A function that returns false has noted a fault and changed nothing else. */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include "fault.h"
#include "controller_ports.h"

#define CONTROLLER_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

typedef struct {
    double t;                /* s */
    double attitude_error_0; /* |zeta(0)| of [10], rad, latched at the start */
    double rate_error_0;     /* |omega(0)| of [10], rad/s, latched at the start */
    bool latched;            /* the two are; they wait for an attitude and a reference, anew after a time without */
    bool flown;              /* a step has had an attitude; zeros are then refused where no reference is connected */
} ControllerState;

/* Parameters and what follows from them alone. */
typedef struct {
    ControllerParameters p;
    double R_d0[3][3]; /* projected onto SO(3) */
} ControllerLaw;

bool controller_check(const ControllerParameters *p, Fault *f);

/* p must have passed the check. */
void controller_prepare(const ControllerParameters *p, ControllerLaw *law);

/* The state at t = 0, with |zeta(0)| and |omega(0)| of the inputs as they stand. */
bool controller_start(const ControllerLaw *law, const ControllerInputs *u, ControllerState *x, Fault *f);

/* The law [8] at x->t; damping of the rate alone where there is no attitude or no reference. */
bool controller_outputs(const ControllerLaw *law, const ControllerState *x, const ControllerInputs *u,
                        ControllerOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h, and so is the torque. */
bool controller_step(const ControllerLaw *law, ControllerState *x, const ControllerInputs *u, double h,
                     ControllerOutputs *y, Fault *f);

#endif
