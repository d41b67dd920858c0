/* The satellite's own units, and what follows from its data where a parameter leaves it open.
 *
 * The rods turn the satellite by about a radian in T = sqrt(J/(dipole_max B)), J the mean principal moment and B a
 * field of the orbit. Whatever depends on the satellite's size is a multiple of T, of the momentum J/T or of the
 * torque J/T^2. */
#ifndef CONTROLLER_PLANNED_SCALES_H
#define CONTROLLER_PLANNED_SCALES_H

#include "controller_planned_ports.h"
#include "vector.h"

static const double LOW_ORBIT = 7e6;   /* m, a semi-major axis where none is known */
static const double PLAN_PERIOD = 0.2; /* T */

typedef struct {
    double time;               /* T, s, to two digits */
    double momentum, torque;   /* J/T, N m s; J/T^2, N m */
    double orbit_rate, period; /* of the orbit: rad/s, the mean one; s */
    double turning_moment;     /* kg m2: the least principal moment, more for a slender body */
    bool fast_nutation;        /* by more than a radian in T, with the wheel at its limit */
    double weight_angle;       /* of a plan's cost */
    double weight_far;         /* the same of what an angle is beyond a limit; none but by rods alone */
    double weight_rate;        /* the same, s^2 */
    double weight_control, weight_motor_control; /* of the rods, of the motor */
    double final_errors, final_wheel;            /* s, by which the last stage counts */
    double weight_wheel;                         /* 1/(N m s)^2 */
    double weight_near_limit;                    /* the same beyond near_limit */
    double wheel_momentum; /* N m s, that plans let the wheel hold: its limit, less where that is much for the rods */
    double near_limit;     /* N m s, of the wheel's momentum */
    double weight_rods, weight_motor; /* (N m)^2 that a whole control costs where a torque is given to rods and motor */
    Vector K;                         /* of the law [8], N m */
    Matrix L;                         /* N m s */
    double plan_period;               /* s */
    double steering_limit;            /* N m s */
    double disturbance_max, strained_disturbance_max;   /* N m; that of a strained hold */
    double disturbance_time, strained_disturbance_time; /* s */
    double residual_dipole_max;                         /* A m2 */
} Scales;

/* `a`: the orbit's semi-major axis, m. Parameters that are given win, but for the tunable gains. */
Scales controller_planned_scales(const ControllerPlannedParameters *p, double a);

/* The largest eigenvalue of J^-1 S, J an inertia and S symmetric, by the power method: to a few digits where two are
 * alike. */
double controller_planned_largest_of(Matrix J, Matrix S);

/* A m2: the dipole of each rod at its limit. */
Vector controller_planned_rod_dipoles(const ControllerPlannedParameters *p);

/* What rods of these gains give of dipole_max at their limits, on average. */
double controller_planned_rods_share(const ControllerPlannedParameters *p, const double gains[3]);

/* Whether the gain is given. */
bool controller_planned_has_L0(const ControllerPlannedParameters *p);
bool controller_planned_has_K0(const ControllerPlannedParameters *p);

#endif
