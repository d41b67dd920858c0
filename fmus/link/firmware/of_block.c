/* A block that is written for the FMI shell (check, prepare, start, outputs, step) as the one function of a device.
 * block.h gives its types State, Law and Memory and the names of its functions. */
#include "block.h"

#include <string.h>

/* "name: expected what is expected"; the device has no room to print numbers. */
static const char *text_of(const Fault *f, char *text, size_t size)
{
    const char *const parts[] = {f->name, ": expected ", f->expected};
    size_t n = 0;
    for (size_t k = 0; k < 3; ++k) {
        for (const char *c = parts[k]; *c != '\0' && n + 1 < size; ++c) {
            text[n++] = *c;
        }
    }
    text[n] = '\0';
    return text;
}

const char *block_sample(const Parameters *p, Memory *memory, const Inputs *u, double t, double h, Outputs *y)
{
    Fault f = {"", "", NULL, 0.0};
    (void)t;
    if (h == 0.0 || memcmp(&memory->p, p, sizeof *p) != 0) {
        if (!block_check(p, &f)) {
            return text_of(&f, memory->why, sizeof memory->why);
        }
        memory->p = *p;
        block_prepare(p, &memory->law);
    }
    const bool done = h == 0.0 ? block_start(&memory->law, u, &memory->state, &f) &&
                                     block_outputs(&memory->law, &memory->state, u, y, &f)
                               : block_step(&memory->law, &memory->state, u, h, y, &f);
    return done ? NULL : text_of(&f, memory->why, sizeof memory->why);
}
