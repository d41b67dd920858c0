/* The sensors between the plant and its flight software: bias, white noise and sampling of what the plant puts out.
 *
 * Noise is a function of seed, number of the measurement, sensor and axis, so there is no generator's state and a
 * repeated step repeats it. SI units; frames as in ports.h. A function that returns false has noted a fault. */
#ifndef PLANT_SENSORS_H
#define PLANT_SENSORS_H

#include "fault.h"
#include "ports.h"

typedef struct {
    int64_t sample;           /* number of the last measurement */
    double since;             /* s since it was due: the time itself would gather rounding with each step */
    PlantSensorsOutputs held; /* what it found */
} PlantSensorsState;

typedef struct {
    PlantSensorsParameters p;
} PlantSensorsLaw;

bool plant_sensors_check(const PlantSensorsParameters *p, Fault *f);

void plant_sensors_prepare(const PlantSensorsParameters *p, PlantSensorsLaw *law);

/* Measurement 0 is taken. */
bool plant_sensors_start(const PlantSensorsLaw *law, const PlantSensorsInputs *u, PlantSensorsState *x, Fault *f);

/* What holds: the last measurement or, without a sample_period, one of the inputs as they stand. */
bool plant_sensors_outputs(const PlantSensorsLaw *law, const PlantSensorsState *x, const PlantSensorsInputs *u,
                           PlantSensorsOutputs *y, Fault *f);

/* From t to t + h; u is the truth at t + h. */
bool plant_sensors_step(const PlantSensorsLaw *law, PlantSensorsState *x, const PlantSensorsInputs *u, double h,
                        PlantSensorsOutputs *y, Fault *f);

#endif
