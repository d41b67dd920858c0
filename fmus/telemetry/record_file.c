#include "record_file.h"

#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <fcntl.h>
#include <unistd.h>
#endif

static int digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

static const char *behind(const char *text, const char *beginning)
{
    const char *at = text;
    for (; *beginning != '\0'; ++at, ++beginning) {
        if (*at != *beginning) {
            return NULL;
        }
    }
    return at;
}

bool resource_path(char path[PATH_SIZE], const char *uri, const char *name)
{
    const char *local = behind(uri, "file:"), *from = local == NULL ? uri : local;
    from += behind(from, "///") != NULL ? 2 : 0;
    size_t n = 0;
#if defined(_WIN32)
    from += *from == '/' && from[1] != '/';
#endif
    while (*from != '\0' && n < PATH_SIZE - 2) {
        if (*from == '%' && digit(from[1]) >= 0 && digit(from[2]) >= 0) {
            path[n++] = (char)(16 * digit(from[1]) + digit(from[2]));
            from += 3;
        } else {
            path[n++] = *from++;
        }
    }
    n -= n > 0 && path[n - 1] == '/';
    path[n++] = '/';
    while (*name != '\0' && n < PATH_SIZE - 1) {
        path[n++] = *name++;
    }
    path[n] = '\0';
    return *from == '\0' && *name == '\0';
}

#if defined(_WIN32)

bool record_open(RecordFile *file, const char *resources, const char *name)
{
    char path[PATH_SIZE];
    WCHAR wide[PATH_SIZE];
    if (!resource_path(path, resources, name) || MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, PATH_SIZE) == 0) {
        return false;
    }
    const HANDLE handle = CreateFileW(wide, GENERIC_READ, FILE_SHARE_READ, NULL, OPEN_EXISTING, 0, NULL);
    file->open = handle != INVALID_HANDLE_VALUE;
    file->handle = (intptr_t)handle;
    return file->open;
}

static size_t some(RecordFile *file, char *into, size_t bytes)
{
    DWORD got = 0;
    return ReadFile((HANDLE)file->handle, into, (DWORD)bytes, &got, NULL) ? got : 0;
}

bool record_seek(RecordFile *file, uint64_t at)
{
    LARGE_INTEGER to;
    to.QuadPart = (LONGLONG)at;
    return SetFilePointerEx((HANDLE)file->handle, to, NULL, FILE_BEGIN) != 0;
}

void record_close(RecordFile *file)
{
    if (file->open) {
        CloseHandle((HANDLE)file->handle);
    }
    file->open = false;
}

#else

bool record_open(RecordFile *file, const char *resources, const char *name)
{
    char path[PATH_SIZE];
    const int handle = resource_path(path, resources, name) ? open(path, O_RDONLY) : -1;
    file->open = handle >= 0;
    file->handle = handle;
    return file->open;
}

static size_t some(RecordFile *file, char *into, size_t bytes)
{
    const ssize_t got = read((int)file->handle, into, bytes);
    return got > 0 ? (size_t)got : 0;
}

bool record_seek(RecordFile *file, uint64_t at)
{
    return lseek((int)file->handle, (off_t)at, SEEK_SET) == (off_t)at;
}

void record_close(RecordFile *file)
{
    if (file->open) {
        close((int)file->handle);
    }
    file->open = false;
}

#endif

bool record_read(RecordFile *file, void *into, size_t bytes)
{
    char *to = into;
    while (bytes > 0) {
        const size_t got = some(file, to, bytes);
        if (got == 0) {
            return false;
        }
        to += got;
        bytes -= got;
    }
    return true;
}
