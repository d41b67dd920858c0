/* What the controller remembers, what follows from its parameters, and the three parts of a sample that work on both:
 * estimate.c, decide.c, command.c. */
#ifndef CONTROLLER_PLANNED_STATE_H
#define CONTROLLER_PLANNED_STATE_H

#include "estimate/friction.h"
#include "estimate/identification.h"
#include "controller_planned_ports.h"
#include "momentum_watch.h"
#include "plan/search.h"
#include "estimate/sensors_watch.h"
#include "plan/steering.h"
#include "plan/strained.h"

static const double SAMPLE_EARLY =
    1e-6; /* of the control period: a sample and a plan are due that much before their time */

/* Whether an estimator goes without this sensor: it is frozen or inconsistent. */
static inline bool is_lost(int32_t health)
{
    return health == 2 || health == 3;
}

typedef enum { PHASE_STEERING = 1, PHASE_ACQUISITION = 2, PHASE_HOLD = 3, PHASE_DAMPING = 4 } Phase;

typedef struct {
    double t;              /* s */
    double until_sample;   /* s, until the control acts next */
    double next_plan;      /* s */
    double next_challenge; /* s */
    double settled_since;  /* s; beyond t while not settled */
    int32_t phase;
    bool sampled;  /* whether the control has acted at t */
    bool waiting;  /* for the first attitude, or for one that was lost */
    Scales scales; /* of the orbit on which it began */
    bool flown;    /* a step has had an attitude; zeros are then refused where no reference is connected */
    Steering steering;
    Plan plan;
    Search search;
    int32_t longer;        /* stages that a hold's plan has behind its usual horizon; negative: of which it is cut */
    double strained_until; /* s; when the strained hold ends without a new cause; not beyond t: there is none */
    double loaded_since;   /* s; in the hold, by the wheel or the angle (decide.c); beyond t while it is not */
    bool strained;         /* a hold that the wheel possibly cannot keep close (strained.h) */
    PlannedMotion planned; /* of the plan of a strained hold */
    Profile profile;       /* of the disturbance, along the last orbit, as far as it was strained */
    bool may_doubt;        /* there has been a hold, or the field is not measured */
    bool doubted;          /* no attitude is left by its bound, and the satellite has turned since: rates are damped */
    double least_rate;     /* rad/s, of those since it is doubted */
    bool drives;           /* they have grown: the field that damps them is wrong, and no rod acts */
    bool provisional;      /* the plan is what the first search had come to in its first sample */
    bool challenged;       /* the search's plan is held against the plan at the next sample */
    Motion reference;      /* of the plan, at t_sample */
    Vector field_bias_N;   /* measured field less that of the onboard model */
    double l_own;          /* wheel momentum by the controller's own account */
    Identification identification;
    Friction friction;
    bool rods_alone; /* the wheel gives no torque, and none is asked of it but to see whether it works again */
    SensorsWatch sensors;
    MomentumWatch momentum;
    /* The last sample. */
    double t_sample;
    Motion measured;
    Motion predicted, estimate; /* at the sample, before the measurement and after it */
    Vector B_B;
    double u[CONTROLS]; /* asked for since */
    ControllerPlannedOutputs held;
} ControllerPlannedState;

/* Parameters and what follows from them alone. */
typedef struct {
    ControllerPlannedParameters p;
    bool gains_fit;  /* the stiffness has been checked */
    Matrix R_d0;     /* projected onto SO(3) */
    Matrix rod_axes; /* rows, unit */
    Vector wheel_axis;
    Vector beside_B; /* N m s, of wheels that are not planned: none, but as a set of wheels has it */
    OnboardField field;
    double field_tolerance; /* T, of a measured field to that of the model */
    Workspace workspace;
    Plan trial;
    Vector steering_field[STEERING_NODES];
} ControllerPlannedLaw;

/* Whether the field is measured; no orbit has one of exactly zero. */
static inline bool has_field(const ControllerPlannedInputs *u)
{
    return controller_planned_has_b_B(u) && (u->b_B[0] != 0.0 || u->b_B[1] != 0.0 || u->b_B[2] != 0.0);
}

/* The same, and whether the measurement is used: not one that repeats, which may be the first of a frozen sensor. */
static inline bool uses_field(const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    return has_field(u) && !x->sensors.field_failed && !(x->sensors.b_repeats > 0.0);
}

/* The measured attitude, or what stands in for one that is frozen. */
static inline Matrix attitude_of(const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    return x->sensors.attitude_frozen ? x->sensors.turned_R : matrix(u->R_NB);
}

/* The wheel's momentum, N m s: measured, or by the controller's own account where it is not, or frozen. */
static inline double wheel_momentum(const ControllerPlannedState *x, const ControllerPlannedInputs *u)
{
    return controller_planned_has_h_w(u) && !x->momentum.frozen ? u->h_w : x->l_own;
}

/* Whether a plan is flown. */
static inline bool is_planned(int32_t phase)
{
    return phase == PHASE_ACQUISITION || phase == PHASE_HOLD;
}

/* The satellite as its parameters have it. */
Model controller_planned_nominal(const ControllerPlannedLaw *law, const Scales *scales);

/* The satellite as it is estimated now. */
Model controller_planned_estimated(const ControllerPlannedLaw *law, const ControllerPlannedState *x);

/* Whether the stiffness, given or computed, is one that the damping makes stable: once for the parameters as they
 * stand. */
bool controller_planned_gains_fit(ControllerPlannedLaw *law, const Scales *scales, Fault *f);

/* Whether the inputs have numbers, and what belongs together is connected together. */
bool controller_planned_inputs_finite(const ControllerPlannedInputs *u, Fault *f);

/* The same, and whether they are an attitude, a reference and a closed orbit about a body of mu, m3/s2. */
bool controller_planned_inputs_fit(const ControllerPlannedInputs *u, double mu, Fault *f);

/* Where a plan from x->t on takes its environment from. */
Ahead controller_planned_ahead_of(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                  const ControllerPlannedInputs *u);

/* The estimate after the measurement. */
Motion controller_planned_corrected(const ControllerPlannedState *x, Matrix R, Vector Omega, double l);

/* Whether h_w is frozen: while a wheel is commanded, it repeats to the bit. From then on the momentum l_own is the last
 * one that changed, and what the wheel gave since; at the sample at which it is found, until the one before. */
void controller_planned_watch_h_w(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                                  const ControllerPlannedInputs *u, double dt);

/* What rods and wheel gave over the last sample, of their limits: u_applied, or else what was asked for; the wheel by
 * h_w where connected, unless it is frozen, which is looked for here. */
void controller_planned_given(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                              const ControllerPlannedInputs *u, double dt, double given[CONTROLS]);

/* Takes the sample of the inputs at x->t: field, wheel momentum, identification and filter; x->estimate is then that
 * of now. Returns what surrounds the satellite. */
Around controller_planned_take_sample(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                                      const ControllerPlannedInputs *u, bool first);

/* The sample's decision, on the motion `now`, dt after the last; its work is bounded by WORK_OF_SAMPLE. At the first
 * sample there is no command to go on with: what the search has come to is flown. */
void controller_planned_decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead,
                               const Motion *now, double dt, bool first);

/* The outputs without an attitude: rates are damped in the measured field, by what is known of the satellite. */
ControllerPlannedOutputs controller_planned_without_attitude(const ControllerPlannedLaw *law,
                                                             const ControllerPlannedState *x,
                                                             const ControllerPlannedInputs *u);

/* All outputs of the inputs as they stand and the motion `now`, on what was decided at the sample x->t; `controls`
 * are those of the feed-forward. */
void controller_planned_command(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, const Motion *now, double controls[CONTROLS],
                                ControllerPlannedOutputs *y);

#endif
