/* A shell round PythonFMU's library, which stands beside it: the same functions, with truthful errors.
 *
 * PythonFMU 0.7 reports every exception as fmi2Fatal, though its instance lives on (fmus/python/calls.py keeps it
 * alive), and drops every message, errors too, when the host has logging off. Here fmi2Fatal becomes fmi2Error, and
 * messages of warnings and errors always reach the host. All else is handed through.
 * Tests: tests/fmus/python/test_errors.py. */
#include "fmi2.h"
#include "handed_through.h"
#include "library.h"
#include "text.h"

#define TEXT_SIZE 1024
#define NAME_SIZE 256

typedef struct {
    fmi2Component inner;
    const fmi2CallbackFunctions *host;
    fmi2CallbackFunctions callbacks;
    bool log_all;
    char name[NAME_SIZE];
} Shell;

#define POINTER(name, parameters, arguments) fmi2Status(*name) parameters;

static struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                                 fmi2Boolean, fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*free_state)(fmi2Component, fmi2FMUstate *);
    fmi2Status (*set_boolean)(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Boolean[]);
    HANDED_THROUGH(POINTER)
} inner;

/* Fetches a function's address; ISO C has no cast between pointers to data and to functions. */
#define FETCH(member, name)                                                                                            \
    {                                                                                                                  \
        union {                                                                                                        \
            void *pointer;                                                                                             \
            __typeof__(inner.member) function;                                                                         \
        } address = {.pointer = find(library, name)};                                                                  \
        inner.member = address.function;                                                                               \
        complete = complete && address.pointer != NULL;                                                                \
    }
#define FETCH_NAMED(name, parameters, arguments) FETCH(name, #name)

/* Opens PythonFMU's library once for all instances. Where that fails, returns false and says why. */
static bool connect_inner(char *text, size_t size)
{
    static bool connected = false;
    if (connected) {
        return true;
    }
    void *const library = open_library();
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

/* Tells the host of an error. */
static void tell(const fmi2CallbackFunctions *host, fmi2String name, const char *text)
{
    char format[2 * TEXT_SIZE];
    write_as_format(format, sizeof format, text);
    host->logger(host->componentEnvironment, name, fmi2Error, "logStatusError", format);
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
        static const char about[] =
            "this FMU needs a host that holds Python 3.11 or later with numpy; for any other there is "
            "the native flavour of this block, "
            "which needs nothing. PythonFMU's library cannot be loaded: ";
        const size_t used = append(text, sizeof text, 0, about);
        if (connect_inner(text + used, sizeof text - used)) {
            text[0] = '\0';
        }
    }
    if (text[0] != '\0') {
        tell(host, name, text);
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
            tell(shell->host, shell->name, text);
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
#define HAND_THROUGH(name, parameters, arguments)                                                                      \
    fmi2Status name parameters                                                                                         \
    {                                                                                                                  \
        return c == NULL ? fmi2Error : truthful(inner.name arguments);                                                 \
    }

HANDED_THROUGH(HAND_THROUGH)
