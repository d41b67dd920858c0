/* The greeting: what the device is, that it answers to this run, and the calls for one that is silent. */
#include "exchange.h"

#include <string.h>

static const double ASK_AGAIN = 0.05; /* s, where another run uses the device */

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
        return link_wrong(link, f, "a greeting of this protocol", "one of another size");
    }
    memcpy(name, answer->payload + 2 + LINK_HASH, LINK_NAME);
    if (memcmp(answer->payload + 2, hash, LINK_HASH) != 0) {
        char text[LINK_NAME + 64] = "";
        link_append(text, sizeof text, name);
        link_append(text, sizeof text, strcmp(name, LINK_INTERFACE) == 0 ? " with other ports or parameters" : "");
        return link_wrong(link, f, "one built for the interface " LINK_INTERFACE, text);
    }
    if (answer->payload[0] != s->format) {
        return link_wrong(link, f, "what link_byte_order and link_precision say", format_name(answer->payload[0]));
    }
    if (memcmp(answer->payload + LINK_AT_TOKEN, link->token, LINK_TOKEN) != 0) {
        return link_wrong(link, f, "the token of this run", "another one");
    }
    link->same_session = link->same_session && (answer->payload[1] & LINK_STARTED) != 0;
    link->greeted = true;
    link->hello = 0;
    return LINK_ANSWERED;
}

/* Mixes the bits of a number, so that near ones give far ones. */
static uint64_t mixed(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* The payload of a hello; numbers that an earlier run has hardly had where a run begins. */
static void put_hello(Link *link, const LinkSettings *s)
{
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH, none[LINK_TOKEN] = {0};
    const uint64_t now = mixed((uint64_t)(1e9 * line_now()) ^ mixed((uint64_t)(uintptr_t)link));
    if (!link->same_session && link->hello == 0) {
        link->session = (uint32_t)(now >> 32);
    }
    if (memcmp(link->token, none, LINK_TOKEN) == 0) {
        const uint64_t token = mixed(now + 1) | 1;
        memcpy(link->token, &token, LINK_TOKEN);
    }
    uint8_t *payload = link->sent + LINK_HEADER;
    memset(payload, 0, LINK_GREETING);
    payload[0] = s->format;
    memcpy(payload + 2, hash, LINK_HASH);
    memcpy(payload + 2 + LINK_HASH, LINK_INTERFACE, sizeof LINK_INTERFACE - 1);
    memcpy(payload + LINK_AT_TOKEN, link->token, LINK_TOKEN);
}

LinkEnd link_greet(Link *link, const LinkSettings *s, double wait, Fault *f)
{
    const double until = line_now() + wait;
    LinkFrame answer;
    if (!link_open(link, s, wait)) {
        *f = (Fault){link->where, "a line that can be opened", link->reason, 0.0};
        return LINK_SILENT;
    }
    if (link->greeted) {
        return LINK_ANSWERED;
    }
    for (;;) {
        put_hello(link, s);
        const LinkEnd end = link_request(link, s, LINK_HELLO, LINK_GREETING, until - line_now(), &answer, f);
        if (end == LINK_ANSWERED) {
            return judge(link, s, &answer, f);
        }
        if (end != LINK_BUSY || line_now() + ASK_AGAIN > until) {
            return end;
        }
        line_sleep(ASK_AGAIN);
    }
}

void link_call(Link *link, const LinkSettings *s, double wait)
{
    Fault unused;
    if (!link_open(link, s, wait)) {
        return;
    }
    put_hello(link, s);
    link_tell(link, s, LINK_HELLO, LINK_GREETING, &unused);
    if (link->hello == 0) {
        link->hello = link->sequence;
    }
}

LinkEnd link_called(Link *link, const LinkSettings *s, double until, Fault *f)
{
    LinkFrame frame;
    LinkEnd end = LINK_SILENT;
    while (link->line.open && (end = link_poll(link, until, &frame, f)) == LINK_ANSWERED) {
        if (link->hello != 0 && frame.sequence >= link->hello) {
            if (frame.type == (LINK_HELLO | LINK_ANSWER)) {
                link_timed(link, frame.sequence);
                return judge(link, s, &frame, f);
            }
            if (frame.type == LINK_REFUSED) {
                return link_refused(link, &frame, f);
            }
        }
    }
    return end == LINK_FAULT ? end : LINK_SILENT;
}
