/* The functions that a board must give: a byte in, bytes out. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Clock, pins, UART; `arguments` are those of a program on a computer. False where there is no line. */
bool board_begin(int count, char **arguments);

/* Waits for the next byte; false where no more can come, which ends the program. A board waits for ever. */
bool board_receive(uint8_t *byte);

/* Sends bytes; `line` is not used. */
void board_send(void *line, const uint8_t *bytes, size_t n);

#endif
