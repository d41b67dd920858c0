/* Requests to a device and its answers: sent again where none comes, each taken once. */
#include "exchange.h"

#include <string.h>

static const char *const transports[] = {"", "udp ", "tcp ", "serial ", "pipe "};
static const double AGAIN = 1e-3;  /* s, the shortest time between two attempts */
static const double BEYOND = 0.02; /* s, for which a line that never ends is read beyond the time */

static void append(char *text, size_t size, const char *more)
{
    size_t n = strlen(text);
    for (; *more != '\0' && n + 1 < size; ++more) {
        /* A device's words reach a log: nothing but printable ASCII. */
        text[n++] = *more >= ' ' && *more <= '~' ? *more : '?';
    }
    text[n] = '\0';
}

/* A fault of the device, with a text of Link as what was found. */
static LinkEnd wrong(Link *link, Fault *f, const char *expected, const char *found)
{
    char text[sizeof link->reason] = "";
    append(text, sizeof text, found); /* which may be link->reason itself */
    memcpy(link->reason, text, sizeof text);
    *f = (Fault){link->where, expected, link->reason, 0.0};
    return LINK_FAULT;
}

bool link_silent(const Link *link, Fault *f)
{
    *f = (Fault){link->where, "an answer within the time-out", link->reason[0] != '\0' ? link->reason : "none", 0.0};
    return false;
}

/* After this a line is opened anew and the device greeted again, in the same session. */
static void lose(Link *link)
{
    line_close(&link->line);
    link->greeted = false;
    link->reason[0] = '\0';
    append(link->reason, sizeof link->reason, "the line is closed or blocked at the other end");
}

void link_hang_up(Link *link)
{
    lose(link);
    link->same_session = false;
}

static bool open_line(Link *link, const LinkSettings *s, double wait)
{
    if (link->line.open) {
        return true;
    }
    link->where[0] = link->reason[0] = '\0';
    append(link->where, sizeof link->where, "device at ");
    append(link->where, sizeof link->where, transports[s->transport]);
    append(link->where, sizeof link->where, s->address);
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
                    *f = (Fault){link->where, "version 1 of the protocol", NULL, frame->version};
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
        wrong(link, f, "that it keeps its memory", "it has restarted");
        return LINK_RESTARTED;
    }
    if (frame->size == LINK_REFUSAL) {
        memcpy(text, frame->payload + 1, LINK_TEXT);
    }
    return wrong(link, f, "that it accepts the request", text[0] != '\0' ? text : "a refusal without a reason");
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
    link_silent(link, f);
    return LINK_SILENT;
}

LinkEnd link_tell(Link *link, const LinkSettings *s, uint8_t type, size_t payload, Fault *f)
{
    const size_t n = link_close_frame(link->sent, type, link->session, ++link->sequence, payload);
    if (!link->line.open || !line_send(&link->line, link->sent, n, line_now() + s->time_out)) {
        lose(link);
        link_silent(link, f);
        return LINK_SILENT;
    }
    return LINK_ANSWERED;
}

static const char *format_name(uint8_t format)
{
    static const char *const names[] = {"little-endian, double", "big-endian, double", "little-endian, single",
                                        "big-endian, single"};
    return names[format & (LINK_BIG_ENDIAN | LINK_SINGLE)];
}

static LinkEnd judge(Link *link, const LinkSettings *s, const LinkFrame *answer, Fault *f)
{
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH;
    char name[LINK_NAME + 1] = "";
    if (answer->size != LINK_GREETING) {
        return wrong(link, f, "a greeting of this protocol", "one of another size");
    }
    memcpy(name, answer->payload + 2 + LINK_HASH, LINK_NAME);
    if (memcmp(answer->payload + 2, hash, LINK_HASH) != 0) {
        char text[LINK_NAME + 64] = "";
        append(text, sizeof text, name);
        append(text, sizeof text, strcmp(name, LINK_INTERFACE) == 0 ? " with other ports or parameters" : "");
        return wrong(link, f, "one built for the interface " LINK_INTERFACE, text);
    }
    if (answer->payload[0] != s->format) {
        return wrong(link, f, "what link_byte_order and link_precision say", format_name(answer->payload[0]));
    }
    link->same_session = link->same_session && (answer->payload[1] & LINK_STARTED) != 0;
    link->greeted = true;
    return LINK_ANSWERED;
}

LinkEnd link_greet(Link *link, const LinkSettings *s, double wait, Fault *f)
{
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH;
    const double begin = line_now();
    LinkFrame answer;
    if (!open_line(link, s, wait)) {
        *f = (Fault){link->where, "a line that can be opened", link->reason, 0.0};
        return LINK_SILENT;
    }
    if (link->greeted) {
        return LINK_ANSWERED;
    }
    if (!link->same_session) { /* a number that an earlier run has hardly had */
        link->session =
            (uint32_t)((((uint64_t)(1e9 * begin) ^ (uint64_t)(uintptr_t)link) * 11400714819323198485u) >> 32);
    }
    uint8_t *payload = link->sent + LINK_HEADER;
    memset(payload, 0, LINK_GREETING);
    payload[0] = s->format;
    memcpy(payload + 2, hash, LINK_HASH);
    memcpy(payload + 2 + LINK_HASH, LINK_INTERFACE, sizeof LINK_INTERFACE - 1);
    const LinkEnd end = link_request(link, s, LINK_HELLO, LINK_GREETING, begin + wait - line_now(), &answer, f);
    return end == LINK_ANSWERED ? judge(link, s, &answer, f) : end;
}
