/* Frames of the link's protocol and the values in them; the same code at both ends (docs/use/link-protocol.md).
 * No heap, no operating system, no globals that are written to. */
#ifndef LINK_FRAME_H
#define LINK_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LINK_VERSION = 2, LINK_HEADER = 14, LINK_CHECK = 4, LINK_OVERHEAD = LINK_HEADER + LINK_CHECK };

/* Of a request. Its answer has the same with LINK_ANSWER added, or is LINK_REFUSED; LINK_END has none. */
enum { LINK_HELLO = 1, LINK_PARAMETERS = 2, LINK_START = 3, LINK_STEP = 4, LINK_END = 5 };
enum { LINK_ANSWER = 0x80, LINK_REFUSED = 0xFF };

/* The first byte of the payload of LINK_REFUSED; text of LINK_TEXT bytes follows, filled with zeros. */
enum { LINK_NOT_STARTED = 1, LINK_OTHER_INTERFACE = 2, LINK_WRONG_SIZE = 3, LINK_BLOCK_REFUSES = 4, LINK_IN_USE = 5 };
enum { LINK_TEXT = 96, LINK_REFUSAL = 1 + LINK_TEXT };

/* Payload of LINK_HELLO: format, state, hash of the interface, its name filled with zeros, token of the run. */
enum { LINK_HASH = 8, LINK_NAME = 32, LINK_TOKEN = 8, LINK_AT_TOKEN = 2 + LINK_HASH + LINK_NAME };
enum { LINK_GREETING = LINK_AT_TOKEN + LINK_TOKEN };
enum { LINK_BIG_ENDIAN = 1, LINK_SINGLE = 2 }; /* bits of the format: of the values in a payload */
enum { LINK_STARTED = 1 };                     /* a bit of the state */

typedef struct {
    uint8_t version, type;
    uint16_t size; /* of the payload */
    uint32_t session, sequence;
    const uint8_t *payload;
} LinkFrame;

/* Finds frames in a stream of bytes, whatever stands between them. */
typedef struct {
    uint8_t *bytes; /* room for the longest frame */
    size_t size, held;
    size_t taken;     /* of the frame that was returned last; its bytes go with the next call */
    uint32_t damaged; /* frames whose check failed, and runs of bytes that are of no frame */
    bool skipping;
} LinkReader;

/* A byte that has come in. Call link_next until it returns false after each. */
void link_push(LinkReader *reader, uint8_t byte);

/* The next whole frame; its payload stays until the next call. */
bool link_next(LinkReader *reader, LinkFrame *frame);

/* Puts header and check round the payload that stands at frame + LINK_HEADER; the number of bytes. */
size_t link_close_frame(uint8_t *frame, uint8_t type, uint32_t session, uint32_t sequence, size_t payload);

/* CRC-32 as in Ethernet and zip: polynomial 0x04C11DB7 reflected, start and end 0xFFFFFFFF. */
uint32_t link_crc(const uint8_t *bytes, size_t n);

typedef enum { LINK_IS_REAL, LINK_IS_INTEGER, LINK_IS_BOOLEAN, LINK_IS_TEXT } LinkKind;

/* A variable of the interface: `count` elements side by side in a structure; for text the size of its buffer. */
typedef struct {
    uint16_t offset, count;
    uint8_t kind;
} LinkField;

typedef struct {
    const LinkField *fields;
    size_t n;
} LinkRecord;

/* Bytes of a record in this format. */
size_t link_size(const LinkRecord *record, uint8_t format);

/* Writes the values of a structure; the number of bytes. */
size_t link_put(const LinkRecord *record, const void *from, uint8_t format, uint8_t *to);

/* Reads the values of a structure from link_size bytes. */
void link_take(const LinkRecord *record, const uint8_t *from, uint8_t format, void *to);

/* A time: always 8 bytes. */
void link_put_time(double t, uint8_t format, uint8_t *to);
double link_take_time(const uint8_t *from, uint8_t format);

#endif
