/* The loop of plant, sensors, planned controller and bounded allocator by the blocks' own C, without FMUs between them. It is that
 * of scenarios/flight_tumble.yaml, but that the plant too has the step of the others. The judge sees the plant's truth. */
#include <string.h>

#include "allocator_bounded.h"
#include "controller_planned.h"
#include "plant.h"
#include "plant_judge.h"
#include "plant_sensors.h"

#define COPY(to, from) memcpy(to, from, sizeof(to))

typedef struct {
    PlantParameters *plant;
    PlantSensorsParameters *sensors;
    ControllerPlannedParameters *controller;
    AllocatorBoundedParameters *allocator;
    PlantJudgeParameters *judge;
} Given;

typedef struct {
    PlantInputs *plant;
    PlantSensorsInputs *sensors;
    ControllerPlannedInputs *controller;
    AllocatorBoundedInputs *allocator;
    PlantJudgeInputs *judge;
} Wires;

static struct {
    PlantLaw plant;
    PlantSensorsLaw sensors;
    ControllerPlannedLaw controller;
    AllocatorBoundedLaw allocator;
    PlantJudgeLaw judge;
} law;

static struct {
    PlantState plant;
    PlantSensorsState sensors;
    ControllerPlannedState controller;
    AllocatorBoundedState allocator;
    PlantJudgeState judge;
} state;

static struct {
    PlantOutputs plant;
    PlantSensorsOutputs sensors;
    ControllerPlannedOutputs controller;
    AllocatorBoundedOutputs allocator;
    PlantJudgeOutputs judge;
} out;

/* What is wrong with the parameters, or NULL. */
static const char *prepare(const Given *p, Fault *f)
{
    if (!plant_check(p->plant, f) || !plant_sensors_check(p->sensors, f) || !controller_planned_check(p->controller, f) ||
        !allocator_bounded_check(p->allocator, f) || !plant_judge_check(p->judge, f)) {
        return f->name;
    }
    plant_prepare(p->plant, &law.plant);
    plant_sensors_prepare(p->sensors, &law.sensors);
    controller_planned_prepare(p->controller, &law.controller);
    allocator_bounded_prepare(p->allocator, &law.allocator);
    plant_judge_prepare(p->judge, &law.judge);
    return NULL;
}

/* The blocks behind the plant, at the start or h later. */
static bool behind_plant(const Wires *u, double h, bool first, Fault *f)
{
    const PlantOutputs *truth = &out.plant;
    COPY(u->judge->R_NB, truth->R_NB), COPY(u->judge->omega_B, truth->omega_B);
    COPY(u->judge->r_N, truth->r_N), COPY(u->judge->v_N, truth->v_N);
    COPY(u->sensors->R_NB, truth->R_NB), COPY(u->sensors->omega_B, truth->omega_B);
    COPY(u->sensors->r_N, truth->r_N), COPY(u->sensors->v_N, truth->v_N);
    COPY(u->sensors->b_B, truth->b_B);
    u->sensors->h_w = truth->h_w;
    if (first ? !plant_judge_start(&law.judge, u->judge, &state.judge, f) ||
                    !plant_judge_outputs(&law.judge, &state.judge, u->judge, &out.judge, f) ||
                    !plant_sensors_start(&law.sensors, u->sensors, &state.sensors, f) ||
                    !plant_sensors_outputs(&law.sensors, &state.sensors, u->sensors, &out.sensors, f)
              : !plant_judge_step(&law.judge, &state.judge, u->judge, h, &out.judge, f) ||
                    !plant_sensors_step(&law.sensors, &state.sensors, u->sensors, h, &out.sensors, f)) {
        return false;
    }
    const PlantSensorsOutputs *measured = &out.sensors;
    COPY(u->controller->R_NB, measured->R_NB_measured), COPY(u->controller->omega_B, measured->omega_B_measured);
    COPY(u->controller->r_N, measured->r_N_measured), COPY(u->controller->v_N, measured->v_N_measured);
    COPY(u->controller->b_B, measured->b_B_measured);
    u->controller->h_w = measured->h_w_measured;
    memcpy(u->controller->u_applied, out.allocator.dipole_cmd, sizeof out.allocator.dipole_cmd);
    u->controller->u_applied[3] = out.allocator.wheel_torque_cmd;
    if (first ? !controller_planned_start(&law.controller, u->controller, &state.controller, f) ||
                    !controller_planned_outputs(&law.controller, &state.controller, u->controller, &out.controller, f)
              : !controller_planned_step(&law.controller, &state.controller, u->controller, h, &out.controller, f)) {
        return false;
    }
    COPY(u->allocator->tau_cmd_B, out.controller.tau_cmd_B), COPY(u->allocator->dipole_ff, out.controller.dipole_ff);
    COPY(u->allocator->rod_gains, out.controller.rod_gains_estimate);
    COPY(u->allocator->b_B, measured->b_B_measured), COPY(u->allocator->omega_B, measured->omega_B_measured);
    u->allocator->wheel_torque_ff = out.controller.wheel_torque_ff;
    u->allocator->h_w = measured->h_w_measured;
    return first ? allocator_bounded_start(&law.allocator, u->allocator, &state.allocator, f) &&
                       allocator_bounded_outputs(&law.allocator, &state.allocator, u->allocator, &out.allocator, f)
                 : allocator_bounded_step(&law.allocator, &state.allocator, u->allocator, h, &out.allocator, f);
}

/* Flies in steps of h until the angle is below `angle` and the rate error below `rate` for `quiet`, or until `until`, all s, rad
 * and rad/s. `settled`: since when they are, or infinite. Returns the name of what a block refuses, or NULL. */
__attribute__((visibility("default"))) const char *sweep_fly(const Given *p, const Wires *u, double h, double until,
                                                             double quiet, double angle, double rate, double *settled);
const char *sweep_fly(const Given *p, const Wires *u, double h, double until, double quiet, double angle, double rate,
                      double *settled)
{
    static Fault f;
    memset(&out, 0, sizeof out);
    *settled = INFINITY;
    if (prepare(p, &f) != NULL || !plant_start(&law.plant, u->plant, &state.plant, &f) ||
        !plant_outputs(&law.plant, &state.plant, u->plant, &out.plant, &f) || !behind_plant(u, h, true, &f)) {
        return f.name;
    }
    for (int i = 1; i * h <= until; ++i) {
        COPY(u->plant->dipole_cmd, out.allocator.dipole_cmd);
        u->plant->wheel_torque_cmd = out.allocator.wheel_torque_cmd;
        if (!plant_step(&law.plant, &state.plant, u->plant, h, &out.plant, &f) || !behind_plant(u, h, false, &f)) {
            return f.name;
        }
        const double *e = out.judge.rate_error_B;
        if (!(out.judge.attitude_error < angle && e[0] * e[0] + e[1] * e[1] + e[2] * e[2] < rate * rate)) {
            *settled = INFINITY;
        } else if (*settled > i * h) {
            *settled = i * h;
        } else if (i * h - *settled >= quiet) {
            return NULL;
        }
    }
    *settled = INFINITY;
    return NULL;
}
