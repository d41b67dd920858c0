/* Which answers are samples: of the right size, of the instant that was asked for, with finite values. */
#include "samples.h"
#include "instance.h"

/* Takes a sample whose values are finite; else it is of no use, and its port is named. */
LinkEnd link_note_sample(Law *law, State *x, double time, const uint8_t *payload, uint8_t format, Fault *f)
{
    Outputs y = x->y;
    link_take(&link_output_fields, payload, format, &y);
    const char *name = link_not_finite(&y);
    if (name != NULL) {
        Message m = message("a finite number for ");
        put(&m, name);
        return link_useless(&law->link, m.text, "NaN or infinity", f);
    }
    x->y = y;
    x->sample_time = time;
    law->heard = line_now();
    return LINK_ANSWERED;
}

LinkEnd link_other_time(Law *law, double asked, double time, Fault *f)
{
    Message expected = message("outputs for "), found = message("those for ");
    put_number(&expected, asked);
    put(&expected, " s");
    put_number(&found, time);
    put(&found, " s");
    return link_useless(&law->link, expected.text, found.text, f);
}

/* The samples of an answer of the right size. */
bool link_is_sample(const LinkFrame *answer, uint8_t format)
{
    return answer->size == 8 + link_size(&link_output_fields, format);
}

LinkEnd link_wrong_size(const Law *law, const LinkFrame *answer, Fault *f)
{
    *f = (Fault){law->link.where, "an answer with as many bytes as the interface has outputs", NULL, answer->size};
    return LINK_FAULT;
}

/* Takes in the samples that came since the last step; keeps the newest, whatever their order. */
LinkEnd link_take_samples(Law *law, const LinkSettings *s, double h, State *x, Fault *f)
{
    const double now = x->t + h;
    LinkFrame frame;
    LinkEnd end;
    while ((end = link_poll(&law->link, line_now(), &frame, f)) == LINK_ANSWERED) {
        if (frame.type == LINK_REFUSED) {
            return link_refused(&law->link, &frame, f);
        }
        if (frame.type != (LINK_STEP | LINK_ANSWER)) {
            continue;
        }
        if (!link_is_sample(&frame, s->format)) {
            return link_wrong_size(law, &frame, f);
        }
        const double time = link_take_time(frame.payload, s->format);
        link_timed(&law->link, frame.sequence);
        if (!(time <= now + 0.5 * h && now - time <= law->p.link_age_max + 0.5 * h)) {
            link_other_time(law, now, time, f); /* of no use, and the reason where no other comes */
        } else if (time >= x->sample_time) {
            link_note_sample(law, x, time, frame.payload + 8, s->format, f);
        }
    }
    return end == LINK_FAULT ? end : LINK_ANSWERED;
}
