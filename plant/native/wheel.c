#include "wheel.h"

#include <math.h>

#include "vector.h"

/* (1 - exp(-x))/x. */
static double phi1(double x)
{
    return x != 0.0 ? -expm1(-x) / x : 1.0;
}

/* (x - 1 + exp(-x))/x^2; a series where that cancels. */
static double phi2(double x)
{
    if (fabs(x) < 0.05) {
        return 0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0)))));
    }
    return (x + expm1(-x)) / (x * x);
}

double plant_segment_momentum(const Segment *part, double s)
{
    if (part->decay == 0.0) {
        return part->l_start + part->drive * s;
    }
    return part->l_start + (part->drive - part->decay * part->l_start) * s * phi1(part->decay * s);
}

double plant_segment_mean(const Segment *part, double s, double duration)
{
    if (part->decay == 0.0) {
        return part->l_start + part->drive * (s + 0.5 * duration);
    }
    /* The rate at s from that at the start: drive - decay * l_w(s) would cancel where friction is strong. */
    const double rate = (part->drive - part->decay * part->l_start) * exp(-part->decay * s);
    return plant_segment_momentum(part, s) + rate * duration * phi2(part->decay * duration);
}

/* `drive` on this side of standstill. */
static double drive_of(const Wheel *wheel, double momentum, double command)
{
    const double torque = wheel->gain * clip(command, -wheel->torque_max, wheel->torque_max);
    if (wheel->breakaway == 0.0) {
        return torque;
    }
    if (momentum == 0.0) {
        return copysign(fabs(torque) > wheel->breakaway ? fabs(torque) - wheel->coulomb : 0.0, torque);
    }
    return torque - copysign(wheel->coulomb, momentum);
}

static bool is_at_limit(const Wheel *wheel, double momentum, double rate)
{
    return fabs(momentum) >= wheel->momentum_max && rate * momentum >= 0.0;
}

double plant_wheel_net_torque(const Wheel *wheel, double momentum, double command, bool *at_limit)
{
    const double rate = drive_of(wheel, momentum, command) - wheel->decay * momentum;
    const bool stopped = is_at_limit(wheel, momentum, rate);
    *at_limit = stopped && rate != 0.0;
    return stopped ? 0.0 : rate;
}

/* When l_w reaches `target`; infinite where friction stops it before. */
static double time_to(double target, double momentum, double rate, double decay)
{
    const double share = (target - momentum) / rate;
    if (decay == 0.0) {
        return share;
    }
    return decay * share < 1.0 ? -log1p(-decay * share) / decay : INFINITY;
}

/* From `now` until the law changes, or for `h` s; l_end is the momentum then. */
static Segment first_segment(const Wheel *wheel, double now, double command, double h)
{
    const double drive = drive_of(wheel, now, command), decay = wheel->decay;
    const double rate = drive - decay * now;
    if (rate == 0.0 || is_at_limit(wheel, now, rate)) {
        return (Segment){h, now, now, 0.0, 0.0};
    }
    const bool to_standstill = wheel->breakaway > 0.0 && now * rate < 0.0;
    const double target = to_standstill ? 0.0 : copysign(wheel->momentum_max, rate);
    const double until = time_to(target, now, rate, decay);
    if (until < h) {
        return (Segment){until, now, target, drive, decay};
    }
    Segment whole = {h, now, 0.0, drive, decay};
    whole.l_end = plant_segment_momentum(&whole, h);
    return whole;
}

double plant_wheels_part(const Wheel wheels[PLANT_WHEELS], const double momentum[PLANT_WHEELS],
                         const double command[PLANT_WHEELS], double h, Segment parts[PLANT_WHEELS])
{
    double duration = h;
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        parts[i] = first_segment(&wheels[i], momentum[i], command[i], h);
        duration = smaller(duration, parts[i].duration);
    }
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        if (parts[i].duration > duration) {
            parts[i].duration = duration;
            parts[i].l_end = plant_segment_momentum(&parts[i], duration);
        }
    }
    return duration;
}
