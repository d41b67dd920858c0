/* docs/how/planned-orbit.md, Strained hold. Tests: test_strained.py. */
#include "profile.h"

#include <string.h>

static const double PROFILE_FADES = 0.1; /* orbits, in which what differs from the last orbit fades by e */

void controller_planned_profile_keep(double t, double period, Vector disturbance_B, bool good, Profile *profile)
{
    const double part = period / (double)PROFILE_PARTS;
    const bool goes_on = profile->period > 0.0 && t < profile->t + 2.0 * part;
    if (!goes_on) {
        memset(profile, 0, sizeof *profile); /* to the last byte: it is part of a saved state */
        profile->period = period;
    }
    profile->now_B = disturbance_B;
    if (goes_on && t < profile->t + part) {
        return;
    }
    profile->t = goes_on ? profile->t + part : t;
    profile->newest = (profile->newest + 1) % PROFILE_NODES;
    profile->known[profile->newest] = good;
    profile->disturbance_B[profile->newest] = disturbance_B;
}

/* What was estimated at a time of the last orbit; whether it is known. */
static bool estimated(const Profile *profile, double t, Vector *disturbance_B)
{
    const double parts = (profile->t - t) * (double)PROFILE_PARTS / profile->period; /* before the newest node */
    if (!(parts >= 0.0 && parts < (double)(PROFILE_NODES - 1))) {
        return false;
    }
    const int back = whole_part(parts, PROFILE_NODES - 2), place = profile->newest + PROFILE_NODES - back;
    const int after = place % PROFILE_NODES, before = (place - 1) % PROFILE_NODES;
    const Vector from = profile->disturbance_B[after], to = profile->disturbance_B[before];
    *disturbance_B = add(from, scale(parts - back, subtract(to, from)));
    return profile->known[after] && profile->known[before];
}

Vector controller_planned_profile_change(const Profile *profile, double now, double t)
{
    const double period = profile->period;
    Vector before = {0.0, 0.0, 0.0}, then = before;
    if (!(period > 0.0 && estimated(profile, now - period, &before) && estimated(profile, t - period, &then))) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const double share = exp(-larger(t - now, 0.0) / (PROFILE_FADES * period));
    return add(subtract(then, profile->now_B), scale(share, subtract(profile->now_B, before)));
}
