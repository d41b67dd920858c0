/* The usual controller of a satellite with none to four reaction wheels: feedback of the error quaternion by the wheels
 * with limits of rate and acceleration (Wie and Lu, J. Guidance 18(6), 1995), and unloading by cross product with the
 * rods (Camillo and Markley, J. Guidance 3(6), 1980). Not in the paper of Sanyal and Lee-Ho.
 *
 * Flight code: plain functions of plain structures, bounded time, no recursion, and no memory but the time.
 * Use: check and prepare once (and again after a change of parameters), start once, then step at every sample.
 * SI units; frames as at the ports. A function that returns false has noted a fault and changed nothing else. */
#ifndef CONTROLLER_WHEELS_H
#define CONTROLLER_WHEELS_H

#include "controller_wheels_ports.h"
#include "fault.h"
#include "wheels.h"

#define CONTROLLER_WHEELS_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

typedef struct {
    double t; /* s */
} ControllerWheelsState;

/* Parameters and what follows from them alone. */
typedef struct {
    ControllerWheelsParameters p;
    Matrix J, R_d0;
    Matrix rods_inverse;         /* body to rods: a dipole along the rods */
    Vector axes[WHEELS_MAX];     /* unit; zero of a wheel that is not there */
    Vector share_of[WHEELS_MAX]; /* dl_w/dt of each wheel, N m, by a torque of the wheels on the body: a row each */
} ControllerWheelsLaw;

bool controller_wheels_check(const ControllerWheelsParameters *p, Fault *f);

/* p must have passed the check. */
void controller_wheels_prepare(const ControllerWheelsParameters *p, ControllerWheelsLaw *law);

/* The state at t = 0; the first command is that of these inputs. */
bool controller_wheels_start(const ControllerWheelsLaw *law, const ControllerWheelsInputs *u, ControllerWheelsState *x,
                             Fault *f);

/* The commands at the time of x. */
bool controller_wheels_outputs(const ControllerWheelsLaw *law, const ControllerWheelsState *x,
                               const ControllerWheelsInputs *u, ControllerWheelsOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool controller_wheels_step(const ControllerWheelsLaw *law, ControllerWheelsState *x, const ControllerWheelsInputs *u,
                            double h, ControllerWheelsOutputs *y, Fault *f);

#endif
