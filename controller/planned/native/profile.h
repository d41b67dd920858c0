/* How the disturbance torque varies along the orbit: what was estimated in the hold, an orbit before. Drag has the orbit's period. */
#ifndef CONTROLLER_PLANNED_PROFILE_H
#define CONTROLLER_PLANNED_PROFILE_H

#include "vector.h"

#include <stdint.h>

enum {
    PROFILE_PARTS = 64,               /* of an orbit */
    PROFILE_NODES = PROFILE_PARTS + 2 /* those of the last orbit, and of the part in which it began */
};

typedef struct {
    double period;                       /* of the orbit, s; 0: nothing was kept */
    double t;                            /* s, of the newest node */
    int32_t newest;                      /* its place; the one before it is the older by a part of the orbit */
    Vector now_B;                        /* what is estimated now, N m */
    bool known[PROFILE_NODES];           /* whether it was estimated in the hold */
    Vector disturbance_B[PROFILE_NODES]; /* N m */
} Profile;

/* Takes what is estimated at t, s, and keeps it where a node is due. After a gap it begins anew. */
void controller_planned_profile_keep(double t, double period, Vector disturbance_B, bool hold, Profile *profile);

/* By how much the disturbance differs at t from that of `now`, N m: it becomes what it was an orbit before, and what the present one
 * differs from that fades. Zero where the last orbit is not known. */
Vector controller_planned_profile_change(const Profile *profile, double now, double t);

#endif
