/* Rods that fail: docs/how/planned-wheels.md, Failures. The filter of controller_planned watches them, with what the
 * wheels took over the sample as one wheel of its own. */
#include <string.h>

#include "sample.h"

static const double SIGMA = 0.01; /* rad, of the attitude: the filter takes it as it is, and learns from the rate */
static const double WAIT = 300.0; /* s, in which an estimator comes to know rate and field */
static const double PAUSE = 4.0;  /* T, in which the filter comes to know the noise of the rate */
/* Of the rods' torque and dipole, what lasts: with wheels a satellite bears more than one that the rods have to hold.
 * That torque changes so much sooner than controller_planned takes it to. */
static const double DISTURBANCE = 0.1, RESIDUAL = 0.2, SOONER = 10.0;
static const double NOISE = 0.005;                          /* 1/T, of the rate: errors of the model are no less */
static const double LEAST_WHEEL = 1e-9;                     /* N m, where the wheels took nothing */
static const double KNOWN = 0.1;                            /* deviation of a gain from which on it is known */
static const double WEAK = 0.4, SOUND = 0.2, CERTAIN = 8.0; /* what is missing of a gain; deviations beyond SOUND */
static const double DEAD = 0.2;                             /* of a gain: commands are no larger for less */
static const double MOVED =
    0.03; /* of a wheel's limit: one that has not moved so far may tell a momentum that stands */

bool controller_planned_wheels_start_rods(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u,
                                          ControllerPlannedWheelsState *x, Fault *f)
{
    ControllerPlannedInputs none = controller_planned_wheels_seen(u, x, WHEELS_MAX + 1);
    (void)memset(none.R_NB, 0, sizeof none.R_NB);
    if (!controller_planned_start(&law->planned, &none, &x->planned, f)) {
        return false;
    }
    Scales *scales = &x->planned.scales;
    scales->disturbance_max = DISTURBANCE * scales->torque;
    scales->residual_dipole_max = RESIDUAL * law->rods_dipole;
    scales->disturbance_time /= SOONER;
    scales->fast_nutation = true; /* by all wheels together */
    controller_planned_identification_start(&law->planned.p, &none, scales, &x->planned.identification);
    return true;
}

/* Whether what the rods do shows: their commands, field and attitude are known, on an orbit of the Earth, and the wheels
 * tell their momenta: by what stands in for them the rods would seem to give nothing. */
static bool shows(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u)
{
    const Vector r = vector(u->r_N), v = vector(u->v_N);
    const double size = norm(r), mu = law->planned.p.gravitational_parameter;
    const bool tell = !(u->h_w_failed[0] || u->h_w_failed[1] || u->h_w_failed[2] || u->h_w_failed[3]);
    return tell && controller_planned_wheels_has_dipole_applied(u) && !is_zero_matrix(matrix(u->R_NB)) &&
           norm(vector(u->b_B)) >= WHEELS_FIELD_MIN && size >= ONBOARD_R_MIN && dot(v, v) * size < 2.0 * mu;
}

/* The gains that are believed: those of rods that have failed, until they are sound, else 1; while a gain is not known,
 * that of before. */
static void believe(const Identification *id, ControllerPlannedWheelsState *x)
{
    double gains[3];
    store(x->rod_gains, gains);
    for (int i = 0; i < 3; ++i) {
        const int at = MOTION + GAINS + i;
        const double gain = id->p[GAINS + i], sigma = sqrt(larger(id->P[at][at], 0.0));
        if (!id->watch.wide) {
            gains[i] = 1.0;
        } else if (sigma < KNOWN) {
            const bool fails = 1.0 - gain > larger(WEAK, SOUND + CERTAIN * sigma);
            gains[i] = fails || (gains[i] < 1.0 && 1.0 - gain > SOUND) ? gain : 1.0;
        }
    }
    x->rod_gains = vector(gains);
}

/* Whether each wheel works, and has moved since the watch began: else its telemetry may have frozen before. */
static bool move(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u, bool first,
                 ControllerPlannedWheelsState *x)
{
    bool all = true;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        x->lowest[i] = first ? u->h_w[i] : smaller(x->lowest[i], u->h_w[i]);
        x->highest[i] = first ? u->h_w[i] : larger(x->highest[i], u->h_w[i]);
        const bool tells = !u->wheel_failed[i] && x->highest[i] - x->lowest[i] > MOVED * law->p.wheel_momentum_max[i];
        all = all && (i >= law->p.wheels || tells);
    }
    return all;
}

void controller_planned_wheels_watch_rods(ControllerPlannedWheelsLaw *law, const Sample *s, double h,
                                          const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsState *x)
{
    const bool goes_on = x->shown >= WAIT;
    x->shown = shows(law, u) ? x->shown + h : 0.0;
    if (!(x->shown >= WAIT)) {
        return;
    }
    if (law->few != WHEELS_MAX + 1) {
        controller_planned_wheels_prepare_few(law, WHEELS_MAX + 1);
    }
    ControllerPlannedLaw *planned = &law->planned;
    const Vector axis = planned->wheel_axis, taken = subtract(s->h, x->h);
    const double size = norm(taken), torque_max = planned->p.wheel_torque_max;
    const double momentum_max = planned->p.wheel_momentum_max, noise = planned->p.rate_noise;
    const double torque = goes_on && h > 0.0 ? size / h : 0.0;
    ControllerPlannedInputs now = controller_planned_wheels_seen(u, x, WHEELS_MAX + 1);
    store((Vector){SIGMA, SIGMA, SIGMA}, now.attitude_sigma_B);
    now.h_w = 1e9; /* not connected: it is what the one wheel takes in a sample */
    now.u_applied[3] = torque;
    planned->wheel_axis = size > 0.0 ? direction(size, taken) : axis;
    planned->p.wheel_torque_max = larger(torque, LEAST_WHEEL);
    planned->p.wheel_momentum_max = INFINITY;
    planned->p.rate_noise = larger(noise, NOISE / x->planned.scales.time);
    planned->beside_B = x->h;
    x->planned.t = x->t;
    x->planned.l_own = x->planned.estimate.l = 0.0;
    if (!goes_on) {
        x->planned.identification.watch.paused = PAUSE * x->planned.scales.time;
    }
    (void)controller_planned_take_sample(planned, &x->planned, &now, !goes_on);
    planned->wheel_axis = axis;
    planned->p.wheel_torque_max = torque_max;
    planned->p.wheel_momentum_max = momentum_max;
    planned->p.rate_noise = noise;
    x->h = s->h;
    if (move(law, u, !goes_on, x)) {
        believe(&x->planned.identification, x);
    }
}

/* The command whose dipole is the wanted one, as far as the rod gives it; of a dead rod the wanted one. */
static double by_gain(double wanted, double gain, double limit)
{
    return fabs(gain) < DEAD ? wanted : clip(wanted / gain, -limit, limit);
}

Vector controller_planned_wheels_by_gains(const ControllerPlannedWheelsLaw *law, Vector gains, Vector wanted)
{
    const double most = law->p.dipole_max, *limits = law->p.rod_limits;
    return (Vector){by_gain(wanted.x, gains.x, most * limits[0]), by_gain(wanted.y, gains.y, most * limits[1]),
                    by_gain(wanted.z, gains.z, most * limits[2])};
}

void controller_planned_wheels_report_rods(Vector gains, ControllerPlannedWheelsOutputs *y)
{
    double farthest = 0.0;
    store(gains, y->rod_gains_estimate);
    y->failed_rod = 0;
    for (int i = 0; i < 3; ++i) {
        const double change = fabs(y->rod_gains_estimate[i] - 1.0);
        if (change > farthest) {
            farthest = change;
            y->failed_rod = i + 1;
        }
    }
    y->rod_failed = y->failed_rod > 0;
}
