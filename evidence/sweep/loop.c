/* The loop of plant, sensors, planned controller and bounded allocator by the blocks' own C, without FMUs between them. It is that
 * of scenarios/flight_failures.yaml, but that the plant too has the step of the others. The judge sees the plant's truth. */
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

/* The same structures stand in loop.py. */
enum { FROZEN_ATTITUDE = 1, FROZEN_FIELD = 2, ALARMS = 7 };

typedef struct {
    double step, until, quiet; /* s; how long it stays settled before it counts, or is ended where no hold is judged */
    double angle, rate;        /* rad, rad/s: settled below both */
    double hold;               /* s, from when the hold is judged */
    double fails;              /* s, from when the failed parameters hold, and measurements are frozen */
    int32_t frozen;            /* of FROZEN_ATTITUDE and FROZEN_FIELD */
} Course;

typedef struct {
    double settled;      /* s, since when; or infinite */
    double rms, largest; /* rad, attitude error in the hold */
    double told[ALARMS]; /* s, first time: rod 1, 2, 3 failed, wheel failed, wheel given up, attitude frozen, field failed */
} Flown;

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

/* The blocks behind the plant, at the start or h later; of the measurements some are frozen. */
static bool behind_plant(const Wires *u, double h, bool first, int32_t frozen, Fault *f)
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
    if (!(frozen & FROZEN_ATTITUDE)) {
        COPY(u->controller->R_NB, measured->R_NB_measured);
    }
    if (!(frozen & FROZEN_FIELD)) {
        COPY(u->controller->b_B, measured->b_B_measured);
    }
    COPY(u->controller->omega_B, measured->omega_B_measured);
    COPY(u->controller->r_N, measured->r_N_measured), COPY(u->controller->v_N, measured->v_N_measured);
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
    COPY(u->allocator->b_B, out.controller.b_used_B), COPY(u->allocator->omega_B, measured->omega_B_measured);
    u->allocator->wheel_torque_ff = out.controller.wheel_torque_ff;
    u->allocator->h_w = measured->h_w_measured;
    return first ? allocator_bounded_start(&law.allocator, u->allocator, &state.allocator, f) &&
                       allocator_bounded_outputs(&law.allocator, &state.allocator, u->allocator, &out.allocator, f)
                 : allocator_bounded_step(&law.allocator, &state.allocator, u->allocator, h, &out.allocator, f);
}

/* The first time of each alarm. */
static void listen(double t, Flown *flown)
{
    const ControllerPlannedOutputs *y = &out.controller;
    const bool alarm[ALARMS] = {y->failed_rod == 1,          y->failed_rod == 2, y->failed_rod == 3, y->wheel_failed,
                                state.controller.rods_alone, y->attitude_frozen, y->field_failed};
    for (int i = 0; i < ALARMS; ++i) {
        flown->told[i] = alarm[i] ? smaller(flown->told[i], t) : flown->told[i];
    }
}

/* Flies until the course's end, or until it has been settled for long where no hold is judged. Returns the name of what a block
 * refuses, or NULL. */
__attribute__((visibility("default"))) const char *sweep_fly(const Given *p, const Given *failed, const Wires *u,
                                                             const Course *course, Flown *flown);
const char *sweep_fly(const Given *p, const Given *failed, const Wires *u, const Course *course, Flown *flown)
{
    static Fault f;
    const double h = course->step;
    double squares = 0.0, judged = 0.0;
    int32_t frozen = 0;
    bool fails = false;
    memset(&out, 0, sizeof out);
    *flown = (Flown){.settled = INFINITY};
    for (int i = 0; i < ALARMS; ++i) {
        flown->told[i] = INFINITY;
    }
    if (prepare(p, &f) != NULL || !plant_start(&law.plant, u->plant, &state.plant, &f) ||
        !plant_outputs(&law.plant, &state.plant, u->plant, &out.plant, &f) || !behind_plant(u, h, true, 0, &f)) {
        return f.name;
    }
    double t = 0.0;
    for (int i = 1; i * h <= course->until; ++i) {
        if (!fails && t >= course->fails) {
            fails = true;
            frozen = course->frozen;
            if (prepare(failed, &f) != NULL) {
                return f.name;
            }
        }
        t = i * h;
        COPY(u->plant->dipole_cmd, out.allocator.dipole_cmd);
        u->plant->wheel_torque_cmd = out.allocator.wheel_torque_cmd;
        if (!plant_step(&law.plant, &state.plant, u->plant, h, &out.plant, &f) || !behind_plant(u, h, false, frozen, &f)) {
            return f.name;
        }
        listen(t, flown);
        const double *e = out.judge.rate_error_B, angle = out.judge.attitude_error;
        if (t >= course->hold) {
            squares += angle * angle;
            judged += 1.0;
            flown->largest = larger(flown->largest, angle);
        }
        if (!(angle < course->angle && e[0] * e[0] + e[1] * e[1] + e[2] * e[2] < course->rate * course->rate)) {
            flown->settled = INFINITY;
        } else {
            flown->settled = smaller(flown->settled, t);
        }
        if (t - flown->settled >= course->quiet && course->hold > course->until) {
            break;
        }
    }
    if (!(t - flown->settled >= course->quiet)) {
        flown->settled = INFINITY;
    }
    flown->rms = sqrt(squares / judged); /* NaN where no hold is judged */
    return NULL;
}
