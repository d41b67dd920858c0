/* The library beside this one, on Linux. Tests: tests/fmus/python/test_errors.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>

#include "library.h"
#include "text.h"

static void *library_opened;

void *open_library(void)
{
    char path[PATH_SIZE];
    Dl_info self;
    if (dladdr((const void *)&library_opened, &self) == 0 || self.dli_fname == NULL) {
        return NULL;
    }
    size_t length = append(path, sizeof path, 0, self.dli_fname);
    while (length > 0 && path[length - 1] != '/') {
        length--;
    }
    (void)append(path, sizeof path, length, "libpythonfmu-export.so");
    library_opened = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    return library_opened;
}

__attribute__((destructor)) static void close_library(void)
{
    if (library_opened != NULL) {
        (void)dlclose(library_opened);
    }
}

void *find(void *library, const char *name)
{
    return dlsym(library, name);
}

void reason(char *text, size_t size)
{
    const char *const found = dlerror();
    (void)append(text, size, 0, found != NULL ? found : "unknown error");
}

void *allocate(size_t size)
{
    return calloc(1, size);
}

void release(void *memory)
{
    free(memory);
}
