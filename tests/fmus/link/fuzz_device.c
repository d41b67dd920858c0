/* Random, damaged, repeated and unfinished frames at the firmware skeleton, under sanitizers: `fuzz_device SEED FRAMES`.
 * Now and then a whole conversation must be answered as if nothing had been before. Exit status 1 where it is not. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device.h"
#include "random.h"

static Device device;
static uint8_t out[LINK_FRAME_MAX];
static LinkReader reader = {.bytes = out, .size = sizeof out};
static LinkFrame last;
static long answers, calls;

static void take(void *line, const uint8_t *bytes, size_t n)
{
    (void)line;
    for (size_t i = 0; i < n; ++i) {
        link_push(&reader, bytes[i]);
        while (link_next(&reader, &last)) {
            ++answers;
        }
    }
}

const char *controller_sample(const ControllerParameters *p, ControllerMemory *x, const ControllerInputs *u, double t,
                              double h, ControllerOutputs *y)
{
    (void)p, (void)u;
    *y = (ControllerOutputs){.attitude_error = t + h};
    x->t = t + h;
    ++calls;
    return pick(20) == 0 ? "not today" : NULL;
}

static void feed(const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        device_receive(&device, bytes[i]);
    }
}

static size_t payload_of(uint8_t type, uint8_t *payload)
{
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH;
    const size_t n = type == LINK_HELLO        ? (size_t)LINK_GREETING
                     : type == LINK_PARAMETERS ? link_size(&link_parameter_fields, device.format)
                                               : 16 + link_size(&link_input_fields, device.format);
    for (size_t i = 0; i < n; ++i) {
        payload[i] = (uint8_t)pick(256);
    }
    if (type == LINK_HELLO) {
        memcpy(payload + 2, hash, LINK_HASH);
    }
    return n;
}

/* A request in order; the device's answer is then in `last`. */
static bool met(uint8_t type, uint32_t session, uint32_t sequence)
{
    uint8_t frame[LINK_FRAME_MAX];
    const long before = answers;
    size_t n = payload_of(type, frame + LINK_HEADER);
    frame[LINK_HEADER] = type == LINK_HELLO ? 0 : frame[LINK_HEADER];
    n = link_close_frame(frame, type, session, sequence, n);
    feed(frame, n);
    const long once = calls;
    feed(frame, n); /* again, as after a lost answer */
    return answers == before + 2 && calls == once && last.sequence == sequence && last.session == session &&
           (last.type == (type | LINK_ANSWER) || (type >= LINK_START && last.type == LINK_REFUSED));
}

static bool conversation(uint32_t session)
{
    static const uint8_t nothing[LINK_FRAME_MAX];
    feed(nothing, sizeof nothing); /* ends a frame that was not finished */
    return met(LINK_HELLO, session, 1) && met(LINK_PARAMETERS, session, 2) && met(LINK_START, session, 3) &&
           (!device.started || met(LINK_STEP, session, 4));
}

int main(int count, char **arguments)
{
    uint8_t frame[LINK_FRAME_MAX];
    seed = count > 1 ? strtoull(arguments[1], NULL, 10) : 1;
    const long frames = count > 2 ? strtol(arguments[2], NULL, 10) : 1000;
    device_begin(&device, take, NULL, NULL);
    for (long k = 0; k < frames; ++k) {
        const uint8_t type = pick(10) == 0 ? (uint8_t)pick(256) : (uint8_t)(1 + pick(4));
        size_t n = pick(20) == 0 ? pick(LINK_FRAME_MAX - LINK_OVERHEAD) : payload_of(type, frame + LINK_HEADER);
        n = link_close_frame(frame, type, pick(3), pick(50), n);
        n = damage(frame, n, sizeof frame);
        feed(frame, n);
        if (pick(500) == 0 && !conversation(1000u + (uint32_t)k)) {
            printf("frame %ld: the conversation after it was not met\n", k);
            return 1;
        }
    }
    printf("%ld frames, %ld answers, %u damaged\n", frames, answers, (unsigned)device.reader.damaged);
    return 0;
}
