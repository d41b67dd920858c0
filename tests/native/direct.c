/* A block as flight software calls it, with no FMI shell before it that refuses values. Each function returns the
 * name of the variable that is refused, or NULL. */
#include "instance.h"

#if defined _WIN32
#define DIRECT __declspec(dllexport)
#else
#define DIRECT __attribute__((visibility("default")))
#endif

DIRECT const char *direct_check(const Parameters *p);
DIRECT const char *direct_start(const Parameters *p, const Inputs *u);
DIRECT const char *direct_outputs(const Inputs *u, Outputs *y);
DIRECT const char *direct_step(const Inputs *u, double h, Outputs *y);

static Law law;
static State state;

const char *direct_check(const Parameters *p)
{
    Fault f = {"none", "", NULL, 0.0};
    return block_check(p, &f) ? NULL : f.name;
}

const char *direct_start(const Parameters *p, const Inputs *u)
{
    Fault f = {"none", "", NULL, 0.0};
    block_prepare(p, &law);
    return block_start(&law, u, &state, &f) ? NULL : f.name;
}

const char *direct_outputs(const Inputs *u, Outputs *y)
{
    Fault f = {"none", "", NULL, 0.0};
    return block_outputs(&law, &state, u, y, &f) ? NULL : f.name;
}

const char *direct_step(const Inputs *u, double h, Outputs *y)
{
    Fault f = {"none", "", NULL, 0.0};
    return block_step(&law, &state, u, h, y, &f) ? NULL : f.name;
}
