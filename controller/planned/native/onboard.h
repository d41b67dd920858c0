/* What the controller knows of orbit, target and field ahead of it: models of its own, so that they may be wrong. */
#ifndef CONTROLLER_PLANNED_ONBOARD_H
#define CONTROLLER_PLANNED_ONBOARD_H

#include "onboard_field.h"
#include "rotation.h"

/* The target: none, one that the parameter `reference` names (1 and 2 are its values), or a given one, which keeps its
 * attitude to LVLH or its body rate. */
enum {
    ONBOARD_TARGET_NONE = 0,
    ONBOARD_TARGET_LVLH = 1,
    ONBOARD_TARGET_INERTIAL = 2,
    ONBOARD_TARGET_WITH_LVLH = 3,
    ONBOARD_TARGET_TURNING = 4
};

/* A two-body orbit through a position and a velocity at a time. */
typedef struct {
    double t, mu;
    Vector r, v;
} OnboardOrbit;

/* The desired motion: attitude (N from desired body), rate in desired body axes. */
typedef struct {
    Matrix R;
    Vector Omega;
} Target;

/* Position and velocity at t. */
void controller_planned_onboard_orbit_at(const OnboardOrbit *orbit, double t, Vector *r_N, Vector *v_N);

/* LVLH of a position and a velocity: Z to nadir, Y against the orbit's normal. */
Target controller_planned_lvlh(Vector r_N, Vector v_N);

#endif
