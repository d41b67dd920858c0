/* Partition of a torque over one wheel and three magnetic rods: Sanyal and Lee-Ho, AIAA 2009-5902, [14] to [24],
 * with the hold near saturation.
 *
 * Flight code: plain functions of plain structures, no memory but `AllocatorState`, fixed time, no recursion.
 * Use: check and prepare once (and again after a change of parameters), start once, then step at every sample.
 * SI units; frames as at the ports. A function that returns false has noted a fault and changed nothing else.
 */
#ifndef ALLOCATOR_H
#define ALLOCATOR_H

#include "fault.h"
#include "allocator_ports.h"

#define ALLOCATOR_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

typedef struct {
    double t;            /* s */
    double dipole[3];    /* last commanded, A m2 along the rods */
    double wheel_torque; /* last commanded dl_w/dt, N m */
    bool holding;        /* whether they were held */
} AllocatorState;

/* Parameters and what follows from them alone. */
typedef struct {
    AllocatorParameters p;
    double U[3][3]; /* rows: the rods' unit axes */
    double axis[3]; /* of the wheel, unit: the paper's e1 */
} AllocatorLaw;

bool allocator_check(const AllocatorParameters *p, Fault *f);

/* p must have passed the check. */
void allocator_prepare(const AllocatorParameters *p, AllocatorLaw *law);

/* The state at t = 0: the command of these inputs is remembered, zero where it would be held at once. */
bool allocator_start(const AllocatorLaw *law, const AllocatorInputs *u, AllocatorState *x, Fault *f);

/* The allocation of the demand, or what x remembers while it is held. */
bool allocator_outputs(const AllocatorLaw *law, const AllocatorState *x, const AllocatorInputs *u, AllocatorOutputs *y,
                       Fault *f);

/* From t to t + h: u are the inputs at t + h, and the commands given then are remembered. */
bool allocator_step(const AllocatorLaw *law, AllocatorState *x, const AllocatorInputs *u, double h, AllocatorOutputs *y,
                    Fault *f);

#endif
