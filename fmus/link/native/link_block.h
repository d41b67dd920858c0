/* The block that the FMI shell runs: it asks a device at the end of a line. Made for one interface by the generated
 * block.h, whose Parameters and Outputs hold those of the block and, by the names link_..., those of link.toml. */
#ifndef LINK_BLOCK_H
#define LINK_BLOCK_H

#include "block.h"
#include "exchange.h"

/* The outputs of the last answer; the device's own memory is out of reach, so no state of this FMU can be saved. */
struct LinkState {
    double t;           /* s since the start */
    double sample_time; /* for which y was worked out, s since the start */
    Outputs y;
};

struct LinkLaw {
    Parameters p;
    Parameters told; /* what the device has been told */
    bool is_told;
    Link link;
    bool silent;         /* no answer came in time: the outputs are held or zero */
    double heard, tried; /* when a sample came and the device was last looked for, s of the monotonic clock */
    int32_t silent_steps, restarts;
};

bool link_check(const Parameters *p, Fault *f);
void link_prepare(const Parameters *p, Law *law);
bool link_start(Law *law, const Inputs *u, State *x, Fault *f);
bool link_outputs(const Law *law, const State *x, const Inputs *u, Outputs *y, Fault *f);
bool link_step(Law *law, State *x, const Inputs *u, double h, Outputs *y, Fault *f);

/* Zero, or the value nearest to it that an output may have. */
void link_zero_outputs(Outputs *y);

/* The name of an output that is not finite; NULL where all are. */
const char *link_not_finite(const Outputs *y);

/* Closes the line: the instance ends or begins anew. */
void link_release(Law *law);

#endif
