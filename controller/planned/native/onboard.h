/* What the controller knows of orbit, target and field ahead of it: models of its own, so that they may be wrong. */
#ifndef CONTROLLER_PLANNED_ONBOARD_H
#define CONTROLLER_PLANNED_ONBOARD_H

#include "onboard_field.h"
#include "rotation.h"
#include "two_body.h"

/* The target: none, one that the parameter `reference` names (1 and 2 are its values), or a given one, which keeps its
 * attitude to LVLH, too, or its body rate. */
enum { ONBOARD_TARGET_NONE = 0, ONBOARD_TARGET_LVLH = 1, ONBOARD_TARGET_INERTIAL = 2, ONBOARD_TARGET_TURNING = 3 };

/* The desired motion: attitude (N from desired body), rate in desired body axes. */
typedef struct {
    Matrix R;
    Vector Omega;
} Target;

/* LVLH of a position and a velocity: Z to nadir, Y against the orbit's normal. */
Target controller_planned_lvlh(Vector r_N, Vector v_N);

#endif
