/* The block's functions by structures with doubles. This side alone knows the
 * block's own, with floats. */
#include "inner.h"

#include "conversion.h"

#include <string.h>

static void narrow_one(const unsigned char *from, unsigned char *to, size_t k)
{
    double x;
    memcpy(&x, from + k * sizeof x, sizeof x);
    const float y = (float)x;
    memcpy(to + k * sizeof y, &y, sizeof y);
}

static void widen_one(const unsigned char *from, unsigned char *to, size_t k)
{
    float x;
    memcpy(&x, from + k * sizeof x, sizeof x);
    const double y = (double)x;
    memcpy(to + k * sizeof y, &y, sizeof y);
}

/* n variables from one structure to the other; what is no number has the same bytes in both. */
static void convert(const void *from, const Field *there, void *to, const Field *here, size_t n, bool narrows)
{
    for (size_t i = 0; i < n; ++i) {
        const unsigned char *source = (const unsigned char *)from + there[i].offset;
        unsigned char *target = (unsigned char *)to + here[i].offset;
        for (size_t k = 0; here[i].kind == FIELD_REAL && k < here[i].count; ++k) {
            if (narrows) {
                narrow_one(source, target, k);
            } else {
                widen_one(source, target, k);
            }
        }
        if (here[i].kind != FIELD_REAL) {
            memcpy(target, source, here[i].count);
        }
    }
}

static bool told(bool done, const Fault *f, Refusal *r)
{
    if (!done) {
        *r = (Refusal){f->name, f->expected, f->text, (double)f->value};
    }
    return done;
}

static Fault none(void)
{
    Fault f;
    memset(&f, 0, sizeof f);
    f.name = f.expected = "";
    return f;
}

static Parameters parameters(const void *p)
{
    Parameters own;
    memset(&own, 0, sizeof own);
    convert(p, wide_parameters, &own, own_parameters, PARAMETERS, true);
    return own;
}

static Inputs inputs(const void *u)
{
    Inputs own;
    memset(&own, 0, sizeof own);
    convert(u, wide_inputs, &own, own_inputs, INPUTS, true);
    return own;
}

/* The block's own state, with the time of x, rounded once: a time to which steps are added in single precision is a
 * second off within the hour. */
static State *state_at(void *x, double time)
{
    State *own = (State *)(void *)((unsigned char *)x + sizeof time);
    memcpy(x, &time, sizeof time);
    SET_TIME(own, (float)time);
    return own;
}

static double time_of(const void *x)
{
    double time;
    memcpy(&time, x, sizeof time);
    return time;
}

bool single_check(const void *p, Refusal *r)
{
    const Parameters own = parameters(p);
    Fault f = none();
    return told(block_check(&own, &f), &f, r);
}

void single_prepare(const void *p, void *law)
{
    const Parameters own = parameters(p);
    block_prepare(&own, law);
}

bool single_start(void *law, const void *u, void *x, Refusal *r)
{
    const Inputs own = inputs(u);
    Fault f = none();
    return told(block_start(law, &own, state_at(x, 0.0), &f), &f, r);
}

bool single_outputs(void *law, const void *x, const void *u, void *y, Refusal *r)
{
    const Inputs own = inputs(u);
    Outputs given;
    Fault f = none();
    memset(&given, 0, sizeof given);
    const void *own_state = (const unsigned char *)x + sizeof(double);
    if (!told(block_outputs(law, own_state, &own, &given, &f), &f, r)) {
        return false;
    }
    convert(&given, own_outputs, y, wide_outputs, OUTPUTS, false);
    return true;
}

bool single_step(void *law, void *x, const void *u, double h, void *y, Refusal *r)
{
    const Inputs own = inputs(u);
    Outputs given;
    Fault f = none();
    memset(&given, 0, sizeof given);
    const double time = time_of(x);
    if (!told(block_step(law, state_at(x, time), &own, (float)h, &given, &f), &f, r)) {
        return false;
    }
    (void)state_at(x, time + h);
    convert(&given, own_outputs, y, wide_outputs, OUTPUTS, false);
    return true;
}
