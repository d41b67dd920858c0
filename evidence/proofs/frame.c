/* The link's frames: any bytes that come in, and any record. */
#include "frame.h"

#include "__fc_builtin.h"

enum { ROOM = 24, VALUES = 4 }; /* a frame of 6 bytes of payload at most */

extern volatile int any_integer;
extern volatile uint8_t any_byte;
volatile double seen_real;
volatile unsigned seen_integer;

typedef struct {
    double reals[VALUES];
    int32_t integers[VALUES];
    bool booleans[VALUES];
    char text[8];
} Values;

/* Of each state that the invariant allows, what a byte and the frames after it make; the invariant holds again. */
static void reader_of_any_state(void)
{
    uint8_t room[ROOM];
    LinkReader reader = {room, ROOM, 0, 0, Frama_C_unsigned_int_interval(0, UINT32_MAX), any_integer != 0};
    LinkFrame frame;
    Frama_C_make_unknown((char *)room, ROOM);
    reader.held = (size_t)Frama_C_interval(0, ROOM);
    //@ split reader.held;
    reader.taken = (size_t)Frama_C_interval(0, ROOM);
    //@ split reader.taken;
    if (reader.taken > reader.held || (reader.taken == 0 && reader.held == ROOM)) {
        return;
    }
    if (reader.taken == 0) { /* between frames a byte may come in */
        link_push(&reader, any_byte);
    }
    if (link_next(&reader, &frame)) {
        for (size_t i = 0; i < frame.size; ++i) {
            seen_integer = frame.payload[i];
        }
        seen_integer = frame.version + frame.type + frame.session + frame.sequence;
    } else {
        //@ assert room: reader.taken == 0 && reader.held < ROOM;
    }
}

static void records(uint8_t format)
{
    static const LinkField fields[] = {{offsetof(Values, reals), VALUES, LINK_IS_REAL},
                                       {offsetof(Values, integers), VALUES, LINK_IS_INTEGER},
                                       {offsetof(Values, booleans), VALUES, LINK_IS_BOOLEAN},
                                       {offsetof(Values, text), 8, LINK_IS_TEXT}};
    const LinkRecord record = {fields, sizeof fields / sizeof fields[0]};
    uint8_t bytes[VALUES * 13 + 8 + LINK_OVERHEAD];
    Values in, out;
    Frama_C_make_unknown((char *)bytes, sizeof bytes);
    link_take(&record, bytes, format, &in);
    seen_integer = in.integers[0] < 0;
    seen_integer = in.booleans[VALUES - 1] + (unsigned)in.text[7];
    for (int i = 0; i < VALUES; ++i) {
        out.reals[i] = in.reals[i];
        out.integers[i] = in.integers[i];
        out.booleans[i] = in.booleans[i];
        out.text[i] = out.text[i + 4] = 'a';
    }
    seen_integer = (unsigned)link_put(&record, &out, format, bytes + LINK_HEADER);
    seen_integer = (unsigned)link_size(&record, format);
    seen_integer = (unsigned)link_close_frame(bytes, LINK_STEP, 1u, 2u, link_size(&record, format));
    link_put_time(1.0, format, bytes);
    seen_real = link_take_time(bytes, format);
}

int main(void)
{
    records((uint8_t)Frama_C_interval(0, 3));
    reader_of_any_state();
    return 0;
}
