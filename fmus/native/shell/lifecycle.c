/* From fmi2Instantiate to fmi2FreeInstance: the calls' order, start values and initialization.
 * Tests: tests/native/test_calls.py. */
#include "instance.h"

#include <math.h>

/* Errors are logged whatever is asked for; events are in "logAll". */
static const char *const log_categories[] = {"logStatusWarning", "logStatusError", "logStatusFatal", "logAll"};

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

Instance *enter(fmi2Component component, const char *function, unsigned modes, fmi2Status *status)
{
    static const char *const now[] = {"before fmi2EnterInitializationMode", "in initialization mode", "in step mode",
                                      "after fmi2Terminate"};
    Instance *c = component;
    *status = fmi2Error;
    if (c == NULL) {
        return NULL;
    }
    if ((modes & (1u << c->memory.mode)) == 0u) {
        Message m = about(c, function);
        put(&m, ": not allowed ");
        put(&m, now[c->memory.mode]);
        refuse(c, &m);
        return NULL;
    }
    *status = fmi2OK;
    return c;
}

void restore_starts(Instance *c)
{
    unsigned char *ports = (unsigned char *)&c->memory.ports;
    memset(&c->memory, 0, sizeof c->memory);
    memset(c->states, 0, sizeof c->states);
    for (uint32_t i = 0; i < BLOCK_VARIABLES; ++i) {
        const Variable *v = &variables[i];
        const int32_t integer = v->kind == KIND_INTEGER ? (int32_t)v->start : 0;
        const bool boolean = v->start != 0.0;
        switch (v->kind) {
        case KIND_REAL:
            memcpy(ports + v->offset, &v->start, sizeof v->start);
            break;
        case KIND_INTEGER:
            memcpy(ports + v->offset, &integer, sizeof integer);
            break;
        case KIND_BOOLEAN:
            memcpy(ports + v->offset, &boolean, sizeof boolean);
            break;
        default:                   /* KIND_STRING */
            if (v->text != NULL) { /* GCOVR_EXCL_BR_LINE: no block has a string output, which has no start */
                memcpy(ports + v->offset, v->text, strlen(v->text) + 1);
            }
            break;
        }
    }
    c->memory.mode = MODE_SETUP;
    c->memory.stop = INFINITY;
    c->law_current = false;
}

/* Gives back what a block holds outside its state, where it holds something. */
static void give_back(Instance *c)
{
#ifdef block_release
    block_release(&c->law);
#else
    (void)c;
#endif
}

/* Notes the name; tells what is wrong where something is. */
static bool may_instantiate(Instance *c, fmi2String name, fmi2Type type, fmi2String guid)
{
    if (name == NULL || name[0] == '\0') {
        refuse_text(c, "fmi2Instantiate", "expected an instance name, found none");
        return false;
    }
    memcpy(c->name, name, strlen(name) < sizeof c->name ? strlen(name) : sizeof c->name - 1);
    if (type != fmi2CoSimulation) {
        refuse_text(c, "fmi2Instantiate", "expected fmi2CoSimulation, the only type of this FMU");
        return false;
    }
    if (guid == NULL || strcmp(guid, BLOCK_GUID) != 0) {
        Message m = message("fmi2Instantiate: GUID: expected " BLOCK_GUID ", found ");
        put(&m, guid == NULL ? "none" : guid);
        put(&m, "; the modelDescription.xml is not of this binary");
        refuse(c, &m);
        return false;
    }
    return true;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean log)
{
    (void)resources, (void)visible;
    if (callbacks == NULL || callbacks->allocateMemory == NULL || callbacks->freeMemory == NULL) {
        if (callbacks != NULL && callbacks->logger != NULL) {
            callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError",
                              "fmi2Instantiate: expected the callbacks allocateMemory and freeMemory, found NULL");
        }
        return NULL;
    }
    Instance *c = callbacks->allocateMemory(1, sizeof *c);
    if (c == NULL) {
        return NULL;
    }
    memset(c, 0, sizeof *c);
    c->callbacks = *callbacks;
    if (!may_instantiate(c, name, type, guid)) {
        callbacks->freeMemory(c);
        return NULL;
    }
    c->log_events = log != fmi2False;
    restore_starts(c);
    log_event(c, "instantiated");
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    Instance *c = component;
    if (c != NULL) {
        give_back(c);
        c->callbacks.freeMemory(c);
    }
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2SetDebugLogging", IN_ANY, &status);
    if (c == NULL) {
        return status;
    }
    if (n > 0 && categories == NULL) {
        return refuse_text(c, "fmi2SetDebugLogging", "categories is NULL");
    }
    bool events = n == 0;
    for (size_t i = 0; i < n; ++i) {
        const char *category = categories[i] == NULL ? "NULL" : categories[i];
        bool declared = false;
        for (size_t k = 0; k < sizeof log_categories / sizeof log_categories[0]; ++k) {
            declared = declared || strcmp(category, log_categories[k]) == 0;
        }
        if (!declared) {
            Message m = message("fmi2SetDebugLogging: expected a category of the modelDescription.xml, found ");
            put(&m, category);
            return refuse(c, &m);
        }
        events = events || strcmp(category, "logAll") == 0;
    }
    c->log_events = events ? on != fmi2False : c->log_events;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2SetupExperiment", IN_SETUP, &status);
    (void)tolerance_defined, (void)tolerance;
    if (c == NULL) {
        return status;
    }
    if (!isfinite(start)) {
        return refuse_fault(c, "fmi2SetupExperiment", &(Fault){"startTime", "a finite number", NULL, start});
    }
    if (stop_defined != fmi2False && !(stop >= start && isfinite(stop))) {
        return refuse_fault(c, "fmi2SetupExperiment",
                            &(Fault){"stopTime", "a finite number, at least startTime", NULL, stop});
    }
    c->memory.time = c->memory.begin = start; /* the block's t = 0 */
    c->memory.stop = stop_defined != fmi2False ? stop : INFINITY;
    c->memory.set_up = true;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2EnterInitializationMode", IN_SETUP, &status);
    if (c == NULL) {
        return status;
    }
    if (!c->memory.set_up) {
        return refuse_text(c, "fmi2EnterInitializationMode", "expected fmi2SetupExperiment before it");
    }
    c->memory.mode = MODE_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2ExitInitializationMode", IN_INITIALIZATION, &status);
    if (c == NULL) {
        return status;
    }
    static const char *const function = "fmi2ExitInitializationMode";
    if (make_law_current(c, function) != fmi2OK || start(c, function) != fmi2OK ||
        evaluate(c, function, other_state(c)) != fmi2OK) {
        return fmi2Error;
    }
    commit_state(c);
    c->memory.mode = MODE_STEP;
    log_event(c, "initialized");
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2Terminate", IN_STEP, &status);
    if (c != NULL) {
        give_back(c);
        c->memory.mode = MODE_TERMINATED;
        log_event(c, "terminated");
    }
    return status;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    fmi2Status status;
    Instance *c = enter(component, "fmi2Reset", IN_ANY, &status);
    if (c != NULL) {
        give_back(c);
        restore_starts(c);
        log_event(c, "reset");
    }
    return status;
}
