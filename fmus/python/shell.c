/* A shell round PythonFMU's library, which stands beside it: the same functions, with truthful errors.
 *
 * PythonFMU 0.7 reports every exception as fmi2Fatal, though its instance lives on (fmus/python/calls.py keeps it alive),
 * and drops every message, errors too, when the host has logging off. Here fmi2Fatal becomes fmi2Error, and
 * messages of warnings and errors always reach the host. All else is handed through.
 *
 * Longer than 250 lines: the system's calls stand here twice, for Windows (without a C library) and for POSIX, since one
 * source is compiled for each platform. */
#if !defined(_WIN32)
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#endif

#include <stdbool.h>
#include <stddef.h>

#include "fmi2.h"

#define PATH_SIZE 1024
#define TEXT_SIZE 1024
#define NAME_SIZE 256

typedef struct {
    fmi2Component inner;
    const fmi2CallbackFunctions *host;
    fmi2CallbackFunctions callbacks;
    bool log_all;
    char name[NAME_SIZE];
} Shell;

/* Appends text to a buffer that holds `used` characters, as far as there is room; returns how many it holds then. */
static size_t append(char *buffer, size_t size, size_t used, const char *text)
{
    while (*text != '\0' && used + 1 < size) {
        buffer[used++] = *text++;
    }
    buffer[used] = '\0';
    return used;
}

/* Appends a number in decimal. */
static size_t append_integer(char *buffer, size_t size, size_t used, long long number)
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
static bool begins(const char *text, const char *with, bool whole)
{
    while (*with != '\0') {
        if (*text++ != *with++) {
            return false;
        }
    }
    return !whole || *text == '\0';
}

/* The library beside this one, by the system's own means, so that no C runtime is needed where the system has none. */
#if defined(_WIN32)

/* What is needed of <windows.h>, so that a build needs no Windows headers. */
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

/* What Windows calls when it loads and unloads the library, in place of a C runtime's. */
int __stdcall DllMainCRTStartup(void *library, Dword why, void *reserved)
{
    (void)library;
    (void)why;
    (void)reserved;
    return 1;
}

static Library open_library(void)
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

static void *find(Library library, const char *name)
{
    return GetProcAddress(library, name);
}

static void reason(char *text, size_t size)
{
    if (FormatMessageA(FROM_SYSTEM_IGNORE_INSERTS, NULL, GetLastError(), 0, text, (Dword)size, NULL) == 0) {
        (void)append(text, size, 0, "unknown error");
    }
}

static void *allocate(size_t size)
{
    return HeapAlloc(GetProcessHeap(), ZERO_MEMORY, size);
}

static void release(void *memory)
{
    (void)HeapFree(GetProcessHeap(), 0, memory);
}

#else

typedef void *Library;

static Library library_opened;

static Library open_library(void)
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

static void *find(Library library, const char *name)
{
    return dlsym(library, name);
}

static void reason(char *text, size_t size)
{
    const char *const found = dlerror();
    (void)append(text, size, 0, found != NULL ? found : "unknown error");
}

static void *allocate(size_t size)
{
    return calloc(1, size);
}

static void release(void *memory)
{
    free(memory);
}

#endif

/* Every function that is handed through: its name, its parameters, and the arguments behind the component. */
#define HANDED_THROUGH(X)                                                                                                      \
    X(fmi2SetupExperiment, (fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f),                \
      (I, a, b, d, e, f))                                                                                                      \
    X(fmi2EnterInitializationMode, (fmi2Component c), (I))                                                                     \
    X(fmi2ExitInitializationMode, (fmi2Component c), (I))                                                                      \
    X(fmi2Terminate, (fmi2Component c), (I))                                                                                   \
    X(fmi2Reset, (fmi2Component c), (I))                                                                                       \
    X(fmi2GetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]), (I, r, n, v))                      \
    X(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]), (I, r, n, v))                \
    X(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]), (I, r, n, v))                \
    X(fmi2GetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]), (I, r, n, v))                  \
    X(fmi2SetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]), (I, r, n, v))                \
    X(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]), (I, r, n, v))          \
    X(fmi2SetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]), (I, r, n, v))            \
    X(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate * s), (I, s))                                                            \
    X(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate s), (I, s))                                                              \
    X(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate s, size_t *n), (I, s, n))                                     \
    X(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n), (I, s, b, n))                          \
    X(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s), (I, b, n, s))                 \
    X(fmi2GetDirectionalDerivative,                                                                                            \
      (fmi2Component c, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], size_t m, const fmi2Real x[],    \
       fmi2Real y[]),                                                                                                          \
      (I, u, n, k, m, x, y))                                                                                                   \
    X(fmi2SetRealInputDerivatives,                                                                                             \
      (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[]), (I, r, n, o, v))   \
    X(fmi2GetRealOutputDerivatives,                                                                                            \
      (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[]), (I, r, n, o, v))         \
    X(fmi2DoStep, (fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean b), (I, t, h, b))                                      \
    X(fmi2CancelStep, (fmi2Component c), (I))                                                                                  \
    X(fmi2GetStatus, (fmi2Component c, fmi2StatusKind k, fmi2Status * v), (I, k, v))                                           \
    X(fmi2GetRealStatus, (fmi2Component c, fmi2StatusKind k, fmi2Real * v), (I, k, v))                                         \
    X(fmi2GetIntegerStatus, (fmi2Component c, fmi2StatusKind k, fmi2Integer * v), (I, k, v))                                   \
    X(fmi2GetBooleanStatus, (fmi2Component c, fmi2StatusKind k, fmi2Boolean * v), (I, k, v))                                   \
    X(fmi2GetStringStatus, (fmi2Component c, fmi2StatusKind k, fmi2String * v), (I, k, v))

#define POINTER(name, parameters, arguments) fmi2Status(*name) parameters;

static struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean,
                                 fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*free_state)(fmi2Component, fmi2FMUstate *);
    fmi2Status (*set_boolean)(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Boolean[]);
    HANDED_THROUGH(POINTER)
} inner;

/* Fetches a function's address; ISO C has no cast between pointers to data and to functions. */
#define FETCH(member, name)                                                                                                    \
    {                                                                                                                          \
        union {                                                                                                                \
            void *pointer;                                                                                                     \
            __typeof__(inner.member) function;                                                                                 \
        } address = {.pointer = find(library, name)};                                                                          \
        inner.member = address.function;                                                                                       \
        complete = complete && address.pointer != NULL;                                                                        \
    }
#define FETCH_NAMED(name, parameters, arguments) FETCH(name, #name)

/* Opens PythonFMU's library once for all instances. Where that fails, returns false and says why. */
static bool connect_inner(char *text, size_t size)
{
    static bool connected = false;
    if (connected) {
        return true;
    }
    const Library library = open_library();
    if (library == NULL) {
        reason(text, size);
        return false;
    }
    bool complete = true;
    FETCH(instantiate, "fmi2Instantiate")
    FETCH(free_instance, "fmi2FreeInstance")
    FETCH(free_state, "fmi2FreeFMUstate")
    FETCH(set_boolean, "fmi2SetBoolean")
    HANDED_THROUGH(FETCH_NAMED)
    connected = complete;
    if (!complete) {
        (void)append(text, size, 0, "it lacks a function of FMI 2.0");
    }
    return complete;
}

/* Hands a message to the host. Its text is a format already (fmus/python/calls.py doubles each '%'). */
static void forward(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String message, ...)
{
    const Shell *const shell = environment;
    if (!shell->log_all && status == fmi2OK) {
        return;
    }
    static const char marker[] = "Fatal py exception encountered: ";
    if (begins(message, marker, false)) { /* a line that names PythonFMU's function, then the message */
        const char *line = message;
        while (*line != '\0' && *line != '\n') {
            line++;
        }
        message = *line == '\n' ? line + 1 : message;
    }
    shell->host->logger(shell->host->componentEnvironment, name, status == fmi2Fatal ? fmi2Error : status,
                        category != NULL && *category != '\0' ? category : "logStatusError", message);
}

static fmi2Status truthful(fmi2Status status)
{
    return status == fmi2Fatal ? fmi2Error : status;
}

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean log)
{
    if (name == NULL || host == NULL || host->logger == NULL) {
        return NULL;
    }
    char text[TEXT_SIZE];
    text[0] = '\0';
    if (type != fmi2CoSimulation) {
        (void)append(text, sizeof text, 0, "this FMU is for co-simulation only");
    } else if (guid == NULL || !begins(guid, BLOCK_GUID, true)) {
        (void)append(text, sizeof text, 0, "the GUID differs from this FMU's " BLOCK_GUID);
    } else if (resources == NULL) {
        (void)append(text, sizeof text, 0, "the location of the resources is missing");
    } else {
        static const char about[] = "this FMU needs a host that holds Python 3.11 or later with numpy; for any other there is "
                                    "the native flavour of this block, "
                                    "which needs nothing. PythonFMU's library cannot be loaded: ";
        const size_t used = append(text, sizeof text, 0, about);
        if (connect_inner(text + used, sizeof text - used)) {
            text[0] = '\0';
        }
    }
    if (text[0] != '\0') {
        host->logger(host->componentEnvironment, name, fmi2Error, "logStatusError", text);
        return NULL;
    }
    Shell *const shell = allocate(sizeof *shell);
    if (shell == NULL) {
        return NULL;
    }
    shell->host = host;
    shell->callbacks = *host;
    shell->callbacks.logger = forward;
    shell->callbacks.componentEnvironment = shell;
    shell->log_all = log != fmi2False;
    (void)append(shell->name, sizeof shell->name, 0, name);
    shell->inner = inner.instantiate(name, type, guid, resources, &shell->callbacks, visible, fmi2True);
    if (shell->inner == NULL) {
        release(shell);
        return NULL;
    }
    return shell;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c != NULL) {
        inner.free_instance(((Shell *)c)->inner);
        release(c);
    }
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)n;
    (void)categories;
    if (c == NULL) {
        return fmi2Error;
    }
    ((Shell *)c)->log_all = on != fmi2False;
    return fmi2OK;
}

/* PythonFMU takes every number but 0 for true. */
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
{
    if (c == NULL) {
        return fmi2Error;
    }
    Shell *const shell = c;
    for (size_t i = 0; r != NULL && v != NULL && i < n; i++) {
        if (v[i] != fmi2False && v[i] != fmi2True) {
            char text[TEXT_SIZE];
            size_t used = append(text, sizeof text, 0, "setBoolean: the value reference ");
            used = append_integer(text, sizeof text, used, r[i]);
            used = append(text, sizeof text, used, ": expected fmi2False (0) or fmi2True (1), found ");
            (void)append_integer(text, sizeof text, used, v[i]);
            shell->host->logger(shell->host->componentEnvironment, shell->name, fmi2Error, "logStatusError", text);
            return fmi2Error;
        }
    }
    return truthful(inner.set_boolean(shell->inner, r, n, v));
}

/* PythonFMU leaves the pointer in place; the standard asks for NULL, and a second call must do nothing. */
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (c == NULL) {
        return fmi2Error;
    }
    if (state == NULL || *state == NULL) {
        return fmi2OK;
    }
    const fmi2Status status = inner.free_state(((Shell *)c)->inner, state);
    *state = NULL;
    return truthful(status);
}

#define I ((Shell *)c)->inner
#define HAND_THROUGH(name, parameters, arguments)                                                                              \
    fmi2Status name parameters                                                                                                 \
    {                                                                                                                          \
        return c == NULL ? fmi2Error : truthful(inner.name arguments);                                                         \
    }

HANDED_THROUGH(HAND_THROUGH)
