/* Friction, slip and failure of the wheel: docs/how/planned-estimates.md, Wheel, whose equations (F1) to (F4) these
 * are. Tests: test_identification.py, test_failures.py. */
#include "friction.h"

#include <math.h>
#include <string.h>

#include "vector.h"

static const double EXPECTED = 0.1;         /* of the wheel's limits: deviation of either torque before the flight */
static const double NOISE = 0.01;           /* of the torque's limit, of a sample */
static const double CHANGES_TIME = 1e5;     /* s, in which friction may become another */
static const double SHARE_MAX = 0.5;        /* of the torque's limit: largest friction of either kind */
static const double FORGETS = 2.0;          /* T, over which the noise of the measured momentum is found */
static const double NOISY = 1.2;            /* by which the noise is taken to be larger than is found (F3) */
static const double GAIN_MIN = 0.05;        /* of the measurement where it is noise alone */
static const double OUTLIER = 100.0;        /* torque limits, from which a change of momentum is no wheel's */
static const double TINY = 1e-300;          /* keeps a variance of zero from dividing */
static const double NEAR_LIMIT = 0.99;      /* of the momentum's limit, beyond which the motor may be stopped */
static const double DRAG_EXCITATION = 0.2;  /* of the torque's limit: less shows little of a wheel that drags */
static const double STALL_EXCITATION = 0.7; /* the same of one that is stuck: one that drags moves under so much */
static const double WATCHED = 0.2;          /* of `forgets`: time of such samples from which on a failure is known */
static const double FAILED = 0.5; /* share of the torque that the wheel gives, below which it has failed (F4) */
static const double STUCK = 0.05; /* the same, below which it is stuck */

static const double FOLLOWED = 3.0;    /* T, over which the wheel is to follow its torque (F5) */
static const double FOLLOWS_NOT = 0.1; /* share of its torque that a stuck wheel may seem to follow */
static const double MOVED = 6.0;       /* deviations of the momentum's noise, by which the wheel has moved */
static const double MOVED_MIN = 5e-4;  /* the same, at least, of the momentum's limit */
static const double CERTAIN = 5.0;     /* deviations by which a share is told from half */
static const double HELD = 4.0;        /* times that band, by which a wheel that friction does not hold has left it */
static const double STANDING = 2e-3;   /* of the momentum's limit, below which friction may hold a sound wheel */
static const double FLOOR = 1e-3;      /* of the torque's limit: noise of a sample at least */

void controller_planned_friction_start(const ControllerPlannedParameters *p, double T, Friction *friction)
{
    const double torque = EXPECTED * p->wheel_torque_max, decay = torque / p->wheel_momentum_max;
    const double noise = NOISE * p->wheel_torque_max;
    memset(friction, 0, sizeof *friction);
    friction->variance = noise * noise;
    friction->torque_max = p->wheel_torque_max;
    friction->momentum_max = p->wheel_momentum_max;
    friction->forgets = FORGETS * T;
    friction->followed = FOLLOWED * T;
    friction->period = p->control_period;
    if (p->identify) {
        friction->P[0][0] = torque * torque;
        friction->P[1][1] = decay * decay;
        friction->density[0] = friction->P[0][0] / CHANGES_TIME;
        friction->density[1] = friction->P[1][1] / CHANGES_TIME;
    }
}

/* p[i] from 0 to the limit; where it is moved the other goes with it, as their covariance has it. */
static void keep_within(Friction *friction, int i, double limit)
{
    const double moved = clip(friction->p[i], 0.0, limit) - friction->p[i];
    if (moved != 0.0) {
        friction->p[1 - i] += friction->P[1 - i][i] / larger(friction->P[i][i], TINY) * moved;
        friction->p[i] += moved;
    }
}

static void respond(double dt, double share, double torque, double rate, Response *response)
{
    response->asked += share * (torque * torque - response->asked);
    response->given += share * (torque * rate - response->given);
    response->seen += dt;
}

/* (N m)2, of a measured change of momentum over a sample, at most: white noise bends it by three times as much. */
static double variance_of_noise(const Friction *friction)
{
    const double floor = FLOOR * friction->torque_max;
    return larger(friction->bends / 3.0, floor * floor);
}

/* Takes a torque and the change of momentum. */
static void follow(double dt, double applied, double rate, Friction *friction)
{
    Following *f = &friction->following;
    const double share = smaller(dt / larger(smaller(f->seen, friction->followed), dt), 1.0);
    const double torque = applied - f->torque, change = rate - f->rate, jump = applied - f->last;
    f->torque += share * torque;
    f->rate += share * change;
    f->square += share * ((1.0 - share) * torque * torque - f->square);
    f->common += share * ((1.0 - share) * torque * change - f->common);
    f->jumps += share * ((f->seen > 0.0 ? jump * jump : 0.0) - f->jumps);
    f->last = applied;
    f->seen += dt;
}

/* N m s, within which noise alone moves the measured momentum. */
static double band_of_noise(double dt, const Friction *friction)
{
    return larger(MOVED * dt * sqrt(0.5 * variance_of_noise(friction)), MOVED_MIN * friction->momentum_max);
}

/* Whether friction holds the wheel: it stays about standstill, where the torque beyond the known friction should have
 * moved it away. */
static bool is_held(double dt, double torque, double l, double l_next, Friction *friction)
{
    const double band = band_of_noise(dt, friction), known = friction->p[0];
    const double beyond = torque - clip(torque, -known, known);
    const bool stays = larger(fabs(l), fabs(l_next)) < band;
    friction->pushed = stays ? friction->pushed + dt * beyond : 0.0;
    return (l == 0.0 && l_next == 0.0 && beyond != 0.0) ||
           (beyond * friction->pushed > 0.0 && fabs(friction->pushed) > HELD * band);
}

/* Whether the wheel fails. */
static void watch(double dt, double torque, double l, double l_next, Friction *friction)
{
    if (larger(fabs(l), fabs(l_next)) >= NEAR_LIMIT * friction->momentum_max) {
        return;
    }
    const double share = smaller(dt / (WATCHED * friction->forgets), 1.0), rate = (l_next - l) / dt;
    if (fabs(torque) >= DRAG_EXCITATION * friction->torque_max) {
        respond(dt, share, torque, rate, &friction->drag);
    }
    if (fabs(torque) >= STALL_EXCITATION * friction->torque_max) {
        respond(dt, share, torque, rate, &friction->stall);
    }
    const double bend = rate - friction->rate;
    friction->bends += smaller(dt / friction->followed, 1.0) * (bend * bend - friction->bends);
    friction->rate = rate;
    const double band = band_of_noise(dt, friction);
    const bool turns = smaller(fabs(l), fabs(l_next)) > STANDING * friction->momentum_max;
    if (!friction->stuck && fabs(l_next - friction->following.momentum) > band) { /* it is not stuck */
        friction->following = (Following){.momentum = l_next};
    }
    if (turns || friction->stuck || fabs(torque) >= DRAG_EXCITATION * friction->torque_max) {
        follow(dt, torque, rate, friction);
    }
}

void controller_planned_friction_learn(double dt, double torque, double l, double l_next, Friction *friction)
{
    watch(dt, torque, l, l_next, friction);
    double side = l > 0.0 ? 1.0 : -1.0;
    if (is_held(dt, torque, l, l_next, friction)) {
        side = torque > 0.0 ? 1.0 : -1.0; /* friction is no less than the torque */
    } else if (!(l * l_next > 0.0 && larger(fabs(l), fabs(l_next)) < NEAR_LIMIT * friction->momentum_max)) {
        return; /* it is not known how long friction acted to either side, or the wheel was at its limit */
    }
    const double row[2] = {side, 0.5 * (l + l_next)}; /* (F1) */
    double column[2], spread = friction->variance, error = torque - (l_next - l) / dt;
    for (int i = 0; i < 2; ++i) {
        friction->P[i][i] += friction->density[i] * dt;
        column[i] = friction->P[i][0] * row[0] + friction->P[i][1] * row[1];
        spread += column[i] * row[i];
        error -= friction->p[i] * row[i];
    }
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            friction->P[i][j] -= column[i] * column[j] / spread;
        }
    }
    for (int i = 0; i < 2; ++i) {
        friction->p[i] += column[i] / spread * error;
    }
    const double most = SHARE_MAX * friction->torque_max;
    keep_within(friction, 0, most);
    keep_within(friction, 1, most / friction->momentum_max);
    friction->p[0] = clip(friction->p[0], 0.0, most);
}

/* Whether it has given less than a share of what was asked. */
static bool gives_less(const Response *response, double share, double watched)
{
    return response->seen > watched && response->given < share * response->asked;
}

/* By how many deviations the share of the torque that the wheel follows is above a half. White noise of the momentum,
 * which alternates in its changes, shows by the torque's jumps alone. */
static double above_half(const Friction *friction)
{
    const Following *f = &friction->following;
    const double samples = 2.0 * friction->followed / friction->period;
    const double sigma = sqrt(0.5 * variance_of_noise(friction) * f->jumps / samples);
    return f->seen < friction->followed ? 0.0 : (f->common - 0.5 * f->square) / (sigma + TINY);
}

bool controller_planned_wheel_failed(const Friction *friction)
{
    return friction->stuck || gives_less(&friction->drag, FAILED, WATCHED * friction->forgets);
}

bool controller_planned_wheel_changes(Friction *friction)
{
    const Following *f = &friction->following;
    const double above = above_half(friction);
    const bool stops = gives_less(&friction->stall, STUCK, WATCHED * friction->forgets) ||
                       (above < -CERTAIN && f->common < FOLLOWS_NOT * f->square);
    if (friction->stuck ? above < CERTAIN : !stops) {
        return false;
    }
    friction->stuck = !friction->stuck;
    friction->drag = friction->stall = (Response){0.0, 0.0, 0.0};
    memset(&friction->following, 0, sizeof friction->following);
    return true;
}

double controller_planned_friction_torque(const Friction *friction, double l, double rate, double dt)
{
    const double next = l + rate * dt;
    const double side = next > 0.0 ? 1.0 : next < 0.0 ? -1.0 : 0.0;
    return friction->p[0] * side + friction->p[1] * l;
}

double controller_planned_wheel_rate(double dt, double torque, double l, double l_next, Friction *friction)
{
    const double measured = (l_next - l) / dt;
    const double net = torque - controller_planned_friction_torque(friction, l, measured, dt);
    const double slip = measured - net, share = smaller(dt / friction->forgets, 1.0);
    if (!(fabs(slip) < OUTLIER * friction->torque_max)) {
        return measured;
    }
    friction->square += share * (slip * slip - friction->square);
    friction->product += share * (slip * friction->last - friction->product);
    friction->last = slip;
    /* White noise of the momentum alternates: its product is minus half of its square (F3). */
    const double noise = NOISY * larger(-2.0 * friction->product, 0.0);
    const double gain = noise > 0.0 ? clip(1.0 - noise / friction->square, GAIN_MIN, 1.0) : 1.0;
    friction->slip += gain * (slip - friction->slip);
    return net + friction->slip;
}
