/* A shell round PythonFMU's library, which stands beside it: the same functions, with truthful errors.
 *
 * PythonFMU 0.7 reports every exception as fmi2Fatal, though its instance lives on (fmus/slave.py keeps it alive),
 * and drops every message, errors too, when the host has logging off. Here fmi2Fatal becomes fmi2Error, and
 * messages of warnings and errors always reach the host. All else is handed through. */
#if !defined(_WIN32)
#define _GNU_SOURCE
#include <dlfcn.h>
#else
#include <windows.h>
#endif

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2.h"

#define PATH_SIZE 4096

typedef struct {
    fmi2Component inner;
    const fmi2CallbackFunctions *host;
    fmi2CallbackFunctions callbacks;
    bool log_all;
} Shell;

#if defined(_WIN32)

typedef HMODULE Library;

static Library open_library(void)
{
    wchar_t path[PATH_SIZE];
    HMODULE self = NULL;
    const DWORD flags = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
    if (!GetModuleHandleExW(flags, (LPCWSTR)(const void *)&open_library, &self)) {
        return NULL;
    }
    const DWORD length = GetModuleFileNameW(self, path, PATH_SIZE);
    wchar_t *name = length > 0 && length < PATH_SIZE ? wcsrchr(path, L'\\') : NULL;
    static const wchar_t inner[] = L"\\pythonfmu-export.dll";
    if (name == NULL || (size_t)(name - path) + sizeof inner / sizeof *inner > PATH_SIZE) {
        return NULL;
    }
    memcpy(name, inner, sizeof inner);
    return LoadLibraryExW(path, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
}

static void *find(Library library, const char *name)
{
    const FARPROC function = GetProcAddress(library, name);
    void *pointer = NULL;
    memcpy(&pointer, &function, sizeof pointer);
    return pointer;
}

static const char *reason(void)
{
    static char text[64];
    (void)snprintf(text, sizeof text, "Windows error %lu", GetLastError());
    return text;
}

#else

typedef void *Library;

static Library library_opened;

static Library open_library(void)
{
    char path[PATH_SIZE];
    Dl_info self;
    if (dladdr((const void *)&fmi2GetVersion, &self) == 0 || self.dli_fname == NULL) {
        return NULL;
    }
    const char *end = strrchr(self.dli_fname, '/');
    const int folder = end == NULL ? 0 : (int)(end - self.dli_fname + 1);
    const int length = snprintf(path, sizeof path, "%.*slibpythonfmu-export.so", folder, self.dli_fname);
    if (length < 0 || length >= PATH_SIZE) {
        return NULL;
    }
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

static const char *reason(void)
{
    const char *text = dlerror();
    return text != NULL ? text : "its path is too long";
}

#endif

/* Every function that is handed through: its name, its parameters, and the arguments behind the component. */
#define HANDED_THROUGH(X) \
    X(fmi2SetupExperiment, (fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f), (I, a, b, d, e, f)) \
    X(fmi2EnterInitializationMode, (fmi2Component c), (I)) \
    X(fmi2ExitInitializationMode, (fmi2Component c), (I)) \
    X(fmi2Terminate, (fmi2Component c), (I)) \
    X(fmi2Reset, (fmi2Component c), (I)) \
    X(fmi2GetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]), (I, r, n, v)) \
    X(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]), (I, r, n, v)) \
    X(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]), (I, r, n, v)) \
    X(fmi2GetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]), (I, r, n, v)) \
    X(fmi2SetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]), (I, r, n, v)) \
    X(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]), (I, r, n, v)) \
    X(fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[]), (I, r, n, v)) \
    X(fmi2SetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]), (I, r, n, v)) \
    X(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *s), (I, s)) \
    X(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate s), (I, s)) \
    X(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate s, size_t *n), (I, s, n)) \
    X(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n), (I, s, b, n)) \
    X(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s), (I, b, n, s)) \
    X(fmi2GetDirectionalDerivative, (fmi2Component c, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], \
                                     size_t m, const fmi2Real x[], fmi2Real y[]), (I, u, n, k, m, x, y)) \
    X(fmi2SetRealInputDerivatives, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], \
                                    const fmi2Real v[]), (I, r, n, o, v)) \
    X(fmi2GetRealOutputDerivatives, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], \
                                     fmi2Real v[]), (I, r, n, o, v)) \
    X(fmi2DoStep, (fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean b), (I, t, h, b)) \
    X(fmi2CancelStep, (fmi2Component c), (I)) \
    X(fmi2GetStatus, (fmi2Component c, fmi2StatusKind k, fmi2Status *v), (I, k, v)) \
    X(fmi2GetRealStatus, (fmi2Component c, fmi2StatusKind k, fmi2Real *v), (I, k, v)) \
    X(fmi2GetIntegerStatus, (fmi2Component c, fmi2StatusKind k, fmi2Integer *v), (I, k, v)) \
    X(fmi2GetBooleanStatus, (fmi2Component c, fmi2StatusKind k, fmi2Boolean *v), (I, k, v)) \
    X(fmi2GetStringStatus, (fmi2Component c, fmi2StatusKind k, fmi2String *v), (I, k, v))

#define POINTER(name, parameters, arguments) fmi2Status(*name) parameters;

static struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean,
                                 fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*free_state)(fmi2Component, fmi2FMUstate *);
    HANDED_THROUGH(POINTER)
} inner;

/* Copies a function's address without a cast between data and function pointers, which ISO C does not have. */
#define FETCH(target, name) \
    { \
        void *address = find(library, name); \
        memcpy(&(target), &address, sizeof address); \
        complete = complete && address != NULL; \
    }
#define FETCH_NAMED(name, parameters, arguments) FETCH(inner.name, #name)

/* Opens PythonFMU's library once for all instances; returns what went wrong, or NULL. */
static const char *connect_inner(void)
{
    static bool connected = false;
    if (connected) {
        return NULL;
    }
    const Library library = open_library();
    if (library == NULL) {
        return reason();
    }
    bool complete = true;
    FETCH(inner.instantiate, "fmi2Instantiate")
    FETCH(inner.free_instance, "fmi2FreeInstance")
    FETCH(inner.free_state, "fmi2FreeFMUstate")
    HANDED_THROUGH(FETCH_NAMED)
    connected = complete;
    return complete ? NULL : "it lacks a function of FMI 2.0";
}

/* Hands a message to the host. Its text is a format already (fmus/slave.py doubles each '%'). */
static void forward(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String message, ...)
{
    const Shell *const shell = environment;
    if (!shell->log_all && status == fmi2OK) {
        return;
    }
    static const char marker[] = "Fatal py exception encountered: ";
    if (strncmp(message, marker, sizeof marker - 1) == 0) {
        const char *const line = strchr(message, '\n');
        message = line != NULL ? line + 1 : message;
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
    const char *const fault = type != fmi2CoSimulation ? "this FMU is for co-simulation only"
                            : strcmp(guid, BLOCK_GUID) != 0 ? "the GUID differs from this FMU's " BLOCK_GUID
                            : resources == NULL ? "the location of the resources is missing" : NULL;
    if (fault != NULL) {
        host->logger(host->componentEnvironment, name, fmi2Error, "logStatusError", fault);
        return NULL;
    }
    const char *const cause = connect_inner();
    if (cause != NULL) {
        char text[512];
        (void)snprintf(text, sizeof text, "this FMU runs in a process that holds Python; PythonFMU's library cannot be loaded: %s", cause);
        host->logger(host->componentEnvironment, name, fmi2Error, "logStatusError", text);
        return NULL;
    }
    Shell *const shell = calloc(1, sizeof *shell);
    if (shell == NULL) {
        return NULL;
    }
    shell->host = host;
    shell->callbacks = *host;
    shell->callbacks.logger = forward;
    shell->callbacks.componentEnvironment = shell;
    shell->log_all = log != fmi2False;
    shell->inner = inner.instantiate(name, type, guid, resources, &shell->callbacks, visible, fmi2True);
    if (shell->inner == NULL) {
        free(shell);
        return NULL;
    }
    return shell;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c != NULL) {
        inner.free_instance(((Shell *)c)->inner);
        free(c);
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
#define HAND_THROUGH(name, parameters, arguments) \
    fmi2Status name parameters \
    { \
        return c == NULL ? fmi2Error : truthful(inner.name arguments); \
    }

HANDED_THROUGH(HAND_THROUGH)
