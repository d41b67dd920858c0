/* Moment of sunlight on the body. Not in the paper. */
#ifndef PLANT_SOLAR_PRESSURE_H
#define PLANT_SOLAR_PRESSURE_H

#include "plant.h"

/* About the centre of mass, N m, body axes, at attitude R and time t. */
Vector plant_solar_pressure(PlantLaw *plant, const Matrix *R, double t);

#endif
