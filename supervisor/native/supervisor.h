/* Modes of a mission: it gives the controller the reference of the present mode, and slews from one to the next.
 *
 * Flight code: plain functions of plain structures, no memory but `SupervisorState`, fixed time, no recursion. SI
 * units and radians; frames as at the ports. A function that returns false has noted a fault and changed nothing
 * else. */
#ifndef SUPERVISOR_H
#define SUPERVISOR_H

#include "pointing.h"
#include "supervisor_ports.h"
#include "slew.h"

#define SUPERVISOR_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

/* As `mode`, `destination` and `command` count them. */
enum {
    SUPERVISOR_SAFE = 1,
    SUPERVISOR_ACQUIRE = 2,
    SUPERVISOR_NADIR = 3,
    SUPERVISOR_INERTIAL = 4,
    SUPERVISOR_SLEW = 5,
    SUPERVISOR_TARGET = 6,
    SUPERVISOR_SUN = 7
};

/* Why it is in the mode safe, as `safe_reason` says it. */
enum {
    SUPERVISOR_NOT_SAFE = 0,
    SUPERVISOR_SINCE_START = 1,
    SUPERVISOR_BY_COMMAND = 2,
    SUPERVISOR_TOO_FAST = 3,
    SUPERVISOR_NO_ATTITUDE = 4
};

enum { SUPERVISOR_AHEAD = 16 }; /* times at which the reference to come is given */

/* The reference to come: times, s, ascending; attitudes, each by its rotation vector, N from desired body; rates. */
typedef struct {
    double next; /* s, when it is given anew; 0: it is not given */
    double t[SUPERVISOR_AHEAD];
    Vector turn[SUPERVISOR_AHEAD], Omega[SUPERVISOR_AHEAD];
} SupervisorAhead;

typedef struct {
    double t; /* s */
    int32_t mode;
    int32_t destination; /* the mode that acquisition or slew leads to; else the mode itself */
    int32_t safe_reason;
    double aim[9];     /* R_goal, row by row, or latitude, longitude and height; zeros for the other modes */
    Matrix kept;       /* the attitude of a destination whose turn about its axis is free, at t */
    double calm, fast; /* s for which the rate has been below rate_acquire, and above rate_lost */
    double blind;      /* s without an attitude */
    double settled,
        off; /* s for which the errors have been small in acquisition, and the attitude's too large elsewhere */
    double slew_start; /* s */
    Slew slew;
    Vector field_direction,
        field_rate; /* in the mode safe: direction of the field and its rate relative to N, rad/s, body axes */
    Vector towards; /* in the mode safe: the rate that is asked for, rad/s, body axes */
    SupervisorAhead ahead;
} SupervisorState;

/* Parameters and what follows from them alone. */
typedef struct {
    SupervisorParameters p;
    double sidereal_angle_0; /* of Greenwich at t = 0, rad */
} SupervisorLaw;

bool supervisor_check(const SupervisorParameters *p, Fault *f);

/* p must have passed the check. */
void supervisor_prepare(const SupervisorParameters *p, SupervisorLaw *law);

/* The state at t = 0: safe, or in acquisition where nothing has to be waited for. */
bool supervisor_start(const SupervisorLaw *law, const SupervisorInputs *u, SupervisorState *x, Fault *f);

/* The reference at x->t, of the inputs as they stand. */
bool supervisor_outputs(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                        SupervisorOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool supervisor_step(const SupervisorLaw *law, SupervisorState *x, const SupervisorInputs *u, double h,
                     SupervisorOutputs *y, Fault *f);

#endif
