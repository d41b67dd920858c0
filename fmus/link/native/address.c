/* HOST:PORT. */
#include "line.h"

#include <string.h>

bool line_split(const char *address, char *host, size_t size, const char **port)
{
    size_t n = strlen(address);
    while (n > 0 && address[n - 1] != ':') {
        --n;
    }
    if (n == 0 || address[n] == '\0') {
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
