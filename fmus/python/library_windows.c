/* The library beside this one, by Windows' own means: no C library is needed. */
#include "library.h"
#include "text.h"

/* The part of <windows.h> that is needed, so that a build needs no Windows headers. */
typedef struct Module *Library;
typedef unsigned long Dword;
#define FROM(library) __declspec(dllimport) library __stdcall
FROM(int) GetModuleHandleExW(Dword flags, const void *address, Library *);
FROM(Dword) GetModuleFileNameW(Library, wchar_t *path, Dword size);
FROM(Library) LoadLibraryExW(const wchar_t *path, void *reserved, Dword flags);
FROM(void *) GetProcAddress(Library, const char *name);
FROM(Dword) GetLastError(void);
FROM(Dword) FormatMessageA(Dword flags, const void *, Dword error, Dword language, char *text, Dword size, void *);
FROM(void *) GetProcessHeap(void);
FROM(void *) HeapAlloc(void *heap, Dword flags, size_t size);
FROM(int) HeapFree(void *heap, Dword flags, void *memory);
enum {
    FROM_ADDRESS_UNCHANGED_REFERENCES = 0x4 | 0x2, /* of GetModuleHandleExW */
    ALTERED_SEARCH_PATH = 0x8,                     /* of LoadLibraryExW */
    FROM_SYSTEM_IGNORE_INSERTS = 0x1000 | 0x200,   /* of FormatMessageA */
    ZERO_MEMORY = 0x8                              /* of HeapAlloc */
};

/* The function that Windows calls when it loads and unloads the library, in place of a C runtime's. */
int __stdcall DllMainCRTStartup(void *library, Dword why, void *reserved)
{
    (void)library;
    (void)why;
    (void)reserved;
    return 1;
}

void *open_library(void)
{
    static const wchar_t name[] = L"pythonfmu-export.dll";
    wchar_t path[PATH_SIZE];
    Library self = NULL;
    if (!GetModuleHandleExW(FROM_ADDRESS_UNCHANGED_REFERENCES, name, &self)) {
        return NULL;
    }
    size_t length = GetModuleFileNameW(self, path, PATH_SIZE);
    while (length > 0 && path[length - 1] != L'\\' && path[length - 1] != L'/') {
        length--;
    }
    for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
        if (length + i >= PATH_SIZE) {
            return NULL;
        }
        path[length + i] = name[i];
    }
    return LoadLibraryExW(path, NULL, ALTERED_SEARCH_PATH);
}

void *find(void *library, const char *name)
{
    return GetProcAddress(library, name);
}

void reason(char *text, size_t size)
{
    if (FormatMessageA(FROM_SYSTEM_IGNORE_INSERTS, NULL, GetLastError(), 0, text, (Dword)size, NULL) == 0) {
        (void)append(text, size, 0, "unknown error");
    }
}

void *allocate(size_t size)
{
    return HeapAlloc(GetProcessHeap(), ZERO_MEMORY, size);
}

void release(void *memory)
{
    (void)HeapFree(GetProcessHeap(), 0, memory);
}
