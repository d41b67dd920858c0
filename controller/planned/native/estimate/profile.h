/* How the disturbance torque varies along the orbit: what was estimated an orbit before, body axes. Drag has the
 * orbit's period. */
#ifndef CONTROLLER_PLANNED_PROFILE_H
#define CONTROLLER_PLANNED_PROFILE_H

#include "vector.h"

#include <stdint.h>

enum {
    PROFILE_PARTS = 64,               /* of an orbit */
    PROFILE_NODES = PROFILE_PARTS + 2 /* those round each time of the last orbit, and one for rounding */
};

typedef struct {
    double period;                       /* of the orbit, s; 0: nothing was kept */
    double t;                            /* s, of the newest node */
    int32_t newest;                      /* its place; the one before it is the older by a part of the orbit */
    Vector now_B;                        /* what is estimated now, N m */
    bool known[PROFILE_NODES];           /* whether its estimate was good */
    Vector disturbance_B[PROFILE_NODES]; /* N m */
} Profile;

/* Takes what is estimated at t, s, and keeps it where a node is due. After a gap of two parts it begins anew. */
void controller_planned_profile_keep(double t, double period, Vector disturbance_B, bool good, Profile *profile);

/* By how much the disturbance differs at t from that of `now`, N m: the change is that of an orbit before, and the
 * present difference from that orbit fades. Zero where the last orbit is not known, and later than an orbit after
 * the newest node. */
Vector controller_planned_profile_change(const Profile *profile, double now, double t);

#endif
