/* This computer as a board (Linux, macOS): `device udp PORT`, `device tcp PORT`, `device serial PATH`, `device pipe ADDRESS`.
 * PATH is a serial line or a pseudo terminal; a pipe is ADDRESS.in and ADDRESS.out, which are made where they are missing. */
#define _DEFAULT_SOURCE
#define _DARWIN_C_SOURCE
#include "board.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

static int in = -1, out = -1, listening = -1;
static struct sockaddr_in peer;
static bool datagrams;

static bool listen_at(const char *port, int kind)
{
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(port))};
    const int file = socket(AF_INET, kind, 0), on = 1;
    here.sin_addr.s_addr = htonl(INADDR_ANY);
    setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(file, (struct sockaddr *)&here, sizeof here) != 0 || (kind == SOCK_STREAM && listen(file, 1) != 0)) {
        perror(port);
        return false;
    }
    datagrams = kind == SOCK_DGRAM;
    *(datagrams ? &in : &listening) = file;
    return true;
}

static bool open_serial(const char *path)
{
    struct termios t;
    in = out = open(path, O_RDWR | O_NOCTTY);
    if (in < 0 || tcgetattr(in, &t) != 0) {
        perror(path);
        return false;
    }
    cfmakeraw(&t);
    cfsetispeed(&t, B115200);
    cfsetospeed(&t, B115200);
    return tcsetattr(in, TCSANOW, &t) == 0;
}

/* Both ends of each pipe are held, so that the device outlives those who ask it. */
static bool open_pipe(const char *address)
{
    char path[512];
    snprintf(path, sizeof path, "%s.in", address);
    mkfifo(path, 0600);
    in = open(path, O_RDWR);
    snprintf(path, sizeof path, "%s.out", address);
    mkfifo(path, 0600);
    out = open(path, O_RDWR);
    if (in < 0 || out < 0) {
        perror(path);
    }
    return in >= 0 && out >= 0;
}

bool board_begin(int count, char **arguments)
{
    const char *kind = count == 3 ? arguments[1] : "";
    const bool begun = strcmp(kind, "udp") == 0      ? listen_at(arguments[2], SOCK_DGRAM)
                       : strcmp(kind, "tcp") == 0    ? listen_at(arguments[2], SOCK_STREAM)
                       : strcmp(kind, "serial") == 0 ? open_serial(arguments[2])
                                                     : strcmp(kind, "pipe") == 0 && open_pipe(arguments[2]);
    signal(SIGPIPE, SIG_IGN);
    if (!begun) {
        fprintf(stderr, "use: %s udp PORT | tcp PORT | serial PATH | pipe ADDRESS\n", arguments[0]);
    } else {
        printf("ready\n");
        fflush(stdout);
    }
    return begun;
}

/* Bytes that have come; where a caller has hung up, those of the next one. */
static ssize_t more(uint8_t *bytes, size_t n)
{
    socklen_t size = sizeof peer;
    if (datagrams) {
        return recvfrom(in, bytes, n, 0, (struct sockaddr *)&peer, &size);
    }
    for (;;) {
        const ssize_t some = in < 0 ? 0 : read(in, bytes, n);
        if (some > 0 || listening < 0) {
            return some;
        }
        if (in >= 0) {
            close(in);
        }
        const int on = 1;
        in = out = accept(listening, NULL, NULL);
        if (in < 0) {
            return -1;
        }
        setsockopt(in, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    }
}

bool board_receive(uint8_t *byte)
{
    static uint8_t bytes[65536];
    static ssize_t count, next;
    while (next == count) {
        next = 0;
        count = more(bytes, sizeof bytes);
        if (count < 0 || (count == 0 && !datagrams)) {
            return false;
        }
    }
    *byte = bytes[next++];
    return true;
}

void board_send(void *line, const uint8_t *bytes, size_t n)
{
    (void)line;
    if (datagrams) {
        sendto(in, bytes, n, 0, (struct sockaddr *)&peer, sizeof peer);
        return;
    }
    for (size_t sent = 0; sent < n;) {
        const ssize_t some = write(out, bytes + sent, n - sent);
        if (some <= 0) {
            return; /* the other end asks again */
        }
        sent += (size_t)some;
    }
}
