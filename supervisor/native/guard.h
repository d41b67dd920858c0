/* The last look at the outputs. */
#ifndef SUPERVISOR_GUARD_H
#define SUPERVISOR_GUARD_H

#include "supervisor.h"

/* Whether each number of the outputs is finite; the fault names the output. */
bool supervisor_guard(const SupervisorOutputs *y, Fault *f);

#endif
