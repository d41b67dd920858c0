/* Each request is met once and answered; one that comes again has the same answer, one that comes late has none. While a run
 * uses the device, the hello of another is refused and changes nothing. */
#include "device.h"

#include <string.h>

void device_begin(Device *device, DeviceSend send, void *line, DeviceClock clock)
{
    memset(device, 0, sizeof *device);
    device->send = send;
    device->line = line;
    device->clock = clock;
    device->reader.bytes = device->received;
    device->reader.size = sizeof device->received;
}

static void answer(Device *device, const LinkFrame *request, uint8_t type, size_t payload)
{
    device->answer_size = link_close_frame(device->answer, type, request->session, request->sequence, payload);
    device->send(device->line, device->answer, device->answer_size);
}

static void put_refusal(uint8_t *payload, uint8_t code, const char *why)
{
    memset(payload, 0, LINK_REFUSAL);
    payload[0] = code;
    for (size_t i = 0; i < LINK_TEXT && why[i] != '\0'; ++i) {
        payload[1 + i] = (uint8_t)why[i];
    }
}

static void refuse(Device *device, const LinkFrame *request, uint8_t code, const char *why)
{
    put_refusal(device->answer + LINK_HEADER, code, why);
    answer(device, request, LINK_REFUSED, LINK_REFUSAL);
}

static const uint8_t *token_of(const LinkFrame *hello)
{
    static const uint8_t none[LINK_TOKEN];
    return hello->size == LINK_GREETING ? hello->payload + LINK_AT_TOKEN : none;
}

/* Whether the hello is of another run than that which uses the device. */
static bool is_strange(const Device *device, const LinkFrame *hello)
{
    return device->greeted && memcmp(device->token, token_of(hello), LINK_TOKEN) != 0 && device->clock != NULL &&
           device->clock() - device->heard < (uint32_t)(device->told ? DEVICE_LEASE : DEVICE_LEASE_OF_HELLO);
}

/* Names the run that uses the device; the answer that is kept for it stays. */
static void refuse_stranger(const Device *device, const LinkFrame *hello)
{
    static const char digits[] = "0123456789abcdef";
    char why[] = "in use by run ................; free when that ends, or 2 s after its last request";
    uint8_t frame[LINK_OVERHEAD + LINK_REFUSAL];
    for (size_t i = 0; i < LINK_TOKEN; ++i) {
        why[14 + 2 * i] = digits[device->token[i] >> 4];
        why[15 + 2 * i] = digits[device->token[i] & 15];
    }
    put_refusal(frame + LINK_HEADER, LINK_IN_USE, why);
    device->send(device->line, frame,
                 link_close_frame(frame, LINK_REFUSED, hello->session, hello->sequence, LINK_REFUSAL));
}

/* Says what this device is; whether it fits the other end decides, and this one refuses what follows where it does not. */
static void greet(Device *device, const LinkFrame *request)
{
    static const uint8_t hash[LINK_HASH] = LINK_INTERFACE_HASH;
    uint8_t *payload = device->answer + LINK_HEADER;
    const bool of_size = request->size == LINK_GREETING && request->version == LINK_VERSION;
    if (!device->greeted || request->session != device->session) {
        device->started = device->told = false;
    }
    device->greeted = true;
    device->session = request->session;
    memcpy(device->token, token_of(request), LINK_TOKEN);
    device->fits = of_size && memcmp(request->payload + 2, hash, LINK_HASH) == 0;
    device->format = of_size ? request->payload[0] & (LINK_BIG_ENDIAN | LINK_SINGLE) : 0;
    memset(payload, 0, LINK_GREETING);
    payload[0] = device->format;
    payload[1] = device->started ? LINK_STARTED : 0;
    memcpy(payload + 2, hash, LINK_HASH);
    memcpy(payload + 2 + LINK_HASH, LINK_INTERFACE, sizeof LINK_INTERFACE - 1);
    memcpy(payload + LINK_AT_TOKEN, device->token, LINK_TOKEN);
    answer(device, request, LINK_HELLO | LINK_ANSWER, LINK_GREETING);
}

/* The block's outputs for the request's times and inputs. */
static void sample(Device *device, const LinkFrame *request)
{
    const double t = link_take_time(request->payload, device->format);
    const double h = request->type == LINK_START ? 0.0 : link_take_time(request->payload + 8, device->format);
    uint8_t *payload = device->answer + LINK_HEADER;
    link_take(&link_input_fields, request->payload + 16, device->format, &device->u);
    if (request->type == LINK_START) {
        memset(&device->memory, 0, sizeof device->memory);
    }
    const char *why = block_sample(&device->p, &device->memory, &device->u, t, h, &device->y);
    if (why != NULL) {
        refuse(device, request, LINK_BLOCK_REFUSES, why);
        return;
    }
    device->started = true;
    link_put_time(t + h, device->format, payload);
    answer(device, request, request->type | LINK_ANSWER,
           8 + link_put(&link_output_fields, &device->y, device->format, payload + 8));
}

static size_t expected_size(const Device *device, uint8_t type)
{
    return type == LINK_PARAMETERS ? link_size(&link_parameter_fields, device->format)
                                   : 16 + link_size(&link_input_fields, device->format);
}

static void meet(Device *device, const LinkFrame *request)
{
    if (!device->greeted || (request->type == LINK_STEP && !device->started) ||
        (request->type == LINK_START && !device->told)) {
        refuse(device, request, LINK_NOT_STARTED, "not started");
    } else if (!device->fits) {
        refuse(device, request, LINK_OTHER_INTERFACE, "built for the interface " LINK_INTERFACE);
    } else if (request->size != expected_size(device, request->type)) {
        refuse(device, request, LINK_WRONG_SIZE, "another number of bytes than the interface has");
    } else if (request->type == LINK_PARAMETERS) {
        link_take(&link_parameter_fields, request->payload, device->format, &device->p);
        device->told = true;
        answer(device, request, LINK_PARAMETERS | LINK_ANSWER, 0);
    } else {
        sample(device, request);
    }
}

/* Whether a request is to be met. One of another session than the device's is late, unless it begins one; before the first
 * greeting each is met, since who asks must learn that this device knows nothing. */
static bool is_new(Device *device, const LinkFrame *request)
{
    if (request->type < LINK_HELLO || request->type > LINK_END) {
        return false;
    }
    if (!device->greeted || request->session != device->session) {
        return !device->greeted || request->type == LINK_HELLO;
    }
    if (request->sequence == device->sequence) {
        device->send(device->line, device->answer, device->answer_size);
    }
    return request->sequence > device->sequence;
}

void device_turn(Device *device)
{
    device->reader.held = device->reader.taken = 0;
}

void device_receive(Device *device, uint8_t byte)
{
    LinkFrame request;
    link_push(&device->reader, byte);
    while (link_next(&device->reader, &request)) {
        if (!is_new(device, &request)) {
            continue;
        }
        if (request.type == LINK_HELLO && is_strange(device, &request)) {
            refuse_stranger(device, &request);
            continue;
        }
        if (request.type == LINK_END) {
            device->greeted = device->started = device->told = false;
        } else if (request.type == LINK_HELLO) {
            greet(device, &request);
        } else {
            meet(device, &request);
        }
        device->sequence = request.sequence;
        device->heard = device->clock != NULL ? device->clock() : 0;
    }
}
