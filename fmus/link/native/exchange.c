/* Requests to a device and its answers: sent again where none comes, each taken once. */
#include "exchange.h"
#include "instance.h"

#include <string.h>

static const char *const transports[] = {"", "udp ", "tcp ", "serial ", "pipe "};
static const double AGAIN = 1e-3;  /* s, the shortest time between two attempts */
static const double BEYOND = 0.02; /* s, for which a line that never ends is read beyond the time */

void link_append(char *text, size_t size, const char *more)
{
    size_t n = strlen(text);
    for (; *more != '\0' && n + 1 < size; ++more) {
        /* A device's words reach a log: nothing but printable ASCII. */
        text[n++] = *more >= ' ' && *more <= '~' ? *more : '?';
    }
    text[n] = '\0';
}

LinkEnd link_wrong(Link *link, Fault *f, const char *expected, const char *found)
{
    char text[sizeof link->reason] = "";
    link_append(text, sizeof text, found); /* which may be link->reason itself */
    memcpy(link->reason, text, sizeof text);
    *f = (Fault){link->where, expected, link->reason, 0.0};
    return LINK_FAULT;
}

LinkEnd link_silent(Link *link, const LinkSettings *s, Fault *f)
{
    Message m = message("an answer within link_time_out (");
    put_number(&m, s->time_out);
    put(&m, " s)");
    memcpy(link->expected, m.text, sizeof link->expected);
    link->expected[sizeof link->expected - 1] = '\0';
    *f = (Fault){link->where, link->expected, link->reason[0] != '\0' ? link->reason : "no answer", 0.0};
    return LINK_SILENT;
}

LinkEnd link_useless(Link *link, const char *expected, const char *found, Fault *f)
{
    link->expected[0] = '\0';
    link_append(link->expected, sizeof link->expected, expected);
    link_wrong(link, f, link->expected, found);
    return LINK_SILENT;
}

/* After this a line is opened anew and the device greeted again, in the same session. */
static void lose(Link *link)
{
    line_close(&link->line);
    link->greeted = false;
    link->reason[0] = '\0';
    link_append(link->reason, sizeof link->reason, "the line is closed or blocked at the other end");
}

void link_hang_up(Link *link)
{
    if (link->line.open && link->greeted) {
        const size_t n = link_close_frame(link->sent, LINK_END, link->session, ++link->sequence, 0);
        line_send(&link->line, link->sent, n, line_now());
    }
    lose(link);
    link->same_session = false;
    link->hello = 0;
}

bool link_open(Link *link, const LinkSettings *s, double wait)
{
    if (link->line.open) {
        return true;
    }
    link->where[0] = link->reason[0] = '\0';
    link_append(link->where, sizeof link->where, "device at ");
    link_append(link->where, sizeof link->where, transports[s->transport]);
    link_append(link->where, sizeof link->where, s->address);
    link->reader.bytes = link->received;
    link->reader.size = sizeof link->received;
    link->reader.held = link->reader.taken = 0;
    link->count = link->next = 0;
    return line_open(&link->line, (Transport)s->transport, s->address, s->baud, wait, link->reason,
                     sizeof link->reason);
}

/* The next frame of this session. Ends where the time is over, also where bytes of no use come on and on. */
LinkEnd link_poll(Link *link, double until, LinkFrame *frame, Fault *f)
{
    for (;;) {
        while (link_next(&link->reader, frame)) {
            if (frame->type >= LINK_ANSWER && frame->session == link->session) {
                if (frame->version != LINK_VERSION) {
                    *f = (Fault){link->where, "version 2 of the protocol", NULL, frame->version};
                    return LINK_FAULT;
                }
                return LINK_ANSWERED;
            }
        }
        if (link->next == link->count) {
            link->count = link->next = 0;
            const int some = line_receive(&link->line, link->bytes, sizeof link->bytes, until);
            if (some < 0) {
                lose(link);
            }
            if (some <= 0 || line_now() > until + BEYOND) {
                return LINK_SILENT;
            }
            link->count = some;
        }
        link_push(&link->reader, link->bytes[link->next++]);
    }
}

LinkEnd link_refused(Link *link, const LinkFrame *frame, Fault *f)
{
    char text[LINK_TEXT + 1] = "";
    const uint8_t code = frame->size == LINK_REFUSAL ? frame->payload[0] : 0;
    if (code == LINK_NOT_STARTED) {
        link->same_session = false;
        link_wrong(link, f, "that it keeps its memory", "it has restarted");
        return LINK_RESTARTED;
    }
    if (code == LINK_IN_USE) {
        memcpy(text, frame->payload + 1, LINK_TEXT);
        link_wrong(link, f, "a device that no other run uses", text);
        return LINK_BUSY;
    }
    if (frame->size == LINK_REFUSAL) {
        memcpy(text, frame->payload + 1, LINK_TEXT);
    }
    return link_wrong(link, f, "that it accepts the request", text[0] != '\0' ? text : "a refusal without a reason");
}

LinkEnd link_request(Link *link, const LinkSettings *s, uint8_t type, size_t payload, double wait, LinkFrame *answer,
                     Fault *f)
{
    const double begin = line_now(), each = wait / s->tries > AGAIN ? wait / s->tries : AGAIN;
    const uint32_t sequence = ++link->sequence;
    const size_t n = link_close_frame(link->sent, type, link->session, sequence, payload);
    for (int k = 0; k < s->tries && link->line.open; ++k) {
        const double until = begin + each * (k + 1);
        if (!line_send(&link->line, link->sent, n, until)) {
            lose(link);
            break;
        }
        for (LinkEnd end = LINK_ANSWERED; end != LINK_SILENT;) {
            end = link_poll(link, until, answer, f);
            if (end == LINK_FAULT) {
                return end;
            }
            if (end == LINK_ANSWERED && answer->sequence == sequence) {
                link->round_trip = line_now() - begin;
                link->reason[0] = '\0';
                if (answer->type == LINK_REFUSED) {
                    return link_refused(link, answer, f);
                }
                if (answer->type == (type | LINK_ANSWER)) {
                    return LINK_ANSWERED;
                }
            }
            if (line_now() > until) {
                break;
            }
        }
    }
    return link_silent(link, s, f);
}

LinkEnd link_tell(Link *link, const LinkSettings *s, uint8_t type, size_t payload, Fault *f)
{
    const size_t n = link_close_frame(link->sent, type, link->session, ++link->sequence, payload);
    if (!link->line.open || !line_send(&link->line, link->sent, n, line_now() + s->time_out)) {
        lose(link);
        return link_silent(link, s, f);
    }
    const size_t room = sizeof link->told / sizeof link->told[0];
    link->told[link->sequence % room].sequence = link->sequence;
    link->told[link->sequence % room].at = line_now();
    return LINK_ANSWERED;
}

void link_timed(Link *link, uint32_t sequence)
{
    const size_t k = sequence % (sizeof link->told / sizeof link->told[0]);
    if (link->told[k].sequence == sequence && sequence != 0) {
        link->round_trip = line_now() - link->told[k].at;
        link->told[k].sequence = 0; /* a sample that the device repeats says nothing of the line */
    }
}
