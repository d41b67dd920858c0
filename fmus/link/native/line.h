/* The line to a device: UDP, TCP, a serial line or a pipe. Times are in s of a monotonic clock. */
#ifndef LINK_LINE_H
#define LINK_LINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The items of link_transport, in their order. */
typedef enum { LINE_UDP = 1, LINE_TCP, LINE_SERIAL, LINE_PIPE } Transport;

typedef struct {
    Transport transport;
    intptr_t in, out; /* of the operating system; the same but for a pipe */
    bool open;
} Line;

enum { LINE_HOST = 256 }; /* chars of a host, its end included */

/* Opens a line within the time; false with a reason of the operating system or of this code.
 *
 * address: HOST:PORT of UDP and TCP, the device of a serial line (/dev/ttyUSB0, COM3), or a pipe. A pipe is what QEMU calls
 * so: two named pipes, ADDRESS.in to the device and ADDRESS.out from it; on Windows one, such as \\.\pipe\name. */
bool line_open(Line *line, Transport transport, const char *address, int baud, double wait, char *reason, size_t size);

/* Sends all bytes; false where the line is closed at the other end or does not take them in time. */
bool line_send(Line *line, const uint8_t *bytes, size_t n, double until);

/* Some bytes that have come, at most n; 0 where none come until then, -1 where the line is closed at the other end. */
int line_receive(Line *line, uint8_t *bytes, size_t n, double until);

void line_close(Line *line);

/* The monotonic clock. */
double line_now(void);

void line_sleep(double seconds);

/* Splits HOST:PORT, or [HOST]:PORT for IPv6; false where there is no port from 1 to 65535 or the host is too long. */
bool line_split(const char *address, char *host, size_t size, const char **port);

bool line_is_host_port(const char *address);

#endif
