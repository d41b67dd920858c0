/* Drivers of three magnetorquers and a reaction wheel, as a hardware team might write them. */
#ifndef ACTUATORS_H
#define ACTUATORS_H

#include "fault.h"
#include "actuators_ports.h"

typedef struct {
    double t; /* s */
} ActuatorsState;

typedef struct {
    ActuatorsParameters p;
} ActuatorsLaw;

bool actuators_check(const ActuatorsParameters *p, Fault *f);
void actuators_prepare(const ActuatorsParameters *p, ActuatorsLaw *law);
bool actuators_start(const ActuatorsLaw *law, const ActuatorsInputs *u, ActuatorsState *x, Fault *f);
bool actuators_outputs(const ActuatorsLaw *law, const ActuatorsState *x, const ActuatorsInputs *u, ActuatorsOutputs *y,
                       Fault *f);
bool actuators_step(const ActuatorsLaw *law, ActuatorsState *x, const ActuatorsInputs *u, double h, ActuatorsOutputs *y,
                    Fault *f);

#endif
