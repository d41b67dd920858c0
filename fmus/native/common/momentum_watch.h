/* Telemetry of a wheel's momentum that fails: what of it is used, and what stands in for it, the last momentum with what
 * the wheel gives by its commands. docs/how/planned-estimates.md, Failures. */
#ifndef COMMON_MOMENTUM_WATCH_H
#define COMMON_MOMENTUM_WATCH_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Samples of a momentum that repeat the last one, for each that did so before in turn; and that change, before it is
 * watched or used again. */
enum { MOMENTUM_REPEATS = 20 };

typedef struct {
    double h_w;           /* N m s, the last measured momentum */
    double l;             /* N m s: that, and what the wheel gave since it changed or was found to be wrong */
    int32_t run, longest; /* samples for which it has been the same to the last bit; and the longest such time before */
    int32_t changes;      /* samples in which it changed, of those that are asked for */
    double slip, square,
        product; /* N m, its last change less what the wheel gave; means of that one's square, and of its
                                   * product with the one before: (F3) */
    bool noisy;  /* it had noise before its last change */
    bool frozen; /* or wrong in another way: it is not used */
    bool blind;  /* it does not show how the momentum changed over the last sample */
} MomentumWatch;

/* Whether it has noise: its changes alternate about what the wheel gives, by more than rounding and by so much of the
 * slip's square. A wheel that is stuck or stands does not repeat then. */
static inline bool is_momentum_noisy(double dt, double limit, double share, const MomentumWatch *watch)
{
    static const double rounding = 1e-7;        /* of the momentum's limit: less is no noise */
    const double noise = -2.0 * watch->product; /* (F3) */
    return noise > share * watch->square && dt * sqrt(0.5 * noise) > rounding * limit;
}

/* A new momentum. */
static inline void take_momentum(double dt, double h_w, double given, bool noisy, MomentumWatch *watch)
{
    static const double averaged = 40.0; /* samples, over which its noise is found */
    watch->noisy = noisy;
    if (watch->run == 0 && watch->changes > 0) {
        const double slip = (h_w - watch->h_w) / dt - given;
        watch->square += (slip * slip - watch->square) / averaged;
        watch->product += (slip * watch->slip - watch->product) / averaged;
        watch->slip = slip;
    }
    const int32_t changes = watch->changes;
    watch->longest = !watch->frozen && watch->run > watch->longest ? watch->run : watch->longest;
    watch->run = 0;
    watch->changes = changes < MOMENTUM_REPEATS ? changes + 1 : changes;
    watch->l = watch->frozen && watch->changes < MOMENTUM_REPEATS ? watch->l + dt * given : h_w;
    watch->h_w = h_w;
}

/* Takes a measured momentum, N m s, of at most `limit`, that comes dt, s, after the last, while the wheel gave `given`,
 * N m, by its commands. It may not repeat where so much of the slip is noise; wrong: it is no momentum that the wheel
 * can have. */
static inline void watch_momentum(double dt, double h_w, double given, double limit, double noise, bool wrong,
                                  MomentumWatch *watch)
{
    const bool same = h_w == watch->h_w, was_frozen = watch->frozen;
    const bool ends = !same && watch->run > watch->longest;
    if (wrong) {
        watch->l += dt * given;
        watch->h_w = h_w;
        watch->run = watch->changes = 0;
        watch->frozen = watch->blind = true;
        return;
    }
    if (same) {
        const int32_t run = watch->run;
        watch->run = run < INT32_MAX ? run + 1 : INT32_MAX;
        watch->l += dt * given;
    } else {
        take_momentum(dt, h_w, given, is_momentum_noisy(dt, limit, noise, watch), watch);
    }
    const bool watched = watch->changes == MOMENTUM_REPEATS && watch->noisy && noise < INFINITY;
    if (watch->frozen && watch->changes == MOMENTUM_REPEATS) {
        watch->frozen = false;
    } else if (watched && watch->run / MOMENTUM_REPEATS > watch->longest) {
        watch->frozen = true;
        watch->changes = 0;
    }
    watch->blind = watch->frozen || was_frozen || (watched && (ends || watch->run > watch->longest));
}

#endif
