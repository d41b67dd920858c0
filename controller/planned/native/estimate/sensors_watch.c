/* docs/how/planned-estimates.md, Failures. Tests: test_failures.py. */
#include "sensors_watch.h"

#include <string.h>

static const double FROZEN = 0.04;       /* T, for which an attitude that repeats is frozen */
static const double FIELD_FROZEN = 0.4;  /* T, the same of a field, which a coarse resolution may repeat for longer */
static const double TURN_MIN = 1e-3;     /* rad by the rate, below which an attitude may repeat */
static const double NOISE = 6.0;         /* the same in deviations of its noise */
static const double JUMP = 0.02;         /* rad in a sample, by which actuators change no rate */
static const double RESIDUAL_TIME = 1.2; /* T, over which the field's residual is smoothed */
static const double STRENGTH = 0.25;     /* of the tolerance: an attitude that is wrong changes no strength */
static const double RIGHT = 0.5;         /* of the tolerance, below which a field is used again */

/* Samples of a momentum that repeat the last one, for each that did so before in turn; and that change, before it is
 * watched or used again. */
enum { REPEATS = 20 };
static const double AVERAGED = 40.0; /* samples, over which its noise is found */
static const double MOSTLY = 0.5;    /* share of the slip's square that is noise where the momentum has noise */
static const double ROUNDING = 1e-7; /* of the momentum's limit: less is no noise */

void controller_planned_watch_attitude(double dt, double T, double noise, Matrix R, Vector Omega_before, Vector Omega,
                                       SensorsWatch *watch)
{
    if (memcmp(&R, &watch->R, sizeof R) != 0) {
        watch->R = watch->turned_R = R;
        watch->R_repeats = watch->turned = 0.0;
        watch->attitude_frozen = false;
        return;
    }
    /* A rate that jumps is no rate. */
    const bool jumps = !(dt * norm(subtract(Omega, Omega_before)) < JUMP);
    const Vector turn = scale(dt, jumps ? Omega_before : scale(0.5, add(Omega_before, Omega)));
    watch->R_repeats += dt;
    watch->turned += norm(turn);
    watch->turned_R = multiply(watch->turned_R, rotation_exp(turn));
    watch->attitude_frozen = watch->R_repeats > FROZEN * T && watch->turned > larger(NOISE * noise, TURN_MIN);
}

void controller_planned_watch_field(double dt, double T, double tolerance, Vector b_B, Vector model_B,
                                    SensorsWatch *watch)
{
    const double share = smaller(dt / (RESIDUAL_TIME * T), 1.0);
    const double strength = fabs(norm(b_B) - norm(model_B));
    watch->residual_B = add(watch->residual_B, scale(share, subtract(subtract(b_B, model_B), watch->residual_B)));
    watch->strength += share * (strength - watch->strength);
    watch->b_repeats = memcmp(&b_B, &watch->b_B, sizeof b_B) == 0 ? watch->b_repeats + dt : 0.0;
    watch->b_B = b_B;
    const double size = norm(watch->residual_B);
    const bool wrong =
        watch->field_failed ? size > RIGHT * tolerance : size > tolerance && watch->strength > STRENGTH * tolerance;
    watch->field_failed = wrong || watch->b_repeats > FIELD_FROZEN * T;
}

/* Whether it has noise: its changes alternate about what the wheel gives, by more than rounding. A wheel that is stuck
 * or stands does not repeat then. */
static bool is_noisy(double dt, double limit, const MomentumWatch *watch)
{
    const double noise = -2.0 * watch->product; /* (F3) */
    return noise > MOSTLY * watch->square && dt * sqrt(0.5 * noise) > ROUNDING * limit;
}

/* A new momentum. */
static void take_momentum(double dt, double h_w, double given, MomentumWatch *watch)
{
    if (watch->run == 0 && watch->changes > 0) {
        const double slip = (h_w - watch->h_w) / dt - given;
        watch->square += (slip * slip - watch->square) / AVERAGED;
        watch->product += (slip * watch->slip - watch->product) / AVERAGED;
        watch->slip = slip;
    }
    watch->longest = !watch->frozen && watch->run > watch->longest ? watch->run : watch->longest;
    watch->run = 0;
    if (watch->changes < REPEATS) {
        ++watch->changes;
    }
    watch->h_w = watch->l = h_w;
}

void controller_planned_watch_momentum(double dt, double h_w, double given, double limit, MomentumWatch *watch)
{
    const bool repeats = h_w == watch->h_w, was_frozen = watch->frozen;
    const bool ends = !repeats && watch->run > watch->longest;
    if (repeats) {
        watch->run = watch->run < INT32_MAX ? watch->run + 1 : INT32_MAX;
        watch->l += dt * given;
    } else {
        take_momentum(dt, h_w, given, watch);
    }
    const bool watched = watch->changes == REPEATS && h_w != 0.0 && is_noisy(dt, limit, watch);
    if (watch->frozen && watch->changes == REPEATS) {
        watch->frozen = false;
    } else if (watched && watch->run / REPEATS > watch->longest) {
        watch->frozen = true;
        watch->changes = 0;
    }
    watch->blind = watch->frozen || was_frozen || (watched && (ends || watch->run > watch->longest));
}
