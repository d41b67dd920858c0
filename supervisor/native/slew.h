/* Slews: a turn that fades from one reference to the next, with the rate and the torque that the user allows. */
#ifndef SUPERVISOR_SLEW_H
#define SUPERVISOR_SLEW_H

#include "reference.h"

/* exp(phi^) from the destination's attitude, phi a quintic of time from phi0 with the rate dphi0 to rest at zero. */
typedef struct {
    double duration; /* s */
    Vector phi0;     /* rad, in the destination's desired body axes */
    Vector dphi0;    /* rad/s: rate and attitude are continuous where the slew begins */
} Slew;

/* From a reference to another, with J kg m2 within a rate, rad/s, and a torque, N m. */
Slew supervisor_slew_begin(const Reference *now, const Reference *to, Matrix J, double rate_max, double torque_max);

/* The reference s after the start, to the destination as it is then; the destination itself from the duration on. */
Reference supervisor_slew_at(const Slew *slew, double s, const Reference *to);

#endif
