/* The functions that a board must give: a byte in, bytes out. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Clock, pins, UART; `arguments` are those of a program on a computer. False where there is no line. */
bool board_begin(int count, char **arguments);

/* Waits for the next byte; false where no more can come, which ends the program. A board waits for ever. `turned`: the byte
 * is the first of a datagram, or of another sender than that before. */
bool board_receive(uint8_t *byte, bool *turned);

/* Sends bytes to the sender of the last byte; `line` is not used. */
void board_send(void *line, const uint8_t *bytes, size_t n);

/* A clock in ms, by which a run that is killed frees the device for the next; NULL on a line with one other end. */
extern uint32_t (*const board_clock)(void);

#endif
