/* Watches the innovations r of the rate for a rod that fails: dead, weak or reversed. M = sum E'E/S and z = sum E'r/S
 * with the effects E of the rods; z'(M + I)^-1 z says how far the gains are from those that the filter has. */
#ifndef CONTROLLER_PLANNED_RODS_WATCH_H
#define CONTROLLER_PLANNED_RODS_WATCH_H

#include "../motion.h"

typedef struct {
    Vector effect[3]; /* rad/s, of each rod at gain 1 on the rate over the last sample */
    Matrix M;
    Vector z;
    double rate;   /* rad/s, of the satellite in the middle of it */
    bool wide;     /* gains are sought beyond those of sound rods */
    double paused; /* s, for which nothing is watched, since the filter has begun anew */
    double pause;  /* s, the next of these; each is twice as long as the last, up to a largest */
} RodsWatch;

/* Takes the innovation of the rate, rad/s, with its variance S, rad2/s2, after a sample of dt, s; T is the
 * satellite's time. Whether noise alone would not give it. */
bool controller_planned_watch_rods(double dt, double T, Vector rate, double S, RodsWatch *watch);

/* Begins anew, with nothing watched for the next pause. */
void controller_planned_pause_watch(double T, RodsWatch *watch);

#endif
