/* The block's functions as shell and link call them, with doubles. */
#include "block.h"

static bool told(bool done, const Refusal *r, Fault *f)
{
    if (!done) {
        *f = (Fault){r->name, r->expected, r->text, r->value};
    }
    return done;
}

bool outer_check(const Parameters *p, Fault *f)
{
    Refusal r = {"", "", NULL, 0.0};
    return told(single_check(p, &r), &r, f);
}

void outer_prepare(const Parameters *p, Law *law)
{
    single_prepare(p, law);
}

bool outer_start(Law *law, const Inputs *u, State *x, Fault *f)
{
    Refusal r = {"", "", NULL, 0.0};
    return told(single_start(law, u, x, &r), &r, f);
}

bool outer_outputs(Law *law, const State *x, const Inputs *u, Outputs *y, Fault *f)
{
    Refusal r = {"", "", NULL, 0.0};
    return told(single_outputs(law, x, u, y, &r), &r, f);
}

bool outer_step(Law *law, State *x, const Inputs *u, double h, Outputs *y, Fault *f)
{
    Refusal r = {"", "", NULL, 0.0};
    return told(single_step(law, x, u, h, y, &r), &r, f);
}
