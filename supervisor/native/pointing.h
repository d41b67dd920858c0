/* The target of a pointing mode: attitude (N from desired body), rate and its derivative in desired body axes. */
#ifndef SUPERVISOR_POINTING_H
#define SUPERVISOR_POINTING_H

#include "epoch.h"
#include "reference.h"

static const double SUPERVISOR_EARTH_RATE =
    7.2921158553e-5; /* rad/s, of Greenwich mean sidereal time: N is true of date */

/* A vector in N, or a unit vector, with its first and second derivative. */
typedef struct {
    Vector p, dp, ddp;
} Moving;

/* Earth-fixed, m, of geodetic coordinates on WGS 84, rad, rad, m. */
Vector supervisor_point_on_earth(double latitude, double longitude, double height);

/* Unit vector from a satellite on its two-body orbit to an Earth-fixed point, at the angle of Greenwich. */
Moving supervisor_line_of_sight(Vector point, double angle, Vector r, Vector v, double mu);

/* Of the satellite above the horizon of a point, rad. */
double supervisor_elevation(Vector point, double latitude, double longitude, double angle, Vector r);

/* Z along a direction, X in the sense of flight and turned by `yaw` about Z: LVLH where Z is nadir. `normal`: the
 * orbit's. */
Reference supervisor_steered(Moving z, Vector normal, double yaw);

/* A body axis along a direction, by the smallest turn from an attitude. */
Reference supervisor_free(Vector axis_B, Moving to, Matrix before);

#endif
