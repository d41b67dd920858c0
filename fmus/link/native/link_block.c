/* The block that the FMI shell calls: each step asks the device, in lock-step or for its latest sample. */
#include "link_block.h"

#include "samples.h"

#include <math.h>
#include <string.h>

enum { LOCK_STEP = 1, FREE_RUNNING };  /* the items of link_mode */
enum { SILENT_STOP = 1, SILENT_HOLD }; /* the items of link_when_silent; the third is zero */
static const double LOOK_EVERY = 1.0;  /* s of wall time between two looks for a silent device */
static const double LOOK_FOR = 0.01;   /* s that such a look takes at most; a later answer counts at a later step */
static const double ROUNDING = 1e-6;   /* relative, of the time of a start */

static LinkSettings settings(const Parameters *p)
{
    const bool big = p->link_byte_order == 2, single = p->link_precision == 2;
    return (LinkSettings){.address = p->link_address,
                          .time_out = p->link_time_out,
                          .transport = p->link_transport,
                          .baud = p->link_baud,
                          .tries = p->link_tries,
                          .format = (uint8_t)((big ? LINK_BIG_ENDIAN : 0) | (single ? LINK_SINGLE : 0))};
}

bool link_check(const Parameters *p, Fault *f)
{
    const bool net = p->link_transport <= LINE_TCP;
    const bool good = net ? line_is_host_port(p->link_address) : p->link_address[0] != '\0';
    *f = (Fault){"link_address", net ? "HOST:PORT with a port from 1 to 65535" : "a serial device or a pipe",
                 p->link_address, 0.0};
    return good;
}

void link_prepare(const Parameters *p, Law *law)
{
    const Parameters *was = &law->p;
    if (strcmp(p->link_address, was->link_address) != 0 || p->link_transport != was->link_transport ||
        p->link_baud != was->link_baud || p->link_byte_order != was->link_byte_order ||
        p->link_precision != was->link_precision) {
        link_release(law);
    }
    law->p = *p;
}

void link_release(Law *law)
{
    link_hang_up(&law->link);
    law->is_told = law->silent = false;
    law->link.reader.damaged = 0;
    law->silent_steps = law->restarts = 0;
}

/* Parameters, where the device does not have them as they are. */
static LinkEnd tell_parameters(Law *law, const LinkSettings *s, Fault *f)
{
    LinkFrame answer;
    if (law->is_told && memcmp(&law->told, &law->p, sizeof law->p) == 0) {
        return LINK_ANSWERED;
    }
    const size_t n = link_put(&link_parameter_fields, &law->p, s->format, law->link.sent + LINK_HEADER);
    const LinkEnd end = link_request(&law->link, s, LINK_PARAMETERS, n, s->time_out, &answer, f);
    if (end == LINK_ANSWERED) {
        memcpy(&law->told, &law->p, sizeof law->p);
        law->is_told = true;
    }
    return end;
}

/* Sends t, and h where there is one, and the inputs; the size of the payload. */
static size_t put_inputs(Law *law, const LinkSettings *s, double t, double h, const Inputs *u)
{
    uint8_t *payload = law->link.sent + LINK_HEADER;
    link_put_time(t, s->format, payload);
    link_put_time(h, s->format, payload + 8);
    return 16 + link_put(&link_input_fields, u, s->format, payload + 16);
}

/* A request that the device answers with its outputs at a time. */
static LinkEnd ask(Law *law, const LinkSettings *s, uint8_t type, double t, double h, const Inputs *u, State *x,
                   Fault *f)
{
    LinkFrame answer;
    const LinkEnd end = link_request(&law->link, s, type, put_inputs(law, s, t, h, u), s->time_out, &answer, f);
    if (end != LINK_ANSWERED) {
        return end;
    }
    if (!link_is_sample(&answer, s->format)) {
        return link_wrong_size(law, &answer, f);
    }
    const double time = link_take_time(answer.payload, s->format);
    if (!(fabs(time - (t + h)) <= (h > 0.0 ? 0.5 * h : ROUNDING * (1.0 + fabs(t))))) {
        return link_other_time(law, t + h, time, f);
    }
    return link_note_sample(law, x, t + h, answer.payload + 8, s->format, f);
}

/* Lets the device begin at a time, with these inputs; it forgets what was before. */
static LinkEnd begin(Law *law, const LinkSettings *s, double t, const Inputs *u, State *x, Fault *f)
{
    law->is_told = law->is_told && law->link.same_session;
    LinkEnd end = tell_parameters(law, s, f);
    if (end == LINK_ANSWERED) {
        end = ask(law, s, LINK_START, t, 0.0, u, x, f);
    }
    law->link.same_session = end == LINK_ANSWERED;
    return end;
}

/* The same with a device that has lost its memory since it was greeted. */
static LinkEnd begin_anew(Law *law, const LinkSettings *s, double t, const Inputs *u, State *x, Fault *f)
{
    law->link.greeted = false;
    const LinkEnd end = link_greet(&law->link, s, s->time_out, f);
    return end == LINK_ANSWERED ? begin(law, s, t, u, x, f) : end;
}

bool link_start(Law *law, const Inputs *u, State *x, Fault *f)
{
    const LinkSettings s = settings(&law->p);
    law->silent = false;
    LinkEnd end = link_greet(&law->link, &s, s.time_out, f);
    if (end == LINK_ANSWERED) {
        end = begin(law, &s, 0.0, u, x, f);
    }
    if (end == LINK_RESTARTED) { /* after an earlier look at the outputs */
        end = begin_anew(law, &s, 0.0, u, x, f);
    }
    return end == LINK_ANSWERED;
}

/* Sends the inputs and takes what has come; silent where no sample has come for the time-out. */
static LinkEnd run_free(Law *law, const LinkSettings *s, double h, const Inputs *u, State *x, Fault *f)
{
    const size_t n = put_inputs(law, s, x->t, h, u);
    LinkEnd end = link_tell(&law->link, s, LINK_STEP, n, f);
    if (end == LINK_ANSWERED) {
        end = link_take_samples(law, s, h, x, f);
    }
    if (end == LINK_ANSWERED && line_now() - law->heard > s->time_out) {
        return link_silent(&law->link, s, f);
    }
    return end;
}

/* Looks for a silent device: calls it seldom, waits for a short time, and takes its answer when it comes. One that has
 * lost its memory begins anew where the run is. */
static LinkEnd look(Law *law, const LinkSettings *s, const Inputs *u, double t, State *x, Fault *f)
{
    double until = line_now();
    if (until - law->tried >= LOOK_EVERY) {
        until += LOOK_FOR;
        law->link.greeted = false;
        link_call(&law->link, s, LOOK_FOR);
        law->tried = line_now();
    }
    LinkEnd end = link_called(&law->link, s, until, f);
    if (end == LINK_ANSWERED && !law->link.same_session) {
        end = begin(law, s, t, u, x, f);
        law->restarts += end == LINK_ANSWERED;
    }
    if (end == LINK_ANSWERED) {
        law->tried = law->heard = line_now();
    }
    return end;
}

static LinkEnd exchange(Law *law, const LinkSettings *s, double h, const Inputs *u, State *x, Fault *f)
{
    LinkEnd end = LINK_ANSWERED;
    if (law->silent && (end = look(law, s, u, x->t + h, x, f)) != LINK_ANSWERED) {
        return end;
    }
    if (law->silent && x->sample_time >= x->t + h) {
        return LINK_ANSWERED; /* it has just begun, with these inputs */
    }
    if ((end = tell_parameters(law, s, f)) == LINK_ANSWERED) {
        end = law->p.link_mode == LOCK_STEP ? ask(law, s, LINK_STEP, x->t, h, u, x, f) : run_free(law, s, h, u, x, f);
    }
    if (end == LINK_RESTARTED && law->p.link_when_silent != SILENT_STOP) {
        end = begin_anew(law, s, x->t + h, u, x, f);
        law->restarts += end == LINK_ANSWERED;
    }
    return end;
}

bool link_step(Law *law, State *x, const Inputs *u, double h, Outputs *y, Fault *f)
{
    const LinkSettings s = settings(&law->p);
    const LinkEnd end = exchange(law, &s, h, u, x, f);
    if (end == LINK_FAULT || (end != LINK_ANSWERED && law->p.link_when_silent == SILENT_STOP)) {
        return false;
    }
    if (end != LINK_ANSWERED) {
        if (!law->silent) {
            law->tried = line_now();
        }
        if (law->p.link_when_silent != SILENT_HOLD) {
            link_zero_outputs(&x->y);
        }
        ++law->silent_steps;
    }
    law->silent = end != LINK_ANSWERED;
    x->t += h;
    return link_outputs(law, x, u, y, f);
}

/* Between steps nothing is asked: the outputs are those of the last answer, whatever has been set since. */
bool link_outputs(const Law *law, const State *x, const Inputs *u, Outputs *y, Fault *f)
{
    (void)u, (void)f;
    *y = x->y;
    y->link_age = x->t - x->sample_time;
    y->link_silent = law->silent;
    y->link_silent_steps = law->silent_steps;
    y->link_restarts = law->restarts;
    y->link_damaged_frames = (int32_t)law->link.reader.damaged;
    y->link_round_trip = law->link.round_trip;
    return true;
}
