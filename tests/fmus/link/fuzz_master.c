/* A line that loses, damages, repeats and mixes the answers of a device, at the end that is in the FMU, under sanitizers:
 * `fuzz_master SEED FRAMES`. Each step ends; one that is said to be answered has the outputs of that step. Exit status 1
 * where not. The line and its clock are in this file, so nothing is waited for. */
#include <stdio.h>
#include <stdlib.h>

#include "block.h"
#include "random.h"

enum { ROOM = 1 << 16 };

static uint8_t line[ROOM];
static size_t held;
static long sent_frames, good, silent;
static double now;
static bool started;

double line_now(void)
{
    return now += 1e-4;
}

void line_sleep(double seconds)
{
    now += seconds;
}

bool line_open(Line *l, Transport transport, const char *address, int baud, double wait, char *reason, size_t size)
{
    (void)address, (void)baud, (void)wait;
    l->transport = transport;
    l->open = pick(50) != 0;
    snprintf(reason, size, "%s", l->open ? "" : "not today");
    return l->open;
}

void line_close(Line *l)
{
    l->open = false;
}

static void answer_with(uint8_t *frame, size_t n)
{
    n = damage(frame, n, LINK_FRAME_MAX);
    for (unsigned k = pick(6) == 0 ? pick(3) : 1; k > 0 && held + n <= sizeof line; --k) {
        const size_t at = pick(10) == 0 ? 0 : held; /* before what has not been read yet */
        memmove(line + at + n, line + at, held - at);
        memcpy(line + at, frame, n);
        held += n;
        ++sent_frames;
    }
}

/* The device: its attitude_error is the time of the sample. */
bool line_send(Line *l, const uint8_t *bytes, size_t n, double until)
{
    static uint8_t room[LINK_FRAME_MAX], answer[LINK_FRAME_MAX];
    static LinkReader reader = {.bytes = room, .size = sizeof room};
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH;
    (void)l, (void)until;
    for (size_t i = 0; i < n; ++i) {
        LinkFrame f;
        link_push(&reader, bytes[i]);
        while (link_next(&reader, &f)) {
            uint8_t *payload = answer + LINK_HEADER;
            uint8_t type = f.type | LINK_ANSWER;
            size_t size = 0;
            if (f.type == LINK_HELLO) {
                memset(payload, 0, LINK_GREETING);
                payload[1] = started ? LINK_STARTED : 0;
                memcpy(payload + 2, hash, LINK_HASH);
                memcpy(payload + LINK_AT_TOKEN, f.payload + LINK_AT_TOKEN, LINK_TOKEN);
                size = LINK_GREETING;
            } else if (f.type == LINK_STEP && (!started || pick(200) == 0)) {
                started = false;
                type = LINK_REFUSED;
                memset(payload, 0, LINK_REFUSAL);
                payload[0] = LINK_NOT_STARTED;
                size = LINK_REFUSAL;
            } else if (f.type != LINK_PARAMETERS) {
                const double t =
                    link_take_time(f.payload, 0) + (f.type == LINK_STEP ? link_take_time(f.payload + 8, 0) : 0.0);
                const Outputs y = {.attitude_error = t};
                started = true;
                link_put_time(t, 0, payload);
                size = 8 + link_put(&link_output_fields, &y, 0, payload + 8);
            }
            answer_with(answer, link_close_frame(answer, type, f.session, f.sequence, size));
        }
    }
    return pick(300) != 0;
}

int line_receive(Line *l, uint8_t *bytes, size_t n, double until)
{
    size_t some = held == 0 ? 0 : 1 + pick((unsigned)(held < n ? held : n));
    some = some < held ? some : held;
    some = some < n ? some : n;
    (void)l;
    memcpy(bytes, line, some);
    memmove(line, line + some, held - some);
    held -= some;
    now = some == 0 && now < until ? until : now + 1e-4;
    return pick(2000) == 0 ? -1 : (int)some;
}

/* A run of some steps; false where one is said to be answered and is not. */
static bool run(Law *law)
{
    Parameters p = {.link_transport = 1 + (int32_t)pick(4),
                    .link_mode = 1 + (int32_t)pick(2),
                    .link_baud = 9600,
                    .link_time_out = 1.0,
                    .link_age_max = 1e9,
                    .link_tries = 1 + (int32_t)pick(5),
                    .link_when_silent = 1 + (int32_t)pick(3),
                    .link_byte_order = 1,
                    .link_precision = 1,
                    .link_address = "there"};
    Inputs u = {0};
    Outputs y;
    State x = {0};
    Fault f;
    link_prepare(&p, law);
    if (!link_check(&p, &f) || !link_start(law, &u, &x, &f)) {
        return true;
    }
    for (int k = 0; k < 200; ++k) {
        const bool done = link_step(law, &x, &u, 0.125, &y, &f);
        if (!done) {
            break;
        }
        good += !y.link_silent;
        silent += y.link_silent;
        if (p.link_mode == 1 && !y.link_silent && y.attitude_error != x.t) {
            printf("step to %g has the outputs of %g\n", x.t, y.attitude_error);
            return false;
        }
    }
    link_release(law);
    return true;
}

int main(int count, char **arguments)
{
    static Law law;
    seed = count > 1 ? strtoull(arguments[1], NULL, 10) : 1;
    const long frames = count > 2 ? strtol(arguments[2], NULL, 10) : 1000;
    while (sent_frames < frames) {
        if (!run(&law)) {
            return 1;
        }
    }
    printf("%ld frames, %ld steps answered, %ld silent\n", sent_frames, good, silent);
    return 0;
}
