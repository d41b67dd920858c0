/* The GNSS receiver: position and velocity with noise. Tests: tests/native/test_flavours.py. */
#include "models.h"

void plant_sensors_fix(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u,
                       PlantSensorsOutputs *y)
{
    Vector r = vector(u->r_N), v = vector(u->v_N);
    if (p->position_noise > 0.0) {
        r = add(r, sensor_noise((Draw){p->seed, sample, POSITION_NOISE}, p->position_noise));
    }
    if (p->velocity_noise > 0.0) {
        v = add(v, sensor_noise((Draw){p->seed, sample, VELOCITY_NOISE}, p->velocity_noise));
    }
    store(r, y->r_N_measured);
    store(v, y->v_N_measured);
}
