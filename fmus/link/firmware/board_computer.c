/* This computer as a board (Linux, macOS): `device udp PORT`, `device tcp PORT`, `device serial PATH`, `device pipe ADDRESS`.
 * PATH is a serial line or a pseudo terminal; a pipe is ADDRESS.in and ADDRESS.out, which are made where they are missing.
 * UDP and TCP listen at 127.0.0.1; `--listen 0.0.0.0` behind the port: at all addresses of this computer. */
#define _DEFAULT_SOURCE
#define _DARWIN_C_SOURCE
#include "board.h"
#include "frame.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

enum { CALLERS = 8 }; /* by TCP at the same time; one more takes the place of the one that has been quiet longest */

static int in = -1, out = -1, listening = -1;
static struct sockaddr_in peer;
static bool datagrams;
static struct {
    int file;
    uint32_t heard;
    struct sockaddr_in address;
} callers[CALLERS];

static uint32_t milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint32_t)((uint64_t)t.tv_sec * 1000u + (uint64_t)t.tv_nsec / 1000000u);
}

uint32_t (*const board_clock)(void) = milliseconds;

static bool listen_at(const char *address, const char *port, int kind)
{
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(port))};
    const int file = socket(AF_INET, kind, 0), on = 1;
    if (inet_pton(AF_INET, address, &here.sin_addr) != 1) {
        fprintf(stderr, "--listen: expected an address such as 0.0.0.0, found %s\n", address);
        return false;
    }
    setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(file, (struct sockaddr *)&here, sizeof here) != 0 || (kind == SOCK_STREAM && listen(file, 8) != 0)) {
        perror(port);
        return false;
    }
    datagrams = kind == SOCK_DGRAM;
    *(datagrams ? &in : &listening) = file;
    for (size_t i = 0; i < CALLERS; ++i) {
        callers[i].file = -1;
    }
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
    const bool elsewhere = count == 5 && strcmp(arguments[3], "--listen") == 0;
    const char *kind = count == 3 || elsewhere ? arguments[1] : "";
    const char *address = elsewhere ? arguments[4] : "127.0.0.1";
    const bool begun = strcmp(kind, "udp") == 0      ? listen_at(address, arguments[2], SOCK_DGRAM)
                       : strcmp(kind, "tcp") == 0    ? listen_at(address, arguments[2], SOCK_STREAM)
                       : strcmp(kind, "serial") == 0 ? open_serial(arguments[2])
                                                     : strcmp(kind, "pipe") == 0 && open_pipe(arguments[2]);
    signal(SIGPIPE, SIG_IGN);
    if (!begun) {
        fprintf(stderr, "use: %s udp PORT [--listen ADDRESS] | tcp PORT [--listen ADDRESS] | serial PATH | pipe NAME\n",
                arguments[0]);
    } else {
        printf("ready\n");
        fflush(stdout);
    }
    return begun;
}

static void take_caller(void)
{
    const int on = 1;
    socklen_t size = sizeof peer;
    size_t place = 0;
    for (size_t i = 1; i < CALLERS && callers[place].file >= 0; ++i) {
        const bool quieter = (int32_t)(callers[place].heard - callers[i].heard) > 0;
        place = callers[i].file < 0 || quieter ? i : place;
    }
    if (callers[place].file >= 0) {
        close(callers[place].file);
    }
    const int file = accept(listening, (struct sockaddr *)&callers[place].address, &size);
    callers[place].file = file;
    callers[place].heard = milliseconds();
    if (file >= 0) {
        setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK);
    }
}

/* Bytes of the caller that has sent some. */
static ssize_t of_a_caller(uint8_t *bytes, size_t n, bool *turned)
{
    for (;;) {
        struct pollfd files[CALLERS + 1] = {{.fd = listening, .events = POLLIN}};
        for (size_t i = 0; i < CALLERS; ++i) {
            files[i + 1] = (struct pollfd){.fd = callers[i].file, .events = POLLIN};
        }
        if (poll(files, CALLERS + 1, -1) < 0) {
            return -1;
        }
        for (size_t i = 0; i < CALLERS; ++i) {
            const ssize_t some = files[i + 1].revents != 0 ? read(callers[i].file, bytes, n) : -2;
            if (some > 0) {
                *turned = out != callers[i].file;
                out = callers[i].file;
                peer = callers[i].address;
                callers[i].heard = milliseconds();
                return some;
            }
            if (some == 0 || some == -1) {
                close(callers[i].file);
                out = out == callers[i].file ? -1 : out;
                callers[i].file = -1;
            }
        }
        if (files[0].revents != 0) {
            take_caller();
        }
    }
}

bool board_receive(uint8_t *byte, bool *turned)
{
    static uint8_t bytes[65536];
    static ssize_t count, next;
    *turned = false;
    while (next == count) {
        socklen_t size = sizeof peer;
        next = 0;
        count = datagrams        ? recvfrom(in, bytes, sizeof bytes, 0, (struct sockaddr *)&peer, &size)
                : listening >= 0 ? of_a_caller(bytes, sizeof bytes, turned)
                                 : read(in, bytes, sizeof bytes);
        *turned = *turned || datagrams;
        if (count < 0 || (count == 0 && !datagrams)) {
            return false;
        }
    }
    *byte = bytes[next++];
    return true;
}

/* Names one that is refused because another run uses the device. */
static void name_stranger(const uint8_t *frame)
{
    static struct sockaddr_in last;
    char text[INET_ADDRSTRLEN] = "another program";
    if (frame[3] != LINK_REFUSED || frame[LINK_HEADER] != LINK_IN_USE || memcmp(&last, &peer, sizeof peer) == 0) {
        return;
    }
    last = peer;
    if (datagrams || listening >= 0) {
        inet_ntop(AF_INET, &peer.sin_addr, text, sizeof text);
    }
    fprintf(stderr, "refused %s:%d: %.*s\n", text, ntohs(peer.sin_port), LINK_TEXT,
            (const char *)frame + LINK_HEADER + 1);
}

void board_send(void *line, const uint8_t *bytes, size_t n)
{
    (void)line;
    name_stranger(bytes);
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
