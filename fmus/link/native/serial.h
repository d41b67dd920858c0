/* The settings of a serial line. */
#ifndef LINK_SERIAL_H
#define LINK_SERIAL_H

#include <stdbool.h>

/* Bytes as they are, at this many bits per second; false with errno where the line has no such settings. */
bool serial_set(int file, int baud);

#endif
