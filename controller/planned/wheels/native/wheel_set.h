/* What a set of wheels can give: the torques and momenta of wheels within their limits fill a zonotope, the sum of
 * their segments, whose facets are normal to the axes of two wheels each: docs/how/planned-wheels.md, (1) to (3). */
#ifndef CONTROLLER_PLANNED_WHEELS_WHEEL_SET_H
#define CONTROLLER_PLANNED_WHEELS_WHEEL_SET_H

#include "wheels.h"

enum { FACETS_MAX = 6 }; /* pairs of WHEELS_MAX axes */

static const double WHEEL_SET_FLAT = 1e-6; /* of the sum of the limits: a zonotope that is thinner has no volume */

typedef struct {
    int facets;
    Vector normal[FACETS_MAX];   /* unit; each stands for the opposite facet, too */
    double distance[FACETS_MAX]; /* of the facet from the origin: (1) */
    double inradius;             /* of the largest ball round the origin; 0 where the axes are in a plane: (2) */
} Zonotope;

/* Of the sums of x_i axes_i with |x_i| <= limits_i: (1). */
static inline Zonotope zonotope_of(int n, const Vector axes[], const double limits[])
{
    Zonotope z = {0};
    double sum = 0.0, least = INFINITY;
    for (int i = 0; i < n; ++i) {
        sum += limits[i];
        for (int j = i + 1; j < n; ++j) {
            const Vector across = cross(axes[i], axes[j]);
            const double size = norm(across);
            if (!(limits[i] > 0.0 && limits[j] > 0.0 && size > WHEEL_SET_FLAT)) {
                continue;
            }
            const Vector normal = scale(1.0 / size, across);
            double distance = 0.0;
            for (int k = 0; k < n; ++k) {
                distance += limits[k] * fabs(dot(normal, axes[k]));
            }
            z.normal[z.facets] = normal;
            z.distance[z.facets] = distance;
            z.facets += 1;
            least = smaller(least, distance);
        }
    }
    z.inradius = z.facets > 0 && least > WHEEL_SET_FLAT * sum ? least : 0.0;
    return z;
}

/* The largest factor with which `along` beside the vector `base` lies in the `share` of the zonotope. */
static inline double zonotope_beside(const Zonotope *z, double share, Vector base, Vector along)
{
    double reach = INFINITY;
    for (int k = 0; k < z->facets; ++k) {
        const double part = dot(z->normal[k], along), there = dot(z->normal[k], base);
        if (fabs(part) > 0.0) {
            reach = smaller(reach, (share * z->distance[k] - (part > 0.0 ? there : -there)) / fabs(part));
        }
    }
    return reach;
}

/* The largest factor with which `along` beside any vector of length `ball` lies in the zonotope, negative where the
 * ball alone does not: (3). */
static inline double zonotope_reach(const Zonotope *z, double ball, Vector along)
{
    double reach = INFINITY;
    for (int k = 0; k < z->facets; ++k) {
        const double part = fabs(dot(z->normal[k], along));
        if (part > 0.0) {
            reach = smaller(reach, (z->distance[k] - ball) / part);
        }
    }
    return reach;
}

#endif
