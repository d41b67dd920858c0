/* The judge outside the loop: the tracking errors [4] of the true motion, to LVLH or to a given reference.
 *
 * SI units; frames as at the ports. A function that returns false has noted a fault. */
#ifndef PLANT_JUDGE_H
#define PLANT_JUDGE_H

#include "fault.h"
#include "plant_judge_ports.h"

typedef struct {
    double t;   /* s; the reference 'rate' needs it */
    bool flown; /* a step has had an attitude */
} PlantJudgeState;

typedef struct {
    PlantJudgeParameters p;
    double R_d0[3][3]; /* projected onto SO(3) */
} PlantJudgeLaw;

bool plant_judge_check(const PlantJudgeParameters *p, Fault *f);

void plant_judge_prepare(const PlantJudgeParameters *p, PlantJudgeLaw *law);

bool plant_judge_start(const PlantJudgeLaw *law, const PlantJudgeInputs *u, PlantJudgeState *x, Fault *f);

/* The errors of the inputs as they stand. */
bool plant_judge_outputs(const PlantJudgeLaw *law, const PlantJudgeState *x, const PlantJudgeInputs *u,
                         PlantJudgeOutputs *y, Fault *f);

/* From t to t + h; u is the truth at t + h. */
bool plant_judge_step(const PlantJudgeLaw *law, PlantJudgeState *x, const PlantJudgeInputs *u, double h,
                      PlantJudgeOutputs *y, Fault *f);

#endif
