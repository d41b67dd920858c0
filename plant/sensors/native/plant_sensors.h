/* The sensors between the plant and its flight software: when each measures, what it remembers, and what it puts out.
 *
 * Noise is a function of seed, number of the measurement, sensor and axis, so there is no generator's state and a
 * repeated step repeats it. SI units; frames as at the ports. A function that returns false has noted a fault. */
#ifndef PLANT_SENSORS_H
#define PLANT_SENSORS_H

#include "fault.h"
#include "plant_sensors_ports.h"
#include "vector.h"

/* The sensors that have a period of their own; the first five count their measurements. */
enum { ATTITUDE, RATE, FIELD, ORBIT, SUN, TELEMETRY, CLOCKS, COUNTERS = TELEMETRY };

enum { SUN_SENSORS = 6 };

typedef struct {
    int64_t sample[CLOCKS];        /* number of the last measurement, lost ones included */
    double since[CLOCKS];          /* s since it was due: the time itself would gather rounding with each step */
    int32_t before[COUNTERS];      /* measurements counted before the last one */
    double rate_span;              /* s from the gyro's measurement before to its last; 0 where there is none */
    Vector rate_walk, rate_markov; /* rad/s */
    bool attitude_lost, orbit_lost;
    PlantSensorsOutputs held; /* the last measurements */
} PlantSensorsState;

/* Parameters and what follows from them alone. */
typedef struct {
    PlantSensorsParameters p;
    double periods[CLOCKS]; /* s; 0: a measurement at every step */
    bool turns_attitude, has_rate_error, has_field_error, has_drift, has_rate_scale, has_field_scale, has_rod_coupling;
    Vector boresight, fine_sun_axis, sun_axes[SUN_SENSORS]; /* unit, or zeros */
    double cos_sun_exclusion, cos_sun_sensor, cos_fine_sun;
} PlantSensorsLaw;

bool plant_sensors_check(const PlantSensorsParameters *p, Fault *f);

void plant_sensors_prepare(const PlantSensorsParameters *p, PlantSensorsLaw *law);

/* Measurement 0 of each sensor is taken. */
bool plant_sensors_start(const PlantSensorsLaw *law, const PlantSensorsInputs *u, PlantSensorsState *x, Fault *f);

/* The outputs: the last measurements or, where there is no period, those of the inputs as they stand. */
bool plant_sensors_outputs(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u,
                           PlantSensorsOutputs *y, Fault *f);

/* From t to t + h; u is the truth at t + h. */
bool plant_sensors_step(const PlantSensorsLaw *law, PlantSensorsState *x, const PlantSensorsInputs *u, double h,
                        PlantSensorsOutputs *y, Fault *f);

#endif
