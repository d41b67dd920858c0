/* The line to a device on Linux and macOS. */
#define _DEFAULT_SOURCE
#define _DARWIN_C_SOURCE
#include "line.h"
#include "serial.h"

#ifndef _WIN32

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#ifdef MSG_NOSIGNAL
enum { NO_SIGNAL = MSG_NOSIGNAL };
#else
enum { NO_SIGNAL = 0 }; /* macOS has an option of the socket instead */
#endif

double line_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void line_sleep(double seconds)
{
    struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

/* Waits for an event of a file; false where there is none until then. A little longer than asked for at most. */
static bool wait_for(int file, short event, double until)
{
    struct pollfd one = {file, event, 0};
    int left;
    do {
        const double seconds = until - line_now();
        left = seconds <= 0.0 ? 0 : seconds > 1e6 ? 1000000000 : (int)(1e3 * seconds) + 1;
        if (poll(&one, 1, left) > 0) {
            return true;
        }
    } while (left > 0 && line_now() < until);
    return false;
}

static bool failed(char *reason, size_t size, const char *text)
{
    strncpy(reason, text, size - 1);
    reason[size - 1] = '\0';
    return false;
}

/* Connects a socket; its file, or -1 with errno. */
static int connected(const struct addrinfo *to, double until)
{
    const int file = socket(to->ai_family, to->ai_socktype, to->ai_protocol);
    int error = 0, one = 1;
    socklen_t size = sizeof error;
    if (file < 0) {
        return -1;
    }
    fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK);
    fcntl(file, F_SETFD, FD_CLOEXEC);
#ifdef SO_NOSIGPIPE
    setsockopt(file, SOL_SOCKET, SO_NOSIGPIPE, &one, sizeof one);
#endif
    if (to->ai_socktype == SOCK_STREAM) {
        setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    }
    if (connect(file, to->ai_addr, to->ai_addrlen) == 0) {
        return file;
    }
    error = errno;
    if (error == EINPROGRESS) {
        error = ETIMEDOUT;
        if (wait_for(file, POLLOUT, until)) {
            getsockopt(file, SOL_SOCKET, SO_ERROR, &error, &size);
        }
    }
    if (error == 0) {
        return file;
    }
    close(file);
    errno = error;
    return -1;
}

/* A device that is started at the same time may not listen yet: tries again until the time is over. */
static bool open_socket(Line *line, const char *address, double until, char *reason, size_t size)
{
    char host[LINE_HOST];
    const char *port;
    const int kind = line->transport == LINE_UDP ? SOCK_DGRAM : SOCK_STREAM;
    struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = kind}, *list = NULL;
    if (!line_split(address, host, sizeof host, &port)) {
        return failed(reason, size, "expected HOST:PORT with a port from 1 to 65535");
    }
    const int error = getaddrinfo(host, port, &hints, &list);
    if (error != 0) {
        return failed(reason, size, gai_strerror(error));
    }
    int file = -1;
    for (;;) {
        for (const struct addrinfo *to = list; to != NULL && file < 0; to = to->ai_next) {
            file = connected(to, until);
        }
        if (file >= 0 || line_now() >= until) {
            break;
        }
        line_sleep(0.02);
    }
    const int why = errno;
    freeaddrinfo(list);
    line->in = line->out = file;
    return file >= 0 || failed(reason, size, strerror(why));
}

static bool open_serial(Line *line, const char *address, int baud, char *reason, size_t size)
{
    const int file = open(address, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0 || !serial_set(file, baud)) {
        failed(reason, size, strerror(errno));
        if (file >= 0) {
            close(file);
        }
        return false;
    }
    line->in = line->out = file;
    return true;
}

/* Both ends of each named pipe are held, so that no reader or writer elsewhere is waited for and none ends this program. */
static bool open_pipe(Line *line, const char *address, char *reason, size_t size)
{
    const size_t n = strlen(address);
    char path[512];
    if (n + 5 > sizeof path) {
        return failed(reason, size, "the address is too long");
    }
    memcpy(path, address, n);
    memcpy(path + n, ".in", 4);
    const int out = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    memcpy(path + n, ".out", 5);
    const int in = out < 0 ? -1 : open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (in < 0) {
        failed(reason, size, strerror(errno));
        if (out >= 0) {
            close(out);
        }
        return false;
    }
    line->in = in;
    line->out = out;
    return true;
}

bool line_open(Line *line, Transport transport, const char *address, int baud, double wait, char *reason, size_t size)
{
    line->transport = transport;
    line->open = transport == LINE_SERIAL ? open_serial(line, address, baud, reason, size)
                 : transport == LINE_PIPE ? open_pipe(line, address, reason, size)
                                          : open_socket(line, address, line_now() + wait, reason, size);
    return line->open;
}

/* An error that a later attempt may not meet. That nobody listens at a UDP port is one: the device may start later. */
static bool passing(const Line *line)
{
    return errno == EAGAIN || errno == EINTR ||
           (line->transport == LINE_UDP && (errno == ECONNREFUSED || errno == ENOBUFS));
}

bool line_send(Line *line, const uint8_t *bytes, size_t n, double until)
{
    const bool is_socket = line->transport == LINE_UDP || line->transport == LINE_TCP;
    const int file = (int)line->out;
    for (size_t sent = 0; sent < n;) {
        const ssize_t some =
            is_socket ? send(file, bytes + sent, n - sent, NO_SIGNAL) : write(file, bytes + sent, n - sent);
        if (some > 0) {
            sent += (size_t)some;
        } else if (some < 0 && !passing(line)) {
            return false;
        } else if (errno == ECONNREFUSED) {
            return true; /* told of an earlier datagram; this one is lost, too */
        } else if (!wait_for(file, POLLOUT, until)) {
            return false;
        }
    }
    return true;
}

int line_receive(Line *line, uint8_t *bytes, size_t n, double until)
{
    const int file = (int)line->in;
    bool ready = line->transport == LINE_TCP; /* where nothing is read then, the other end is gone */
    do {
        const ssize_t some = read(file, bytes, n);
        if (some > 0) {
            return (int)some;
        }
        if ((some == 0 && ready) || (some < 0 && !passing(line))) {
            return -1;
        }
        ready = line->transport != LINE_UDP;
    } while (wait_for(file, POLLIN, until) && line_now() <= until);
    return 0;
}

void line_close(Line *line)
{
    if (line->open) {
        close((int)line->in);
        if (line->out != line->in) {
            close((int)line->out);
        }
    }
    line->open = false;
}
#endif
