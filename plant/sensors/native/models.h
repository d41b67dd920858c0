/* The models of the sensors: what each reads in the truth u, with the errors of its measurement number `sample`. */
#ifndef PLANT_SENSORS_MODELS_H
#define PLANT_SENSORS_MODELS_H

#include "noise.h"
#include "plant_sensors.h"

static const double PLANT_SENSORS_EARTH_RADIUS = 6378137.0; /* equatorial, of WGS 84, m */

static inline double plant_sensors_sunlight(const PlantSensorsInputs *u)
{
    return plant_sensors_has_sunlight(u) ? u->sunlight : 1.0;
}

/* Gyro: the rate random walk, and the exponentially correlated noise, span s later. */
Vector plant_sensors_walked(const PlantSensorsParameters *p, Vector walk, int64_t sample, double span);
Vector plant_sensors_correlated(const PlantSensorsParameters *p, Vector markov, int64_t sample, double span);

/* rad/s. */
Vector plant_sensors_rate(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u);

/* T. */
Vector plant_sensors_field(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u);

/* Whether rate, Sun and Earth leave the star tracker an attitude. The Sun does not blind it from behind the Earth. */
bool plant_sensors_sees_stars(const PlantSensorsLaw *law, const PlantSensorsInputs *u);
Matrix plant_sensors_attitude(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u);

/* The signals of the coarse sun sensors and the unit vector to the Sun, zeros where there is none: then false. */
bool plant_sensors_sun(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u, PlantSensorsOutputs *y);

void plant_sensors_fix(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u,
                       PlantSensorsOutputs *y);

void plant_sensors_telemetry(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u,
                             PlantSensorsOutputs *y);

/* Whether a signal is lost `span` s after it `was`: a Markov process of two states in continuous time (Gilbert,
 * 1960) that is found for `interval` and lost for `duration` s in the mean. */
bool plant_sensors_lost(bool was, double interval, double duration, double span, Draw draw);

#endif
