/* The library beside this one, on Linux. Tests: tests/fmus/python/test_errors.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>

#include "library.h"
#include "text.h"

static void *library_opened;

/* PythonFMU 0.7 lets go of the interpreter twice when the process ends: in the destructor of a static object, and after
 * it in a function of the unloading library, which then writes into freed memory. Let go before both, it does nothing in
 * either. The library stays in memory to the end of the process by itself (its C++ has unique symbols); where it did
 * not, RTLD_NODELETE keeps it, as the process calls into it at its end. */
int __cxa_atexit(void (*function)(void *), void *argument, void *library);

static void let_go_before_the_end(void *library)
{
    union {
        void *pointer;
        void (*function)(void *);
    } finalize = {.pointer = dlsym(library, "finalizePythonInterpreter")};
    if (finalize.pointer != NULL) {
        (void)__cxa_atexit(finalize.function, NULL, NULL);
    }
}

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
    library_opened = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library_opened != NULL) {
        let_go_before_the_end(library_opened);
    }
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
