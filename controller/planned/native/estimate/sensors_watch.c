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
