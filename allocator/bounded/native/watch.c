/* Wheels of a set that do not give what is commanded.
 * Requirement: AB-3. Tests: tests/native/test_allocator_wheels.py. */
#include "actuators.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

/* s, in which what a wheel gave is forgotten */
static const double FORGOTTEN = 300.0;
/* Of a wheel's limit: what friction may take of a command. */
static const double FRICTION = 0.05;
/* s, in which the friction of a wheel is learned; of its limit: larger commands say more of the drive's gain. */
static const double LEARNED = 30.0, SMALL_TORQUE = 0.1;
/* Of a command: less is no motion; of its limit, and s: to where, and how fast, commands of a wheel that stands rise. */
static const double MOVES = 0.1, STANDING = 0.08, LEARNED_STANDING = 15.0;
/* Of its limit, and s: commands that are no more beyond friction, for so long, say nothing of a wheel. */
static const double TRUST_TORQUE = 0.02, TRUST_TIME = 20.0;
/* s, for which this is found before a wheel counts as failed: telemetry may be a sample old. */
static const double CONFIRMED = 2.0;
/* s, after which a wheel that failed is tried again. */
static const double RETRY = 3000.0;
/* Of its limit, and s: the command by which it is tried, forth and back. */
static const double PROBE_TORQUE = 0.2, PROBE_TIME = 2.0;

bool allocator_bounded_wheel_failed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i)
{
    return law->p.find_failures && x->failed_for[i] > 0.0;
}

double allocator_bounded_wheel_gain(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                    const AllocatorBoundedInputs *u, int i)
{
    if (allocator_bounded_has_wheel_gains(u)) {
        return u->wheel_gains[i];
    }
    return allocator_bounded_wheel_failed(law, x, i) ? 0.0 : 1.0;
}

double allocator_bounded_tried_torque(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                      const AllocatorBoundedInputs *u, int i, double preferred)
{
    const double since = x->failed_for[i] - RETRY;
    if (since <= 0.0 || !law->p.find_failures || allocator_bounded_has_wheel_gains(u)) {
        return preferred;
    }
    return (since < 0.5 * PROBE_TIME ? PROBE_TORQUE : -PROBE_TORQUE) * law->p.wheel_torque_max[i];
}

/* The mean sign of a momentum that goes from one to the other evenly. */
static double mean_sign(double from, double to)
{
    const double sign = from > 0.0 ? 1.0 : from < 0.0 ? -1.0 : 0.0;
    return from * to < 0.0 ? (fabs(to) - fabs(from)) / (to - from)
           : from != 0.0   ? sign
           : to > 0.0      ? 1.0
           : to < 0.0      ? -1.0
                           : 0.0;
}

double allocator_bounded_with_friction(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                       const AllocatorBoundedInputs *u, int i, double wanted)
{
    const double limit = law->p.wheel_torque_max[i];
    if (!(law->p.find_failures && x->friction[i] > 0.0)) {
        return wanted;
    }
    const double sign = mean_sign(u->h_w[i], u->h_w[i] + law->p.command_period * wanted);
    return clip(wanted + x->friction[i] * sign, -limit, limit);
}

/* The Coulomb friction of wheel i by what it gave less than the last command, over h; of one that does not move at all
 * more than a wheel has, so that a dead one is found by small commands, too. */
static double learned_friction(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, double h_w, double h,
                               int i)
{
    const double limit = law->p.wheel_torque_max[i], command = x->command[i], gave = (h_w - x->h_w[i]) / h;
    if (x->failed_for[i] > 0.0) {
        return 0.0;
    }
    if (fabs(command) > SMALL_TORQUE * limit) {
        return x->friction[i];
    }
    if (fabs(gave) < MOVES * fabs(command)) {
        return smaller(x->friction[i] + h / LEARNED_STANDING * (fabs(command) - x->friction[i]), STANDING * limit);
    }
    const double sign = mean_sign(x->h_w[i], h_w), taken = command - gave;
    const double change = h / (h + LEARNED) * sign * (taken - sign * x->friction[i]);
    return clip(x->friction[i] + change, 0.0, FRICTION * limit);
}

/* The part of a command that friction cannot take, N m. */
static double beyond_friction(double command, double torque_max)
{
    const double most = FRICTION * torque_max;
    return command > most ? command - most : command < -most ? command + most : 0.0;
}

void allocator_bounded_watch(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                             AllocatorBoundedState *x)
{
    const double kept = 1.0 / (1.0 + h / FORGOTTEN);
    for (int i = 0; i < law->p.wheels; ++i) {
        const double torque = TRUST_TORQUE * law->p.wheel_torque_max[i], trust = torque * torque * TRUST_TIME;
        const double command = beyond_friction(x->command[i], law->p.wheel_torque_max[i]),
                     failed_for = x->failed_for[i];
        x->friction[i] = learned_friction(law, x, u->h_w[i], h, i);
        const bool counts = failed_for <= 0.0 || failed_for > RETRY;
        x->given[i] = counts ? kept * x->given[i] + command * (u->h_w[i] - x->h_w[i]) : 0.0;
        x->asked[i] = counts ? kept * x->asked[i] + command * command * h : 0.0;
        if (failed_for <= 0.0) {
            const bool found = x->given[i] + trust < 0.5 * (x->asked[i] + trust);
            const bool confirmed = failed_for < 0.0 && h - failed_for > CONFIRMED;
            x->failed_for[i] = !found ? 0.0 : confirmed ? h : failed_for - h;
        } else if (failed_for > RETRY + PROBE_TIME) {
            x->failed_for[i] = x->given[i] > 0.5 * x->asked[i] ? 0.0 : h;
        } else {
            x->failed_for[i] = failed_for + h;
        }
    }
}

void allocator_bounded_keep(const AllocatorBoundedInputs *u, const AllocatorBoundedOutputs *y, AllocatorBoundedState *x)
{
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        x->h_w[i] = u->h_w[i];
        x->command[i] = y->wheel_torque_cmd[i];
    }
}

#endif
