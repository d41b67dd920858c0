/* A device: it waits for bytes, and answers. The same on every board; board_*.c has what is the board's own. */
#include "board.h"
#include "device.h"

int main(int count, char **arguments)
{
    static Device device; /* not on the stack, which is small on a board */
    uint8_t byte;
    bool turned = false;
    if (!board_begin(count, arguments)) {
        return 1;
    }
    device_begin(&device, board_send, NULL, board_clock);
    while (board_receive(&byte, &turned)) {
        if (turned) {
            device_turn(&device);
        }
        device_receive(&device, byte);
    }
    return 0;
}
