/* The GNSS receiver: position and velocity with noise. */
#include "models.h"

void plant_sensors_fix(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u, PlantSensorsOutputs *y)
{
    const Draw position = {p->seed, sample, POSITION_NOISE}, velocity = {p->seed, sample, VELOCITY_NOISE};
    store(add(vector(u->r_N), plant_sensors_noise(position, p->position_noise)), y->r_N_measured);
    store(add(vector(u->v_N), plant_sensors_noise(velocity, p->velocity_noise)), y->v_N_measured);
}
