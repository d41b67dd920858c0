/* Requests to a device and its answers, each in a bounded time: the end of the line that is in the FMU. */
#ifndef LINK_EXCHANGE_H
#define LINK_EXCHANGE_H

#include "fault.h"
#include "frame.h"
#include "line.h"
#include "wire.h"

typedef struct {
    const char *address;
    double time_out; /* s of wall time, for an answer */
    int transport, baud, tries;
    uint8_t format;
} LinkSettings;

/* The line and what is known of the device; it lasts as long as the FMU's instance and is no part of a block's state. */
typedef struct {
    Line line;
    LinkReader reader;
    uint8_t received[LINK_FRAME_MAX], sent[LINK_FRAME_MAX];
    uint8_t bytes[512]; /* that came and are not looked at yet */
    int count, next;
    uint32_t session, sequence;
    bool greeted;      /* the device has answered, and is of this interface */
    bool same_session; /* it has been started by this instance and has lost no memory since */
    double round_trip; /* of the last answer, s */
    char where[320];   /* "device at udp 127.0.0.1:5020" */
    char reason[160];  /* what the device or the system says */
} Link;

typedef enum {
    LINK_ANSWERED,
    LINK_SILENT,    /* no answer in time, or no line */
    LINK_RESTARTED, /* the device has lost its memory */
    LINK_FAULT      /* what no later answer mends: told in the fault */
} LinkEnd;

/* Opens the line where it is not open, and greets the device where it has not answered yet. */
LinkEnd link_greet(Link *link, const LinkSettings *settings, double wait, Fault *f);

/* Sends a request again and again, and takes its answer. The payload stands at link->sent + LINK_HEADER. */
LinkEnd link_request(Link *link, const LinkSettings *settings, uint8_t type, size_t payload, double wait,
                     LinkFrame *answer, Fault *f);

/* Sends a request and waits for no answer. */
LinkEnd link_tell(Link *link, const LinkSettings *settings, uint8_t type, size_t payload, Fault *f);

/* The next frame of this session that has come until then: LINK_ANSWERED, or LINK_SILENT where there is none. */
LinkEnd link_poll(Link *link, double until, LinkFrame *frame, Fault *f);

/* The text of a frame of the type LINK_REFUSED. */
LinkEnd link_refused(Link *link, const LinkFrame *frame, Fault *f);

/* That the device gave no answer in time; with what else is known. */
bool link_silent(const Link *link, Fault *f);

void link_hang_up(Link *link);

#endif
