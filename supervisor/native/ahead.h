/* The reference to come. */
#ifndef SUPERVISOR_AHEAD_H
#define SUPERVISOR_AHEAD_H

#include "supervisor.h"

/* x->ahead of x->t: the reference of the present mode, on the two-body orbit through position and velocity, at times
 * that lie wider apart the further ahead they are. None in the mode safe, nor on an orbit that is no ellipse or
 * nearly none. */
bool supervisor_look_ahead(const SupervisorLaw *law, const SupervisorInputs *u, SupervisorState *x, Fault *f);

#endif
