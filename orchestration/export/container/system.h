/* What the operating system does for a container: it loads libraries, and writes text by a format of printf's. */
#ifndef CONTAINER_SYSTEM_H
#define CONTAINER_SYSTEM_H

#include <stdarg.h>
#include <stddef.h>

/* Loads a library of this path in UTF-8, with what stands beside it on Windows. Returns NULL where it cannot, with the
 * system's reason where it gives one. */
void *system_load(const char *path, const char **reason);
void *system_find(void *library, const char *name);
void system_unload(void *library);

/* As vsnprintf. */
void system_write(char *text, size_t size, const char *format, va_list given);

#endif
