/* Watches the measured attitude, field and wheel momentum for one that is frozen, or a field that is far from any
 * model's; and what stands in then: the last attitude turned on by the measured rate, the field of the onboard model,
 * and the last momentum with what the wheel gives by its commands. */
#ifndef CONTROLLER_PLANNED_SENSORS_WATCH_H
#define CONTROLLER_PLANNED_SENSORS_WATCH_H

#include "../motion.h"

#include <stdint.h>

typedef struct {
    Matrix R; /* the last measured attitude, N from B */
    Matrix turned_R;
    Vector b_B;                  /* T, the last measured field */
    double R_repeats, b_repeats; /* s, for which each has been the same to the last bit */
    double turned;               /* rad, by the rate over that time */
    Vector residual_B;           /* T, measured field less the model's, smoothed */
    double strength;             /* T, difference of their strengths, smoothed: whatever the attitude is */
    bool attitude_frozen, field_failed;
} SensorsWatch;

typedef struct {
    double h_w;           /* N m s, the last measured momentum */
    double l;             /* N m s: that, and what the wheel gave since it changed */
    int32_t run, longest; /* samples for which it has been the same to the last bit; and the longest such time before */
    int32_t changes;      /* samples in which it changed, of those that are asked for */
    double slip, square,
        product; /* N m, its last change less what the wheel gave; means of that one's square, and of its
                                   * product with the one before: (F3) */
    bool frozen;
    bool blind; /* it does not show how the momentum changed over the last sample */
} MomentumWatch;

/* Takes an attitude that comes dt, s, after the last, with the rate that was estimated then and the one measured now,
 * without bias, rad/s; T is the satellite's time and `noise`, rad, that of the attitude. */
void controller_planned_watch_attitude(double dt, double T, double noise, Matrix R, Vector Omega_before, Vector Omega,
                                       SensorsWatch *watch);

/* Takes a field and that of the model, T, body axes; `tolerance`, T, is how far they may be apart. */
void controller_planned_watch_field(double dt, double T, double tolerance, Vector b_B, Vector model_B,
                                    SensorsWatch *watch);

/* Takes a measured momentum, N m s, of at most `limit`, that comes dt, s, after the last, while the wheel gave `given`,
 * N m, by its commands. Zero may be what is counted of a wheel that stands. */
void controller_planned_watch_momentum(double dt, double h_w, double given, double limit, MomentumWatch *watch);

#endif
