/* Where the mode safe points, by directions that are measured in body axes: no attitude is needed. */
#ifndef SUPERVISOR_SAFE_H
#define SUPERVISOR_SAFE_H

#include "supervisor.h"

/* x->towards, the rate that is asked for at x->t, h after the last; zeros where there is nothing to point at. */
bool supervisor_point_safe(const SupervisorLaw *law, const SupervisorInputs *u, double h, SupervisorState *x, Fault *f);

#endif
