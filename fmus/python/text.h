/* Text in buffers, without a C library. */
#ifndef PYTHON_TEXT_H
#define PYTHON_TEXT_H

#include <stdbool.h>
#include <stddef.h>

/* Appends text to a buffer that holds `used` characters, as far as there is room; returns how many it holds then. */
static inline size_t append(char *buffer, size_t size, size_t used, const char *text)
{
    while (*text != '\0' && used + 1 < size) {
        buffer[used++] = *text++;
    }
    buffer[used] = '\0';
    return used;
}

/* Writes text as a format of FMI's loggers, in which '%' and '#' stand twice. */
static inline void write_as_format(char *buffer, size_t size, const char *text)
{
    size_t used = 0;
    for (buffer[0] = '\0'; *text != '\0'; ++text) {
        const char both[] = {*text, (char)(*text == '%' || *text == '#' ? *text : '\0'), '\0'};
        used = append(buffer, size, used, both);
    }
}

/* Appends a number in decimal. */
static inline size_t append_integer(char *buffer, size_t size, size_t used, long long number)
{
    char digits[24];
    size_t first = sizeof digits - 1;
    unsigned long long left = number < 0 ? 0ull - (unsigned long long)number : (unsigned long long)number;
    digits[first] = '\0';
    do {
        digits[--first] = (char)('0' + left % 10);
        left /= 10;
    } while (left > 0);
    used = number < 0 ? append(buffer, size, used, "-") : used;
    return append(buffer, size, used, digits + first);
}

/* Whether a text begins with another, or is the same if `whole`. */
static inline bool begins(const char *text, const char *with, bool whole)
{
    while (*with != '\0') {
        if (*text++ != *with++) {
            return false;
        }
    }
    return !whole || *text == '\0';
}

#endif
