#include "system.h"

#if defined(_WIN32)

#include <windows.h>

#include "record_file.h"

void *system_load(const char *path, const char **reason)
{
    WCHAR wide[PATH_SIZE];
    *reason = "LoadLibrary refuses it";
    if (MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, PATH_SIZE) == 0) {
        return NULL;
    }
    for (WCHAR *at = wide; *at != L'\0'; ++at) {
        *at = *at == L'/' ? L'\\' : *at; /* else it does not look beside the library */
    }
    return LoadLibraryExW(wide, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
}

void *system_find(void *library, const char *name)
{
    const FARPROC found = GetProcAddress(library, name);
    return *(void *const *)&found;
}

void system_unload(void *library)
{
    FreeLibrary(library);
}

/* No C library is linked; that of Windows itself is always there. */
void system_write(char *text, size_t size, const char *format, va_list given)
{
    int (*write)(char *, size_t, const char *, va_list) = NULL;
    const HMODULE library = LoadLibraryA("msvcrt.dll");
    if (library != NULL) {
        *(FARPROC *)&write = GetProcAddress(library, "_vsnprintf");
    }
    if (write != NULL) {
        write(text, size, format, given);
    } else {
        lstrcpynA(text, format, (int)size);
    }
    text[size - 1] = '\0';
}

#else

#include <dlfcn.h>
#include <stdio.h>

void *system_load(const char *path, const char **reason)
{
    void *const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    *reason = library == NULL ? dlerror() : "";
    return library;
}

void *system_find(void *library, const char *name)
{
    return dlsym(library, name);
}

void system_unload(void *library)
{
    dlclose(library);
}

void system_write(char *text, size_t size, const char *format, va_list given)
{
    vsnprintf(text, size, format, given);
}

#endif
