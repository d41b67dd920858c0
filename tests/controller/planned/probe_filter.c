/* The planned controller's Kalman filter, one step of it at a time, for tests: flat arrays in, flat arrays out. */
#include "probe_flat.h"

typedef double Variances[FILTER_STATES][FILTER_STATES];

/* A filter without noise of its own that has a covariance. */
static Identification *with(const double *P)
{
    static Identification id;
    memset(&id, 0, sizeof id);
    memcpy(id.P, P, sizeof id.P);
    id.excess[0] = id.excess[1] = id.excess[2] = id.spread = 1.0;
    for (int i = 0; i < 3; ++i) {
        id.p[GAINS + i] = id.start[GAINS + i] = 1.0;
    }
    return &id;
}

/* The covariance after a sample of the motion under controls. */
PROBE void probe_propagate(const FlatModel *m, const FlatAround *a, const FlatMotion *x, const double u[CONTROLS],
                           double dt, double *P)
{
    const Model model = model_of(m);
    const Around around = around_of(a);
    const Motion before = motion_of(x), after = controller_planned_advanced(&model, &around, &before, u, dt);
    const Vector B_B = add(apply_transposed(before.R, around.B_N), apply_transposed(after.R, around.B_N));
    Vector rods[3];
    for (int i = 0; i < 3; ++i) {
        rods[i] = scale(u[i], model.rods[i]);
    }
    Identification *id = with(P);
    controller_planned_propagate(&(Passed){dt, &model, &around, before, after, scale(0.5, B_B), rods}, id);
    memcpy(P, id->P, sizeof id->P);
}

/* The covariance, the unknowns and the gain after a measurement with these innovations; of an attitude that an
 * estimator gives where sigma[0] is above 0. */
PROBE void probe_correct(const double variance[2], const double excess[2], const double sigma[3],
                         const double innovation[MOTION], double *P, double *p, double *gain)
{
    Identification *id = with(P);
    memcpy(id->variance, variance, sizeof id->variance);
    memcpy(id->excess, excess, 2 * sizeof id->excess[0]);
    id->sigma_B = vector(sigma);
    id->estimated = sigma[0] > 0.0;
    memset(id->p, 0, sizeof id->p);
    controller_planned_correct(innovation, id);
    memcpy(P, id->P, sizeof id->P);
    memcpy(p, id->p, sizeof id->p);
    memcpy(gain, id->gain, sizeof id->gain);
}

/* n samples of dt with innovations of turn, rate and, by the start's properties, nominal (n,3), from the start on.
 * found (n,8): excess of attitude, rate and model, mean cosines of attitude and rate, evidence, samples rejected in
 * turn, and the gain of the rate about x. Returns T, s. */
PROBE double probe_learn(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u, double dt, int n,
                         const double *turn, const double *rate, const double *nominal, double *found)
{
    Identification id;
    const Scales scales = controller_planned_scales(p, 6.971e6);
    controller_planned_identification_start(p, u, &scales, &id);
    controller_planned_set_taught(true, &id);
    for (int i = 0; i < n; ++i) {
        controller_planned_learn(dt, vector(turn + 3 * i), vector(rate + 3 * i), vector(nominal + 3 * i), false, &id);
        const double now[8] = {id.excess[0], id.excess[1], id.excess[2], id.alike[0],
                               id.alike[1],  id.evidence,  id.rejected,  id.gain[RATE_STATE][RATE_STATE]};
        memcpy(found + 8 * i, now, sizeof now);
    }
    return scales.time;
}

/* The covariance before the flight in an orbit of this semi-major axis, and once both properties and torques have begun
 * anew by a suspicion of the rods; and the model's noise at rest in T times T, that of bias and disturbance. */
PROBE void probe_start(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u, double *before,
                       double *suspected, double noise[3])
{
    Identification id;
    const Scales scales = controller_planned_scales(p, 6.971e6);
    controller_planned_identification_start(p, u, &scales, &id);
    memcpy(before, id.P, sizeof id.P);
    noise[0] = id.rate_density * scales.time * scales.time * scales.time;
    noise[1] = id.bias_density;
    const double inertia = scales.momentum * scales.time, forgotten = scales.disturbance_time / inertia;
    noise[2] = id.torque_density * forgotten * forgotten / id.rate_density;
    controller_planned_suspect_rods(&id);
    memcpy(suspected, id.P, sizeof id.P);
}

/* Of gains and those before the flight, with the deviation of each, and a dipole with that of each axis: the rod that has
 * failed, and ten more where one is stuck on. */
PROBE int probe_failed_rod(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                           const double gains[3], const double sigma[3], const double dipole[3], double sigma_dipole,
                           int wide)
{
    Identification id;
    const Scales scales = controller_planned_scales(p, 6.971e6);
    controller_planned_identification_start(p, u, &scales, &id);
    id.watch.wide = wide;
    for (int i = 0; i < 3; ++i) {
        id.p[GAINS + i] = gains[i];
        id.p[DIPOLE + i] = dipole[i];
        id.P[MOTION + GAINS + i][MOTION + GAINS + i] = sigma[i] * sigma[i];
        id.P[MOTION + DIPOLE + i][MOTION + DIPOLE + i] = sigma_dipole * sigma_dipole;
    }
    return controller_planned_failed_rod(&id) + (controller_planned_stuck_on(&id) ? 10 : 0);
}
