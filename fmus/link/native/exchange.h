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
    uint32_t hello;            /* the first of the requests by which a silent device is called; 0 where none is open */
    uint8_t token[LINK_TOKEN]; /* of this instance's runs */
    bool greeted;              /* the device has answered, and is of this interface */
    bool same_session;         /* it has been started by this instance and has lost no memory since */
    double round_trip;         /* of the last answer, s */
    struct {
        uint32_t sequence;
        double at;   /* s of the monotonic clock */
    } told[64];      /* the last requests that nobody waits for */
    char where[320]; /* "device at udp 127.0.0.1:5020" */
    char expected[96];
    char reason[160]; /* what the device or the system says */
} Link;

typedef enum {
    LINK_ANSWERED,
    LINK_SILENT,    /* no answer in time, or no line */
    LINK_RESTARTED, /* the device has lost its memory */
    LINK_BUSY,      /* another run uses the device: told in the fault */
    LINK_FAULT      /* what no later answer mends: told in the fault */
} LinkEnd;

/* Opens the line where it is not open, and greets the device where it has not answered yet. */
LinkEnd link_greet(Link *link, const LinkSettings *settings, double wait, Fault *f);

/* Calls a silent device and does not wait for its answer, but for the time to open the line. */
void link_call(Link *link, const LinkSettings *settings, double wait);

/* Whether it has answered a call until then, however late; other frames that have come are of no use any more. */
LinkEnd link_called(Link *link, const LinkSettings *settings, double until, Fault *f);

/* Sends a request again and again, and takes its answer. The payload stands at link->sent + LINK_HEADER. */
LinkEnd link_request(Link *link, const LinkSettings *settings, uint8_t type, size_t payload, double wait,
                     LinkFrame *answer, Fault *f);

/* Sends a request and waits for no answer. */
LinkEnd link_tell(Link *link, const LinkSettings *settings, uint8_t type, size_t payload, Fault *f);

/* The next frame of this session that has come until then: LINK_ANSWERED, or LINK_SILENT where there is none. */
LinkEnd link_poll(Link *link, double until, LinkFrame *frame, Fault *f);

/* Takes the time of the request that this frame answers for the round trip. */
void link_timed(Link *link, uint32_t sequence);

/* The text of a frame of the type LINK_REFUSED. */
LinkEnd link_refused(Link *link, const LinkFrame *frame, Fault *f);

/* That the device gave no answer in time; with what else is known. */
LinkEnd link_silent(Link *link, const LinkSettings *settings, Fault *f);

/* That an answer is of no use: `found` is kept as the reason. */
LinkEnd link_useless(Link *link, const char *expected, const char *found, Fault *f);

/* Tells the device that the run has ended, and closes the line. */
void link_hang_up(Link *link);

/* A fault of the device; what was found is kept in `reason`, in printable ASCII. */
LinkEnd link_wrong(Link *link, Fault *f, const char *expected, const char *found);

/* Opens the line where it is not open. */
bool link_open(Link *link, const LinkSettings *settings, double wait);

/* Puts printable ASCII behind a text. */
void link_append(char *text, size_t size, const char *more);

#endif
