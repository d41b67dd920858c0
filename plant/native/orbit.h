/* The orbit: Keplerian, circular or from a given r and v, its node drifting with J2 on request.
 * N is true of date: its Z axis is the Earth's, and the Earth is turned in it by GMST. */
#ifndef PLANT_ORBIT_H
#define PLANT_ORBIT_H

#include "vector.h"

#define WGS84_RADIUS 6378137.0                 /* m */
#define WGS84_FLATTENING (1.0 / 298.257223563) /* */

typedef struct {
    double semi_major_axis; /* m */
    double eccentricity;
    double mean_motion;     /* rad/s */
    double mean_anomaly;    /* at t = 0, rad, from towards_perigee */
    Vector towards_perigee; /* unit, N, at t = 0 */
    Vector along_perigee;   /* unit, N, at t = 0 */
    double node_rate;       /* of the plane about N's Z axis, rad/s */
} Orbit;

typedef struct {
    Vector r, v; /* m, m/s, N */
} OrbitState;

Orbit plant_circular_orbit(double radius, double inclination, double raan, double argument_of_latitude, double mu);

/* False where r and v are parallel or zero. */
bool plant_orbit_through(Vector r, Vector v, double mu, Orbit *orbit);

/* Secular drift of the node by J2: -3/2 n J2 (R_E/p)^2 cos i (Vallado, 4th ed., 9-37). */
double plant_j2_node_rate(const Orbit *orbit, double mu);

/* v is the derivative of r, the node's drift included. */
OrbitState plant_motion_at(const Orbit *orbit, double t);

/* x turned by an angle about Z. */
Vector plant_turned(double angle, Vector x);

typedef struct {
    double latitude, longitude, height; /* rad, rad, m; geodetic on WGS 84 */
} Place;

Place plant_geodetic(Vector r_earth);

#endif
