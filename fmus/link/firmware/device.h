/* The device's end of the link: bytes in, bytes out. No heap, no operating system; all memory is in Device.
 * Not to be changed; the block itself is in block_sample, which block.h names. */
#ifndef DEVICE_H
#define DEVICE_H

#include "block.h"
#include "wire.h"

/* ms after a run's last request from which another run may take the device; the first, where that has told no parameters. */
enum { DEVICE_LEASE_OF_HELLO = 200, DEVICE_LEASE = 2000 };

/* Any clock, in ms; it may begin again at 0 after its largest number. */
typedef uint32_t (*DeviceClock)(void);

/* Sends bytes to the line. */
typedef void (*DeviceSend)(void *line, const uint8_t *bytes, size_t n);

typedef struct {
    DeviceSend send;
    void *line;
    DeviceClock clock;         /* NULL: a line with one other end, where a hello always begins a run */
    uint32_t heard;            /* by the clock, when the last request of the run came */
    uint8_t token[LINK_TOKEN]; /* of the run */
    LinkReader reader;
    uint8_t received[LINK_FRAME_MAX], answer[LINK_FRAME_MAX];
    size_t answer_size;         /* of the last answer, which is sent again when its request comes again */
    uint32_t session, sequence; /* of the last request that was met */
    uint8_t format;
    bool greeted, fits, told, started;
    Parameters p;
    Inputs u;
    Outputs y;
    Memory memory;
} Device;

/* After power-up. */
void device_begin(Device *device, DeviceSend send, void *line, DeviceClock clock);

/* The next byte comes in another datagram, or from another sender: it ends no frame that was begun before. */
void device_turn(Device *device);

/* A byte from the line. Answers a request when its last byte is in. */
void device_receive(Device *device, uint8_t byte);

#endif
