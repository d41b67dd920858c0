/* A motion that rods and wheel can give, by box-constrained iterative LQR on the attitude, the rate and the wheel. */
#ifndef PLAN_H
#define PLAN_H

#include "box_qp.h"
#include "onboard.h"

enum { STAGES = 208, ERRORS = 7 };

/* The satellite as the planner believes it is. */
typedef struct {
    Matrix J, J_inverse;
    Vector rods[3];          /* dipole of each rod at its limit, body axes, A m2, with the estimated gain */
    double wheel_torque_max; /* N m */
    double wheel_momentum_max;
    Vector disturbance_B; /* N m */
    Vector residual_B;    /* dipole of the satellite itself, A m2 */
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
} Around;

/* The controls u, each -1 to 1: rods over dipole_max, dl_w/dt over wheel_torque_max; constant over a stage. */
typedef struct {
    int stages;
    double start;       /* s */
    double h[STAGES];   /* s */
    double u[STAGES][CONTROLS];
    double cost;
} Plan;

typedef struct {
    Around around;  /* in the middle of the stage */
    Target target;  /* at its beginning */
} Stage;

typedef double Square[ERRORS][ERRORS];

/* Of one stage: the errors after it are A errors + G controls; V is the Hessian of the cost from then on. */
typedef struct {
    Square A, V, VA, next;
    double G[ERRORS][CONTROLS], VG[ERRORS][CONTROLS];
} Sweep;

/* Scratch: what it holds matters within one call only. */
typedef struct {
    Sweep sweep;
    Stage stage[STAGES + 1]; /* the last one has the final target alone */
    Motion x[2][STAGES + 1];
    double u[2][STAGES][CONTROLS];
    double k[STAGES][CONTROLS];
    double K[STAGES][CONTROLS][ERRORS];
} Workspace;

/* Where the plan's environment comes from. */
typedef struct {
    const OnboardField *field;
    OnboardOrbit orbit;
    Vector bias_N;  /* T, added to the field, fading with bias_time */
    double bias_t;  /* when it was measured, s */
    int target_kind;
    Matrix R_d0;
} Ahead;

Around around_at(const Ahead *ahead, double t);
Target target_at(const Ahead *ahead, double t);

/* Dipole of the rods under the controls, A m2, body axes. */
Vector rods_dipole(const Model *model, const double u[CONTROLS]);

/* M_g = 3 mu/r^3 r_hat x J r_hat [2], N m, body axes. */
Vector gravity_gradient(Matrix J, const Around *around, Matrix R);

/* Whether the plan has a motion: none turns faster than its stages can follow. */
bool may_be_flown(const Plan *plan);

/* The change of the rate, rad/s^2, under the controls. */
Vector acceleration(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS]);

/* The motion after h under constant controls, by the midpoint rule; the wheel stops at its limit. */
Motion advanced(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS], double h);

/* The stages of a horizon from t on, of the plan that was (or none), finer where its motion from x turns fast; its
 * controls are carried over, zero beyond its end. */
void lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, const Plan *was, Plan *plan,
                Workspace *w);

/* Improves the plan from x by at most a number of iterations, which it returns, fewer where nothing more is gained; the
 * plan's cost is then that of its motion. Its stages must be those that were laid last. */
int improve(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w);

/* The search for a plan from nothing: three starts, each improved, the best kept; a few iterations in each call. */
enum { STARTS = 3 };

typedef struct {
    bool active, ready;
    int32_t start, left; /* iterations of this start */
    Motion x;
    double t;
    Plan trial, best;
} Search;

void search_begin(const Motion *x, double t, Search *search);

/* Goes on by at most `iterations`. */
void search_on(const Model *model, const Ahead *ahead, int iterations, Search *search, Workspace *w);

/* The controls nearest to a demanded torque of rods and wheel in the field B_B. */
void controls_for(const Model *model, Vector tau, Vector B_B, double l, double u[CONTROLS]);

/* The controls at t; zero before the plan's start and after its end. */
void plan_at(const Plan *plan, double t, double u[CONTROLS]);

#endif
