/* HOST:PORT. */
#include "line.h"

#include <string.h>

enum { PORT_MAX = 65535 };

static bool is_port(const char *text)
{
    long number = 0;
    for (const char *at = text; *at != '\0'; ++at) {
        if (*at < '0' || *at > '9' || (number = 10 * number + (*at - '0')) > PORT_MAX) {
            return false;
        }
    }
    return number > 0;
}

bool line_split(const char *address, char *host, size_t size, const char **port)
{
    size_t n = strlen(address);
    while (n > 0 && address[n - 1] != ':') {
        --n;
    }
    if (n == 0 || !is_port(address + n)) {
        return false;
    }
    *port = address + n;
    size_t length = n - 1, from = 0;
    if (length >= 2 && address[0] == '[' && address[length - 1] == ']') {
        from = 1;
        length -= 2;
    }
    if (length == 0 || length >= size) {
        return false;
    }
    memcpy(host, address + from, length);
    host[length] = '\0';
    return true;
}

bool line_is_host_port(const char *address)
{
    char host[LINE_HOST];
    const char *port;
    return line_split(address, host, sizeof host, &port);
}
