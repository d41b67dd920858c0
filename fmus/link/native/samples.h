/* Which answers are samples: of the right size, of the instant that was asked for, with finite values. */
#ifndef LINK_SAMPLES_H
#define LINK_SAMPLES_H

#include "link_block.h"

/* Whether an answer has as many bytes as a time and the outputs. */
bool link_is_sample(const LinkFrame *answer, uint8_t format);

LinkEnd link_wrong_size(const Law *law, const LinkFrame *answer, Fault *f);

/* That the sample is of another time than that which was asked for: it is of no use. */
LinkEnd link_other_time(Law *law, double asked, double time, Fault *f);

/* Takes a sample whose values are finite; else it is of no use, and its port is named. */
LinkEnd link_note_sample(Law *law, State *x, double time, const uint8_t *payload, uint8_t format, Fault *f);

/* Free running: takes in the samples that came since the last step, which lasts h; keeps the newest, whatever their order. */
LinkEnd link_take_samples(Law *law, const LinkSettings *s, double h, State *x, Fault *f);

#endif
