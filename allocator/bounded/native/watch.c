/* Wheels of a set that do not give what is commanded, by their telemetry and by the body.
 * Requirement: AB-3. Tests: tests/native/test_allocator_failed_wheels.py. */
#include "actuators.h"
#include "rotation.h"
#include "trial.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

/* s, in which what a wheel gave is forgotten */
static const double FORGOTTEN = 300.0;
/* s, in which the friction of a wheel is learned; of its limit: larger commands say more of the drive's gain. */
static const double LEARNED = 30.0, SMALL_TORQUE = 0.1;
/* Of a command: less is no motion; of its limit, and s: to where, and how fast, commands of a wheel that stands rise. */
static const double MOVES = 0.1, STANDING = 0.08, LEARNED_STANDING = 15.0;
/* Of its limit, and s: commands that are no more beyond friction, for so long, say nothing of a wheel. */
static const double TRUST_TORQUE = 0.02, TRUST_TIME = 20.0;
/* s, for which this is found before a wheel counts as failed: telemetry may be a sample old. */
static const double CONFIRMED = 2.0;
/* Of what a wheel can do in a sample, and of its momentum's limit: telemetry that changes by more is wrong. */
static const double JUMP = 2.0, JUMP_LEAST = 0.01;
/* Of the square of what a momentum changes beside the commands: noise by which it does not repeat. */
static const double NOISE = 0.2;
/* Of its commands: a wheel that has failed gives less, as the body shows it by an inertia that is not exact. */
static const double BODY_SHOWS = 0.7, BODY_ALONE = 0.4; /* the latter where h_w is left out */
static const double AT_LIMIT = 0.99; /* of its momentum's limit: a trial that moves it no further says nothing */
/* Of the torques of all wheels: a body that shows more is not moved by them. */
static const double BODY_MOST = 4.0;
/* Of the friction that was learned, what counts without telemetry: by less the momentum drifts until friction turns
 * round, by more it runs away. Beyond this share of the limit the momentum fades, s: what drifts is not taken for full. */
static const double BLIND_FRICTION = 0.8, BLIND_MOMENTUM = 0.6, BLIND_FADES = 100.0;
/* s, over which commands and what the body answers are smoothed: its rate's noise is in the commands, too. */
static const double SMOOTHED = 5.0;
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
    if (!(law->p.find_failures && x->friction[i] > 0.0) || allocator_bounded_wheel_failed(law, x, i)) {
        return wanted;
    }
    const double h_w = allocator_bounded_wheel_momentum(law, x, u, i), forth = allocator_bounded_sign(law, x, i);
    const double sign = mean_sign(h_w, h_w + law->p.command_period * forth * wanted);
    return clip(wanted + x->friction[i] * forth * sign, -limit, limit);
}

/* What wheel i gives of its last command, N m, by what is known of it. */
static double by_command(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                         const AllocatorBoundedInputs *u, int i)
{
    const double torque = allocator_bounded_wheel_gain(law, x, u, i) * x->command[i], h_w = x->h_w[i];
    const double known = law->p.find_failures ? x->friction[i] : 0.0;
    const double friction = x->telemetry[i].frozen ? BLIND_FRICTION * known : known;
    return torque - friction * mean_sign(h_w, h_w + law->p.command_period * torque);
}

/* The Coulomb friction of wheel i by what it gave less than the last command, where its momentum changed over h; of one
 * that does not move at all more than a wheel has, so that a dead one is found by small commands, too. */
static double learned_friction(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, double change, double h,
                               int i)
{
    const double limit = law->p.wheel_torque_max[i], command = allocator_bounded_sign(law, x, i) * x->command[i],
                 gave = change / h;
    if (x->failed_for[i] > 0.0) {
        return 0.0;
    }
    if (fabs(command) > SMALL_TORQUE * limit) {
        return x->friction[i];
    }
    if (fabs(gave) < MOVES * fabs(command)) {
        return smaller(x->friction[i] + h / LEARNED_STANDING * (fabs(command) - x->friction[i]), STANDING * limit);
    }
    const double sign = mean_sign(x->h_w[i], x->h_w[i] + change), taken = command - gave;
    const double moved = h / (h + LEARNED) * sign * (taken - sign * x->friction[i]);
    return clip(x->friction[i] + moved, 0.0, FRICTION * limit);
}

/* The part of a command that friction cannot take, N m. */
static double beyond_friction(double command, double torque_max)
{
    const double most = FRICTION * torque_max;
    return command > most ? command - most : command < -most ? command + most : 0.0;
}

/* The change of the momentum of wheel i over h, N m s: that of h_w, or where that shows nothing the one by its command. */
static double take_telemetry(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h, int i,
                             AllocatorBoundedState *x)
{
    const double most = law->p.wheel_momentum_max[i], given = by_command(law, x, u, i);
    MomentumWatch *telemetry = &x->telemetry[i];
    const double change = u->h_w[i] - telemetry->h_w, samples = (double)telemetry->run + 1.0;
    const bool jumps = fabs(change) > JUMP * law->p.wheel_torque_max[i] * h * samples + JUMP_LEAST * most;
    const bool was_frozen = telemetry->frozen;
    watch_momentum(h, u->h_w[i], given, most, NOISE, jumps || x->doubted_for[i] > CONFIRMED, telemetry);
    if (telemetry->frozen) {
        const double within = clip(telemetry->l, -BLIND_MOMENTUM * most, BLIND_MOMENTUM * most);
        telemetry->l = clip(telemetry->l + h / (h + BLIND_FADES) * (within - telemetry->l), -most, most);
    }
    if (telemetry->frozen && !was_frozen) {
        x->friction[i] = telemetry->noisy ? x->friction[i] : 0.0; /* else it learned by what repeats */
        x->doubted_for[i] = 0.0;
    }
    return telemetry->blind ? h * given : change;
}

/* What the wheels gave over h beside the changes of their momenta, N m s: as the body moved, whose inertia is known. */
static Vector unseen(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                     const double change[ALLOCATOR_BOUNDED_WHEELS], const AllocatorBoundedState *x)
{
    const Matrix J = matrix(law->p.J_B);
    const Vector before = vector(x->omega_B), now = vector(u->omega_B), Omega = scale(0.5, add(before, now));
    const Vector by_rods = cross(apply_transposed(matrix(law->U), vector(x->dipole)), vector(u->b_B));
    Vector momentum = apply(J, Omega), seen = {0.0, 0.0, 0.0};
    double most = 0.0;
    for (int i = 0; i < law->p.wheels; ++i) {
        const Vector axis = vector(law->axis[i]);
        momentum = add(momentum, scale(x->h_w[i] + 0.5 * change[i], axis));
        seen = add(seen, scale(change[i], axis));
        most += BODY_MOST * law->p.wheel_torque_max[i] * h;
    }
    const Vector by_torques = scale(h, subtract(by_rods, cross(Omega, momentum)));
    const Vector left = subtract(subtract(by_torques, apply(J, subtract(now, before))), seen);
    return norm(left) < most ? left : (Vector){0.0, 0.0, 0.0};
}

/* Whether wheel i has failed, and whether its telemetry is doubted, a step of h later. */
static void decide(AllocatorBoundedState *x, double trust, bool by_inertia, double h, int i)
{
    const double failed_for = x->failed_for[i];
    const bool frozen = x->telemetry[i].frozen, body_shows = x->called[i] > trust;
    const bool less = frozen || x->given[i] + trust < 0.5 * (x->asked[i] + trust);
    const bool answers = x->answered[i] > (frozen ? BODY_ALONE : BODY_SHOWS) * x->called[i];
    const bool found = less && (by_inertia ? body_shows && !answers : !frozen);
    const bool confirmed = h - failed_for > CONFIRMED;
    x->failed_for[i] = !found ? 0.0 : failed_for < 0.0 && confirmed ? RETRY + h : failed_for - h;
    if (x->failed_for[i] > RETRY) {
        allocator_bounded_forget(x, i);
    }
    x->doubted_for[i] = !frozen && less && body_shows && answers ? x->doubted_for[i] + h : 0.0;
}

void allocator_bounded_watch(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                             AllocatorBoundedState *x)
{
    const double kept = 1.0 / (1.0 + h / FORGOTTEN);
    double change[ALLOCATOR_BOUNDED_WHEELS] = {0.0};
    for (int i = 0; i < law->p.wheels; ++i) {
        change[i] = take_telemetry(law, u, h, i, x);
    }
    const bool by_inertia = !is_zero_matrix(matrix(law->p.J_B));
    const Vector left = by_inertia ? unseen(law, u, h, change, x) : (Vector){0.0, 0.0, 0.0};
    for (int i = 0; i < law->p.wheels; ++i) {
        const double torque = TRUST_TORQUE * law->p.wheel_torque_max[i], trust = torque * torque * TRUST_TIME;
        const bool blind = x->telemetry[i].blind, counts = x->failed_for[i] <= 0.0 || x->failed_for[i] > RETRY;
        const double by_body = change[i] + dot(vector(law->axis[i]), left), shown = blind ? by_body : change[i];
        x->friction[i] = blind ? x->friction[i] : learned_friction(law, x, shown, h, i);
        const double forth = allocator_bounded_sign(law, x, i), given = forth * x->command[i];
        const double end = AT_LIMIT * law->p.wheel_momentum_max[i];
        const bool stopped = x->failed_for[i] > RETRY && fabs(x->h_w[i]) > end && fabs(u->h_w[i]) > end;
        const double command = stopped ? 0.0 : beyond_friction(given, law->p.wheel_torque_max[i]);
        x->given[i] = counts ? kept * x->given[i] + command * shown : 0.0;
        x->asked[i] = counts ? kept * x->asked[i] + command * command * h : 0.0;
        const double share = by_inertia ? h / (h + SMOOTHED) : 0.0;
        x->slow_command[i] += share * (given - x->slow_command[i]);
        x->slow_answer[i] += share * (by_body / h - x->slow_answer[i]);
        const double slow = beyond_friction(x->slow_command[i], law->p.wheel_torque_max[i]);
        x->answered[i] = counts ? kept * x->answered[i] + slow * x->slow_answer[i] * h : 0.0;
        x->called[i] = counts ? kept * x->called[i] + slow * slow * h : 0.0;
        if (x->failed_for[i] > 0.0) {
            allocator_bounded_try_again(x, forth, h, i);
        } else {
            decide(x, trust, by_inertia, h, i);
        }
    }
}

void allocator_bounded_keep(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, AllocatorBoundedOutputs *y,
                            AllocatorBoundedState *x)
{
    const bool with_gains = allocator_bounded_has_rod_gains(u);
    for (int i = 0; i < 3; ++i) {
        x->omega_B[i] = u->omega_B[i];
        x->dipole[i] = (with_gains ? u->rod_gains[i] : 1.0) * y->dipole_cmd[i];
    }
    for (int i = 0; i < law->p.wheels; ++i) {
        x->h_w[i] = allocator_bounded_wheel_momentum(law, x, u, i);
        x->command[i] = y->wheel_torque_cmd[i];
        x->expected[i] = y->h_w_estimate[i] = x->h_w[i] + law->p.command_period * by_command(law, x, u, i);
    }
}

void allocator_bounded_begin(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u,
                             AllocatorBoundedOutputs *y, AllocatorBoundedState *x)
{
    allocator_bounded_keep(law, u, y, x);
    for (int i = 0; i < law->p.wheels; ++i) {
        x->telemetry[i].h_w = x->telemetry[i].l = x->expected[i] = u->h_w[i];
    }
}

#endif
