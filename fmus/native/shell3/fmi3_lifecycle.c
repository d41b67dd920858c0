/* FMI 3.0 from instantiation to the end, steps and states: by the functions of FMI 2.0 beside this file, which do the work.
 * Tests: tests/native/test_fmi3.py. */
#include "fmi3.h"

/* The only memory that is asked of the system: FMI 3.0 has no callbacks for it. */
#if defined(_WIN32)
__declspec(dllimport) void *__stdcall GetProcessHeap(void);
__declspec(dllimport) void *__stdcall HeapAlloc(void *heap, unsigned long flags, size_t bytes);
__declspec(dllimport) int __stdcall HeapFree(void *heap, unsigned long flags, void *memory);

static void *allocate(size_t count, size_t size)
{
    return HeapAlloc(GetProcessHeap(), 8 /* zeros */, count * size);
}

static void release(void *memory)
{
    HeapFree(GetProcessHeap(), 0, memory);
}
#else
void *calloc(size_t count, size_t size);
void free(void *memory);

static void *allocate(size_t count, size_t size)
{
    return calloc(count, size);
}

static void release(void *memory)
{
    free(memory);
}
#endif

/* Where messages go. */
typedef struct {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Listener;

static void pass_on(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                    fmi2String message, ...)
{
    const Listener *listener = environment;
    (void)instance;
    if (listener->log != NULL) {
        listener->log(listener->environment, status, category, message);
    }
}

Instance *called(fmi3Instance instance, const char *function)
{
    Instance *c = instance;
    if (c != NULL) {
        c->called = function;
    }
    return c;
}

FMI3_EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean log, fmi3Boolean event_mode,
                                                     fmi3Boolean early_return, const fmi3ValueReference required[],
                                                     size_t n, fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback listen,
                                                     fmi3IntermediateUpdateCallback update)
{
    (void)event_mode, (void)early_return, (void)required, (void)n, (void)update;
    Listener *listener = allocate(1, sizeof *listener);
    if (listener == NULL) {
        return NULL;
    }
    *listener = (Listener){environment, listen};
    const fmi2CallbackFunctions callbacks = {pass_on, allocate, release, NULL, listener};
    fmi3Instance c = fmi2Instantiate(name, fmi2CoSimulation, token, resources, &callbacks, visible, log);
    if (c == NULL) {
        release(listener);
    }
    return c;
}

FMI3_EXPORT void fmi3FreeInstance(fmi3Instance instance)
{
    Instance *c = instance;
    if (c != NULL) {
        void *listener = c->callbacks.componentEnvironment;
        fmi2FreeInstance(c);
        release(listener);
    }
}

FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    return fmi2SetDebugLogging(called(c, "fmi3SetDebugLogging"), on, n, categories);
}

FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                                   fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean stop_defined,
                                                   fmi3Float64 stop)
{
    Instance *c = called(instance, "fmi3EnterInitializationMode");
    const fmi3Status status = fmi2SetupExperiment(c, tolerance_defined, tolerance, start, stop_defined, stop);
    return status == fmi2OK ? fmi2EnterInitializationMode(c) : status;
}

FMI3_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return fmi2ExitInitializationMode(called(c, "fmi3ExitInitializationMode"));
}

FMI3_EXPORT fmi3Status fmi3Terminate(fmi3Instance c)
{
    return fmi2Terminate(called(c, "fmi3Terminate"));
}

FMI3_EXPORT fmi3Status fmi3Reset(fmi3Instance c)
{
    return fmi2Reset(called(c, "fmi3Reset"));
}

FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set_state_before,
                                  fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    Instance *c = called(instance, "fmi3DoStep");
    if (c != NULL && (event == NULL || terminate == NULL || early == NULL || reached == NULL)) {
        return refuse_text(c, "fmi3DoStep", "an argument is NULL");
    }
    const fmi3Status status = fmi2DoStep(c, t, h, no_set_state_before);
    if (c != NULL) {
        *event = *terminate = *early = false;
        *reached = c->memory.time;
    }
    return status;
}

FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return fmi2GetFMUstate(called(c, "fmi3GetFMUState"), state);
}

FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return fmi2SetFMUstate(called(c, "fmi3SetFMUState"), state);
}

FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return fmi2FreeFMUstate(called(c, "fmi3FreeFMUState"), state);
}

FMI3_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    return fmi2SerializedFMUstateSize(called(c, "fmi3SerializedFMUStateSize"), state, size);
}

FMI3_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return fmi2SerializeFMUstate(called(c, "fmi3SerializeFMUState"), state, (fmi2Byte *)bytes, size);
}

FMI3_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return fmi2DeSerializeFMUstate(called(c, "fmi3DeserializeFMUState"), (const fmi2Byte *)bytes, size, state);
}
