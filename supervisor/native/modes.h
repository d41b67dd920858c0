/* Modes: the reference of the present one, and what comes next. */
#ifndef SUPERVISOR_MODES_H
#define SUPERVISOR_MODES_H

#include "supervisor.h"

/* Before it is known: set, so that no path reads it unset. */
static const Reference SUPERVISOR_NO_REFERENCE = {
    {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};

/* Of Greenwich at x->t, rad. */
double supervisor_angle_of_earth(const SupervisorLaw *law, const SupervisorState *x);

/* The reference of the destination at x->t. */
bool supervisor_destination(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                            Reference *to, Fault *f);

/* The reference at x->t; in the mode safe no attitude, a matrix of zeros, and the rate x->towards in body axes. */
bool supervisor_reference_now(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                              Reference *now, Fault *f);

/* The state h later; x is of no use after a fault. */
bool supervisor_advance(const SupervisorLaw *law, const SupervisorInputs *u, double h, SupervisorState *x, Fault *f);

#endif
