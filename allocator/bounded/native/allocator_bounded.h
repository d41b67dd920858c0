/* Allocation of a torque to wheels and magnetic rods within their limits: bounded least squares with a preference. One
 * wheel and three rods in the block `allocator_bounded`; up to four and three in `allocator_bounded_wheels`. Not in the
 * paper; "[n]" is an equation of Sanyal and Lee-Ho, AIAA 2009-5902.
 *
 * Flight code: plain functions of plain structures, bounded time, no recursion, and no memory but the time and, of
 * a set of wheels, what each has given of its commands.
 * Use: check and prepare once (and again after a change of parameters), start once, then step at every sample.
 * SI units; frames as at the ports. A function that returns false has noted a fault and changed nothing else.
 */
#ifndef ALLOCATOR_BOUNDED_H
#define ALLOCATOR_BOUNDED_H

#include "allocator_bounded_ports.h"
#include "fault.h"
#include "momentum_watch.h"

#define ALLOCATOR_BOUNDED_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

typedef struct {
    double t;                                          /* s */
    double h_w[ALLOCATOR_BOUNDED_WHEELS];              /* of the last sample, as it was used, N m s */
    double command[ALLOCATOR_BOUNDED_WHEELS];          /* of the last sample, N m */
    double omega_B[3], dipole[3];                      /* of the last sample, rad/s; what the rods gave, A m2 */
    double given[ALLOCATOR_BOUNDED_WHEELS];            /* sum of command times change of momentum; forgotten */
    double asked[ALLOCATOR_BOUNDED_WHEELS];            /* sum of command squared times time; forgotten */
    double slow_command[ALLOCATOR_BOUNDED_WHEELS];     /* smoothed, N m */
    double slow_answer[ALLOCATOR_BOUNDED_WHEELS];      /* smoothed change of momentum that the body shows, N m */
    double answered[ALLOCATOR_BOUNDED_WHEELS];         /* as `given`, of these two */
    double called[ALLOCATOR_BOUNDED_WHEELS];           /* as `asked`, of the smoothed command */
    double failed_for[ALLOCATOR_BOUNDED_WHEELS];       /* s since it gave less than half; below 0: unconfirmed; 0: no */
    double tried[ALLOCATOR_BOUNDED_WHEELS];            /* what it gave of its command as it was last tried; 0: never */
    double doubted_for[ALLOCATOR_BOUNDED_WHEELS];      /* s since h_w shows less than half, but the body more */
    double friction[ALLOCATOR_BOUNDED_WHEELS];         /* Coulomb friction that each was seen to have, N m */
    double expected[ALLOCATOR_BOUNDED_WHEELS];         /* momentum at the next sample, N m s */
    MomentumWatch telemetry[ALLOCATOR_BOUNDED_WHEELS]; /* of h_w */
} AllocatorBoundedState;

/* Parameters and what follows from them alone. */
typedef struct {
    AllocatorBoundedParameters p;
    double U[3][3];                              /* rows: the rods' unit axes */
    double axis[ALLOCATOR_BOUNDED_WHEELS][3];    /* of the wheels, unit */
    double null_space[ALLOCATOR_BOUNDED_WHEELS]; /* torques of four wheels that cancel on the body, a unit vector */
    bool has_null_space;
} AllocatorBoundedLaw;

bool allocator_bounded_check(const AllocatorBoundedParameters *p, Fault *f);

/* p must have passed the check. */
void allocator_bounded_prepare(const AllocatorBoundedParameters *p, AllocatorBoundedLaw *law);

#if ALLOCATOR_BOUNDED_WHEELS > 1
/* Whether wheel i is one that failed, where that is looked for. */
bool allocator_bounded_wheel_failed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i);

/* Whether wheel i gives the opposite of its commands, as its trial showed. */
bool allocator_bounded_wheel_reversed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i);

/* The momentum of wheel i, N m s: h_w, or where that is left out what the wheel has by its commands. */
double allocator_bounded_wheel_momentum(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                        const AllocatorBoundedInputs *u, int i);

/* What wheel i gives of its command: as it is told by wheel_gains, else 0 of one that has failed, -1 of one that is
 * reversed. */
double allocator_bounded_wheel_gain(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                    const AllocatorBoundedInputs *u, int i);

/* The command that is preferred of wheel i, N m: that by which it is tried where it has failed, else the one for the
 * torque that is preferred. */
double allocator_bounded_tried_torque(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                      const AllocatorBoundedInputs *u, int i, double preferred);

/* Whether wheel i is tried now. */
bool allocator_bounded_is_tried(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                const AllocatorBoundedInputs *u, int i);

/* What wheel i gives of the command by which it is tried, N m, as the last trial showed. */
double allocator_bounded_by_trial(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                  const AllocatorBoundedInputs *u, int i);

/* The command by which wheel i gives the torque that is wanted, N m, beside its friction. */
double allocator_bounded_with_friction(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                       const AllocatorBoundedInputs *u, int i, double wanted);

/* Takes in what the wheels gave of the last commands over h, and the commands y that act from now on. */
void allocator_bounded_watch(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                             AllocatorBoundedState *x);
void allocator_bounded_keep(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, AllocatorBoundedOutputs *y,
                            AllocatorBoundedState *x);

/* At the start, with the first commands y. */
void allocator_bounded_begin(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u,
                             AllocatorBoundedOutputs *y, AllocatorBoundedState *x);
#endif

/* The state at t = 0; the first command is that of these inputs. */
bool allocator_bounded_start(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, AllocatorBoundedState *x,
                             Fault *f);

/* The commands that serve the demand best within the limits; of x only what is known of the wheels counts. */
bool allocator_bounded_outputs(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                               const AllocatorBoundedInputs *u, AllocatorBoundedOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool allocator_bounded_step(const AllocatorBoundedLaw *law, AllocatorBoundedState *x, const AllocatorBoundedInputs *u,
                            double h, AllocatorBoundedOutputs *y, Fault *f);

#endif
