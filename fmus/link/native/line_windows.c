/* The line to a device on Windows: Winsock, a COM port, a named pipe.
 * Longer than 250 lines: the four kinds of line share how they wait, send and receive. */
#include "line.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <winsock2.h>
#include <ws2tcpip.h>
#include <windows.h>

#include <string.h>

double line_now(void)
{
    LARGE_INTEGER count, per_second;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&per_second);
    return (double)count.QuadPart / (double)per_second.QuadPart;
}

void line_sleep(double seconds)
{
    Sleep((DWORD)(1e3 * seconds) + 1);
}

static bool failed(char *reason, size_t size, const char *text)
{
    const size_t n = strlen(text) < size ? strlen(text) : size - 1;
    memcpy(reason, text, n);
    reason[n] = '\0';
    return false;
}

/* With the number of the error, as in Microsoft's tables. */
static bool failed_with(char *reason, size_t size, DWORD error)
{
    char text[] = "Windows error 00000";
    for (size_t k = sizeof text - 2; error > 0 && text[k] != ' '; --k, error /= 10) {
        text[k] = (char)('0' + error % 10);
    }
    return failed(reason, size, text);
}

/* Waits until a socket can be read or written; false where it cannot until then. */
static bool wait_for(SOCKET s, bool to_write, double until)
{
    double left = until - line_now();
    left = left < 0.0 ? 0.0 : left > 1e6 ? 1e6 : left;
    struct timeval time = {(long)left, (long)(1e6 * (left - (double)(long)left))};
    fd_set wanted, broken;
    FD_ZERO(&wanted);
    FD_ZERO(&broken);
    FD_SET(s, &wanted);
    FD_SET(s, &broken);
    return select(0, to_write ? NULL : &wanted, to_write ? &wanted : NULL, &broken, &time) > 0;
}

static SOCKET connected(const struct addrinfo *to, double until, DWORD *why)
{
    const SOCKET s = socket(to->ai_family, to->ai_socktype, to->ai_protocol);
    u_long on = 1;
    int error = 0, size = sizeof error;
    if (s == INVALID_SOCKET) {
        *why = (DWORD)WSAGetLastError();
        return s;
    }
    ioctlsocket(s, (long)FIONBIO, &on);
    if (to->ai_socktype == SOCK_STREAM) {
        setsockopt(s, IPPROTO_TCP, TCP_NODELAY, (const char *)&on, sizeof on);
    }
    if (connect(s, to->ai_addr, (int)to->ai_addrlen) == 0) {
        return s;
    }
    error = WSAGetLastError();
    if (error == WSAEWOULDBLOCK) {
        error = WSAETIMEDOUT;
        if (wait_for(s, true, until)) {
            getsockopt(s, SOL_SOCKET, SO_ERROR, (char *)&error, &size);
        }
    }
    if (error == 0) {
        return s;
    }
    closesocket(s);
    *why = (DWORD)error;
    return INVALID_SOCKET;
}

/* A device that is started at the same time may not listen yet: tries again until the time is over. */
static bool open_socket(Line *line, const char *address, double until, char *reason, size_t size)
{
    char host[LINE_HOST];
    const char *port;
    const int kind = line->transport == LINE_UDP ? SOCK_DGRAM : SOCK_STREAM;
    struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = kind}, *list = NULL;
    WSADATA data;
    if (!line_split(address, host, sizeof host, &port)) {
        return failed(reason, size, "expected HOST:PORT with a port from 1 to 65535");
    }
    if (WSAStartup(MAKEWORD(2, 2), &data) != 0) {
        return failed(reason, size, "Winsock does not start");
    }
    DWORD error = (DWORD)getaddrinfo(host, port, &hints, &list);
    SOCKET s = INVALID_SOCKET;
    for (bool again = error == 0; again;) {
        for (const struct addrinfo *to = list; to != NULL && s == INVALID_SOCKET; to = to->ai_next) {
            s = connected(to, until, &error);
        }
        again = s == INVALID_SOCKET && line_now() < until;
        if (again) {
            line_sleep(0.02);
        }
    }
    if (list != NULL) {
        freeaddrinfo(list);
    }
    line->in = line->out = (intptr_t)s;
    if (s == INVALID_SOCKET) {
        WSACleanup();
        return failed_with(reason, size, error);
    }
    return true;
}

/* A COM port, 8 bits without parity, or a named pipe. COM10 and above need the prefix, and the others may have it. */
static bool open_file(Line *line, const char *address, int baud, double until, char *reason, size_t size)
{
    char path[300] = "\\\\.\\";
    const size_t n = strlen(address), from = address[0] == '\\' ? 0 : 4;
    if (from + n >= sizeof path) {
        return failed(reason, size, "the address is too long");
    }
    memcpy(path + from, address, n + 1);
    HANDLE file;
    do {
        file = CreateFileA(path, GENERIC_READ | GENERIC_WRITE, 0, NULL, OPEN_EXISTING, 0, NULL);
    } while (file == INVALID_HANDLE_VALUE && GetLastError() == ERROR_PIPE_BUSY && line_now() < until);
    if (file == INVALID_HANDLE_VALUE) {
        return failed_with(reason, size, GetLastError());
    }
    line->in = line->out = (intptr_t)file;
    if (line->transport == LINE_PIPE) {
        DWORD mode = PIPE_NOWAIT; /* a device that does not read must not hold the run */
        SetNamedPipeHandleState(file, &mode, NULL, NULL);
    } else {
        DCB state;
        COMMTIMEOUTS times = {MAXDWORD, 0, 0, 0, 1000}; /* a read returns at once with what there is */
        memset(&state, 0, sizeof state);
        state.DCBlength = sizeof state;
        bool set = GetCommState(file, &state) != 0;
        state.BaudRate = (DWORD)baud;
        state.fBinary = TRUE;
        state.fParity = FALSE;
        state.fOutxCtsFlow = state.fOutxDsrFlow = state.fDsrSensitivity = state.fOutX = state.fInX = FALSE;
        state.fNull = state.fAbortOnError = FALSE;
        state.fDtrControl = DTR_CONTROL_ENABLE;
        state.fRtsControl = RTS_CONTROL_ENABLE;
        state.ByteSize = 8;
        state.Parity = NOPARITY;
        state.StopBits = ONESTOPBIT;
        set = set && SetCommState(file, &state) != 0 && SetCommTimeouts(file, &times) != 0;
        if (!set) {
            failed_with(reason, size, GetLastError());
            CloseHandle(file);
            return false;
        }
        PurgeComm(file, PURGE_RXCLEAR | PURGE_TXCLEAR);
    }
    return true;
}

static bool is_socket(const Line *line)
{
    return line->transport == LINE_UDP || line->transport == LINE_TCP;
}

bool line_open(Line *line, Transport transport, const char *address, int baud, double wait, char *reason, size_t size)
{
    const double until = line_now() + wait;
    line->transport = transport;
    line->open = is_socket(line) ? open_socket(line, address, until, reason, size)
                                 : open_file(line, address, baud, until, reason, size);
    return line->open;
}

/* That nobody listens at a UDP port is told of an earlier datagram; the device may start later. */
static bool passing(const Line *line)
{
    const int error = WSAGetLastError();
    return error == WSAEWOULDBLOCK || (line->transport == LINE_UDP && error == WSAECONNRESET);
}

bool line_send(Line *line, const uint8_t *bytes, size_t n, double until)
{
    for (size_t sent = 0; sent < n;) {
        DWORD written = 0;
        if (!is_socket(line)) {
            if (!WriteFile((HANDLE)line->out, bytes + sent, (DWORD)(n - sent), &written, NULL) ||
                (written == 0 && line_now() > until)) {
                return false;
            }
            sent += written;
            continue;
        }
        const int some = send((SOCKET)line->out, (const char *)bytes + sent, (int)(n - sent), 0);
        if (some > 0) {
            sent += (size_t)some;
        } else if (!passing(line) || !wait_for((SOCKET)line->out, true, until)) {
            return false;
        }
    }
    return true;
}

/* Reads the bytes that a file has at once; -1 where it is closed. */
static int read_file(const Line *line, uint8_t *bytes, size_t n)
{
    DWORD there = (DWORD)n, some = 0;
    if (line->transport == LINE_PIPE && !PeekNamedPipe((HANDLE)line->in, NULL, 0, NULL, &there, NULL)) {
        return -1;
    }
    if (there > 0 && !ReadFile((HANDLE)line->in, bytes, there < n ? there : (DWORD)n, &some, NULL)) {
        return -1;
    }
    return (int)some;
}

int line_receive(Line *line, uint8_t *bytes, size_t n, double until)
{
    for (;;) {
        const int some = is_socket(line) ? recv((SOCKET)line->in, (char *)bytes, (int)n, 0) : read_file(line, bytes, n);
        if (some > 0) {
            return some;
        }
        if (is_socket(line) ? (some == 0 && line->transport == LINE_TCP) || (some < 0 && !passing(line)) : some < 0) {
            return -1;
        }
        if (line_now() >= until) {
            return 0;
        }
        if (is_socket(line)) {
            wait_for((SOCKET)line->in, false, until);
        } else {
            Sleep(1);
        }
    }
}

void line_close(Line *line)
{
    if (line->open && is_socket(line)) {
        closesocket((SOCKET)line->in);
        WSACleanup();
    } else if (line->open) {
        CloseHandle((HANDLE)line->in);
    }
    line->open = false;
}
#endif
