/* The actuators that there are, rods before wheels: what each gives, and what is asked of it where there is a
 * choice. */
#ifndef ALLOCATOR_BOUNDED_ACTUATORS_H
#define ALLOCATOR_BOUNDED_ACTUATORS_H

#include "allocator_bounded.h"
#include "box.h"
#include "vector.h"

/* A block for one wheel has no parameter and no input for what only a set of wheels has. */
#if ALLOCATOR_BOUNDED_WHEELS > 1
#define RODS(p) ((p)->rods)
#define WHEELS(p) ((p)->wheels)
#define WHEEL_TARGET(p, i) ((p)->wheel_momentum_target[i])
#define WHEEL_GAIN(law, x, u, i) allocator_bounded_wheel_gain(law, x, u, i)
#define WHEEL_TRIED(law, x, u, i) allocator_bounded_is_tried(law, x, u, i)
#define WHEEL_MOMENTUM(law, x, u, i) allocator_bounded_wheel_momentum(law, x, u, i)
#define NULL_SPACE_MOMENTUM(p) ((p)->null_space_momentum)
#else
#define RODS(p) 3
#define WHEELS(p) 1
#define WHEEL_TARGET(p, i) 0.0
#define WHEEL_GAIN(law, x, u, i) ((void)(x), 1.0)
#define WHEEL_TRIED(law, x, u, i) false
#define WHEEL_MOMENTUM(law, x, u, i) ((u)->h_w[i])
#define NULL_SPACE_MOMENTUM(p) 0.0
#endif

/* In shares of the limits, but for the limits themselves. */
typedef struct {
    int rods, wheels, n;
    Vector torque[BOX_N]; /* on the body, N m, at the limit: the columns of the effectiveness matrix */
    double limit[BOX_N];  /* of a rod A m2, of a wheel N m */
    double low[BOX_N], high[BOX_N];
    double weight[BOX_N];    /* N m */
    double preferred[BOX_N]; /* not yet within low and high */
} Actuators;

/* rods: the torque of each on the body per A m2, its gain included; with_rods_ff: dipole_ff counts. */
void allocator_bounded_actuators(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                 const AllocatorBoundedInputs *u, const Vector rods[3], bool with_rods_ff,
                                 Actuators *a);

#endif
