/* The satellite's motion as the planner predicts it: attitude, rate and wheel under constant controls. */
#ifndef CONTROLLER_PLANNED_MOTION_H
#define CONTROLLER_PLANNED_MOTION_H

#include "estimate/profile.h"
#include "onboard_field.h"
#include "rotation.h"
#include "scales.h"
#include "two_body.h"

enum { CONTROLS = 4 }; /* of the three rods and the motor */
enum { ERRORS = 7 };   /* attitude, rate, wheel momentum: d of R exp(d^), Omega + d, l + d */

enum { PIECES = 3 };

/* The target: none, one that the parameter `reference` names (1 and 2 are its values), or a given one, which keeps its
 * attitude to LVLH, too, or its body rate. */
enum { ONBOARD_TARGET_NONE = 0, ONBOARD_TARGET_LVLH = 1, ONBOARD_TARGET_INERTIAL = 2, ONBOARD_TARGET_TURNING = 3 };

/* The desired motion: attitude (N from desired body), rate in desired body axes. */
typedef struct {
    Matrix R;
    Vector Omega;
} Target;

/* Of a plan: pieces, each until a time and of stages of one length, s. */
typedef struct {
    double until[PIECES], stage[PIECES];
} Horizon;

/* The satellite as it is estimated, and how it plans. */
typedef struct {
    Matrix J, J_inverse;
    Vector rods[3];          /* dipole of each rod at its limit, body axes, A m2, with the estimated gain */
    Vector wheel_axis;       /* unit, body axes */
    double wheel_torque_max; /* N m; 0 where the wheel gives no torque */
    double wheel_momentum_max;
    Vector beside_B;      /* N m s, of wheels beside the one that is planned, which they keep */
    Vector disturbance_B; /* N m */
    Vector residual_B;    /* dipole of the satellite itself, A m2 */
    Scales scales;
    Horizon horizon;
} Model;

typedef struct {
    Matrix R;
    Vector Omega;
    double l; /* wheel momentum, N m s */
} Motion;

/* What surrounds the satellite at one time. */
typedef struct {
    Vector B_N;          /* T */
    Vector r_hat_N;      /* unit position */
    double rate_squared; /* mu/r^3, 1/s^2 */
    Vector change_B;     /* N m, of the disturbance torque, from that of now */
} Around;

enum { KNOTS = 17, AHEAD_TIMES = KNOTS - 1 }; /* times at which a given target may be known: now, and ahead */

/* A target that is given for a time, s. */
typedef struct {
    double t;
    Target target;
} Knot;

/* Where the plan's environment comes from. */
typedef struct {
    const OnboardField *field;
    TwoBody orbit;
    Vector bias_N;          /* T, added to the field, fading over BIAS_FADES */
    double bias_t;          /* when it was measured, s */
    const Profile *profile; /* of the disturbance; NULL: it is taken to be constant */
    int target_kind;
    int knots; /* after knot[0], which is now; 0: the target is known for now only */
    Knot knot[KNOTS];
    Matrix R_d0; /* at rest or relative to LVLH; of a given target from given_t on, then also turning with Omega_d0 */
    Vector Omega_d0; /* rad/s, and its derivative, rad/s2 */
    Vector dOmega_d0;
    double given_t; /* s, until which the target is known */
} Ahead;

typedef double Square[ERRORS][ERRORS];

static inline Matrix sum(Matrix m, Matrix n)
{
    return (Matrix){add(m.a, n.a), add(m.b, n.b), add(m.c, n.c)};
}

static inline Matrix times(double s, Matrix m)
{
    return (Matrix){scale(s, m.a), scale(s, m.b), scale(s, m.c)};
}

/* Of the wheels, N m s, body axes: l a, and what is beside it. */
static inline Vector momentum_of_wheels(const Model *model, double l)
{
    return add(scale(l, model->wheel_axis), model->beside_B);
}

/* The same with J Omega. */
static inline Vector momentum_of(const Model *model, const Motion *x)
{
    return add(apply(model->J, x->Omega), momentum_of_wheels(model, x->l));
}

/* Whether the wheel gives torque. */
static inline bool has_wheel(const Model *model)
{
    return model->wheel_torque_max > 0.0;
}

/* The wheel's control, -1 to 1, that would bring its momentum l to rest in a time, s; 0 where it gives no torque. */
static inline double wheel_to_rest(const Model *model, double l, double time)
{
    return has_wheel(model) ? clip(-l / (time * model->wheel_torque_max), -1.0, 1.0) : 0.0;
}

/* Dipole of the rods under the controls, A m2, body axes. */
static inline Vector rods_dipole(const Model *model, const double u[CONTROLS])
{
    return add(scale(u[0], model->rods[0]), add(scale(u[1], model->rods[1]), scale(u[2], model->rods[2])));
}

/* M_g = 3 mu/r^3 r_hat x J r_hat [2], N m, body axes. */
static inline Vector gravity_gradient(Matrix J, const Around *around, Matrix R)
{
    const Vector rho = apply_transposed(R, around->r_hat_N);
    return scale(3.0 * around->rate_squared, cross(rho, apply(J, rho)));
}

/* With the field of the model alone, and with the bias that was measured. */
Around controller_planned_around_of(const OnboardField *field, const TwoBody *orbit, double t);
Around controller_planned_around_at(const Ahead *ahead, double t);
Target controller_planned_target_at(const Ahead *ahead, double t);

/* LVLH of a position and a velocity: Z to nadir, Y against the orbit's normal. */
Target controller_planned_lvlh(Vector r_N, Vector v_N);

/* The change of the rate, rad/s^2, under the controls. */
Vector controller_planned_acceleration(const Model *model, const Around *around, const Motion *x,
                                       const double u[CONTROLS]);

/* The wheel's control, -1 to 1, within what its momentum l, N m s, leaves room for over h, s. */
double controller_planned_wheel_within(const Model *model, double l, double u, double h);

/* The motion after h under constant controls, by the midpoint rule; the rate of the middle implicitly, where
 * nutation is fast. */
void controller_planned_moved(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS],
                              double h, Motion *next);

/* The same with the wheel's control within its limit. */
Motion controller_planned_advanced(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS],
                                   double h);

/* The errors after a stage of h from x to next, A errors + G controls, to second order in h, with the motion of its
 * middle; both by their columns. A leaves the wheel's momentum as it is, and of the controls only the wheel's
 * changes it. */
void controller_planned_linearise(const Model *model, const Around *around, const Motion *x, const Motion *next,
                                  const double u[CONTROLS], double h, Square A, double G[CONTROLS][ERRORS]);

#endif
