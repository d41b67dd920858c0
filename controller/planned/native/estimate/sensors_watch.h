/* Watches the measured attitude and field for one that is frozen, or a field that is far from any model's; and what
 * stands in then: the last attitude turned on by the measured rate, and the field of the onboard model. */
#ifndef CONTROLLER_PLANNED_SENSORS_WATCH_H
#define CONTROLLER_PLANNED_SENSORS_WATCH_H

#include "../motion.h"

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

/* Takes an attitude that comes dt, s, after the last, with the rate that was estimated then and the one measured now,
 * without bias, rad/s; T is the satellite's time and `noise`, rad, that of the attitude. */
void controller_planned_watch_attitude(double dt, double T, double noise, Matrix R, Vector Omega_before, Vector Omega,
                                       SensorsWatch *watch);

/* Takes a field and that of the model, T, body axes; `tolerance`, T, is how far they may be apart. */
void controller_planned_watch_field(double dt, double T, double tolerance, Vector b_B, Vector model_B,
                                    SensorsWatch *watch);

#endif
