/* Frames: two marking bytes, version, type, session, sequence number, size, payload, CRC-32; and the values in payloads. */
#include "frame.h"

#include <string.h>

_Static_assert(sizeof(double) == 8 && sizeof(float) == 4, "the link needs IEEE 754 numbers of 8 and 4 bytes");

static const uint8_t MARK[2] = {0xA5, 0x5A};

/* By half bytes: 64 bytes of constants. */
uint32_t link_crc(const uint8_t *bytes, size_t n)
{
    static const uint32_t table[16] = {0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u,
                                       0x4DB26158u, 0x5005713Cu, 0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu,
                                       0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < n; ++i) {
        crc ^= bytes[i];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return ~crc;
}

/* An unsigned number of n bytes, the lowest byte first unless `big`. */
static void put_number(uint64_t value, size_t n, bool big, uint8_t *to)
{
    for (size_t i = 0; i < n; ++i) {
        to[big ? n - 1 - i : i] = (uint8_t)((value >> (8 * i)) & 0xFFu);
    }
}

static uint64_t take_number(const uint8_t *from, size_t n, bool big)
{
    uint64_t value = 0;
    for (size_t i = 0; i < n; ++i) {
        value |= (uint64_t)from[big ? n - 1 - i : i] << (8 * i);
    }
    return value;
}

void link_push(LinkReader *reader, uint8_t byte)
{
    if (reader->held < reader->size) { /* link_next leaves room: it keeps less than the longest frame */
        reader->bytes[reader->held++] = byte;
    }
}

static void drop(LinkReader *reader, size_t n)
{
    reader->held -= n;
    for (size_t i = 0; n > 0 && i < reader->held; ++i) {
        reader->bytes[i] = reader->bytes[i + n];
    }
}

/* How many bytes at the front are of no frame: up to the first that may be a mark. */
static size_t up_to_mark(const LinkReader *reader, size_t from)
{
    size_t n = from;
    while (n < reader->held &&
           !(reader->bytes[n] == MARK[0] && (n + 1 == reader->held || reader->bytes[n + 1] == MARK[1]))) {
        ++n;
    }
    return n;
}

static void skip(LinkReader *reader, size_t from)
{
    const size_t n = up_to_mark(reader, from);
    reader->damaged += n > 0 && !reader->skipping;
    reader->skipping = reader->skipping || n > 0;
    drop(reader, n);
}

bool link_next(LinkReader *reader, LinkFrame *frame)
{
    drop(reader, reader->taken);
    reader->taken = 0;
    for (;;) {
        skip(reader, 0);
        const uint8_t *bytes = reader->bytes;
        if (reader->held < LINK_HEADER) {
            return false;
        }
        const size_t payload = (size_t)take_number(bytes + 12, 2, false), whole = payload + LINK_OVERHEAD;
        if (whole <= reader->size && reader->held < whole) {
            return false;
        }
        if (whole <= reader->size &&
            link_crc(bytes + 2, whole - LINK_CHECK - 2) == take_number(bytes + whole - LINK_CHECK, LINK_CHECK, false)) {
            *frame = (LinkFrame){.version = bytes[2],
                                 .type = bytes[3],
                                 .session = (uint32_t)take_number(bytes + 4, 4, false),
                                 .sequence = (uint32_t)take_number(bytes + 8, 4, false),
                                 .size = (uint16_t)payload,
                                 .payload = bytes + LINK_HEADER};
            //@ assert whole: LINK_OVERHEAD <= whole <= reader->held;
            reader->taken = whole;
            reader->skipping = false;
            return true;
        }
        skip(reader, 1); /* a true mark may stand within what looked like a frame */
    }
}

size_t link_close_frame(uint8_t *frame, uint8_t type, uint32_t session, uint32_t sequence, size_t payload)
{
    const size_t checked = LINK_HEADER + payload;
    memcpy(frame, MARK, sizeof MARK);
    frame[2] = LINK_VERSION;
    frame[3] = type;
    put_number(session, 4, false, frame + 4);
    put_number(sequence, 4, false, frame + 8);
    put_number(payload, 2, false, frame + 12);
    put_number(link_crc(frame + 2, checked - 2), LINK_CHECK, false, frame + checked);
    return checked + LINK_CHECK;
}

static size_t size_of(const LinkField *field, uint8_t format)
{
    switch (field->kind) {
    case LINK_IS_REAL:
        return (size_t)field->count * ((format & LINK_SINGLE) != 0 ? 4u : 8u);
    case LINK_IS_INTEGER:
        return (size_t)field->count * 4u;
    default: /* a byte each */
        return field->count;
    }
}

size_t link_size(const LinkRecord *record, uint8_t format)
{
    size_t size = 0;
    for (size_t i = 0; i < record->n; ++i) {
        size += size_of(&record->fields[i], format);
    }
    return size;
}

static void put_real(double value, uint8_t format, uint8_t *to)
{
    const float single = (float)value;
    uint64_t bits;
    uint32_t few;
    memcpy(&bits, &value, sizeof bits);
    memcpy(&few, &single, sizeof few);
    const bool shorter = (format & LINK_SINGLE) != 0;
    put_number(shorter ? few : bits, shorter ? 4 : 8, (format & LINK_BIG_ENDIAN) != 0, to);
}

static double take_real(const uint8_t *from, uint8_t format)
{
    const bool shorter = (format & LINK_SINGLE) != 0;
    const uint64_t bits = take_number(from, shorter ? 4 : 8, (format & LINK_BIG_ENDIAN) != 0);
    const uint32_t few = (uint32_t)(bits & UINT32_MAX);
    double value;
    float single;
    memcpy(&value, &bits, sizeof value);
    memcpy(&single, &few, sizeof single);
    return shorter ? (double)single : value;
}

void link_put_time(double t, uint8_t format, uint8_t *to)
{
    put_real(t, format & LINK_BIG_ENDIAN, to);
}

double link_take_time(const uint8_t *from, uint8_t format)
{
    return take_real(from, format & LINK_BIG_ENDIAN);
}

static void put_element(const LinkField *field, const unsigned char *from, size_t i, uint8_t format, uint8_t *to)
{
    double real;
    uint32_t integer; /* with the bits of an int32_t */
    bool boolean;
    switch (field->kind) {
    case LINK_IS_REAL:
        memcpy(&real, from + i * sizeof real, sizeof real);
        put_real(real, format, to);
        break;
    case LINK_IS_INTEGER:
        memcpy(&integer, from + i * sizeof integer, sizeof integer);
        put_number(integer, 4, (format & LINK_BIG_ENDIAN) != 0, to);
        break;
    case LINK_IS_BOOLEAN:
        memcpy(&boolean, from + i * sizeof boolean, sizeof boolean);
        *to = boolean;
        break;
    default:
        *to = from[i];
        break;
    }
}

static void take_element(const LinkField *field, const uint8_t *from, uint8_t format, unsigned char *to, size_t i)
{
    double real;
    uint32_t integer;
    bool boolean;
    switch (field->kind) {
    case LINK_IS_REAL:
        real = take_real(from, format);
        memcpy(to + i * sizeof real, &real, sizeof real);
        break;
    case LINK_IS_INTEGER:
        integer = (uint32_t)take_number(from, 4, (format & LINK_BIG_ENDIAN) != 0);
        memcpy(to + i * sizeof integer, &integer, sizeof integer);
        break;
    case LINK_IS_BOOLEAN:
        boolean = *from != 0;
        memcpy(to + i * sizeof boolean, &boolean, sizeof boolean);
        break;
    default: /* the last byte of a text is a zero, whatever came */
        to[i] = i + 1 < field->count ? *from : 0;
        break;
    }
}

size_t link_put(const LinkRecord *record, const void *from, uint8_t format, uint8_t *to)
{
    const uint8_t *const start = to;
    for (size_t k = 0; k < record->n; ++k) {
        const LinkField *field = &record->fields[k];
        const size_t each = size_of(field, format) / field->count;
        for (size_t i = 0; i < field->count; ++i, to += each) {
            put_element(field, (const unsigned char *)from + field->offset, i, format, to);
        }
    }
    return (size_t)(to - start);
}

void link_take(const LinkRecord *record, const uint8_t *from, uint8_t format, void *to)
{
    for (size_t k = 0; k < record->n; ++k) {
        const LinkField *field = &record->fields[k];
        const size_t each = size_of(field, format) / field->count;
        for (size_t i = 0; i < field->count; ++i, from += each) {
            take_element(field, from, format, (unsigned char *)to + field->offset, i);
        }
    }
}
