/* What no block has and FMI 3.0 or tools ask of every FMU: types, clocks, derivatives, other interface types. FMPy loads no
 * library that lacks a function of another interface type. */
#include "fmi3.h"

static fmi3Status absent(fmi3Instance instance, const char *function, size_t n)
{
    Instance *c = called(instance, function);
    if (c == NULL) {
        return fmi2Error;
    }
    return n == 0 ? fmi2OK : refuse_text(c, function, "not offered; see the modelDescription.xml");
}

#define NO_TYPE(type)                                                                                                  \
    FMI3_EXPORT fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference references[], size_t n,              \
                                         fmi3##type values[], size_t n_values)                                         \
    {                                                                                                                  \
        (void)references, (void)values, (void)n_values;                                                                \
        return absent(c, "fmi3Get" #type, n);                                                                          \
    }                                                                                                                  \
    FMI3_EXPORT fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference references[], size_t n,              \
                                         const fmi3##type values[], size_t n_values)                                   \
    {                                                                                                                  \
        (void)references, (void)values, (void)n_values;                                                                \
        return absent(c, "fmi3Set" #type, n);                                                                          \
    }

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(UInt64)

FMI3_EXPORT fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t n, size_t sizes[],
                                     fmi3Binary values[], size_t n_values)
{
    (void)references, (void)sizes, (void)values, (void)n_values;
    return absent(c, "fmi3GetBinary", n);
}

FMI3_EXPORT fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                     const size_t sizes[], const fmi3Binary values[], size_t n_values)
{
    (void)references, (void)sizes, (void)values, (void)n_values;
    return absent(c, "fmi3SetBinary", n);
}

/* Functions of clocks, which have references, their number, and one, two or three arrays. */
#define NO_CLOCKS(name, ...)                                                                                           \
    FMI3_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference references[], size_t n, __VA_ARGS__)          \
    {                                                                                                                  \
        (void)references, (void)a;                                                                                     \
        return absent(c, #name, n);                                                                                    \
    }
#define NO_CLOCKS_OF_TWO(name, ...)                                                                                    \
    FMI3_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference references[], size_t n, __VA_ARGS__)          \
    {                                                                                                                  \
        (void)references, (void)a, (void)b;                                                                            \
        return absent(c, #name, n);                                                                                    \
    }

NO_CLOCKS(fmi3GetClock, fmi3Clock a[])
NO_CLOCKS(fmi3SetClock, const fmi3Clock a[])
NO_CLOCKS(fmi3GetShiftDecimal, fmi3Float64 a[])
NO_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64 a[])
NO_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64 a[])
NO_CLOCKS_OF_TWO(fmi3GetIntervalDecimal, fmi3Float64 a[], int b[])
NO_CLOCKS_OF_TWO(fmi3GetShiftFraction, fmi3UInt64 a[], fmi3UInt64 b[])
NO_CLOCKS_OF_TWO(fmi3SetShiftFraction, const fmi3UInt64 a[], const fmi3UInt64 b[])
NO_CLOCKS_OF_TWO(fmi3SetIntervalFraction, const fmi3UInt64 a[], const fmi3UInt64 b[])

FMI3_EXPORT fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                               fmi3UInt64 counters[], fmi3UInt64 resolutions[], int qualifiers[])
{
    (void)references, (void)counters, (void)resolutions, (void)qualifiers;
    return absent(c, "fmi3GetIntervalFraction", n);
}

#define NO_MODE(name)                                                                                                  \
    FMI3_EXPORT fmi3Status name(fmi3Instance c)                                                                        \
    {                                                                                                                  \
        return absent(c, #name, 1);                                                                                    \
    }

NO_MODE(fmi3EnterEventMode)
NO_MODE(fmi3EnterStepMode)
NO_MODE(fmi3EnterConfigurationMode)
NO_MODE(fmi3ExitConfigurationMode)
NO_MODE(fmi3EvaluateDiscreteStates)
NO_MODE(fmi3EnterContinuousTimeMode)

#define NO_STATES(name, array)                                                                                         \
    FMI3_EXPORT fmi3Status name(fmi3Instance c, array values[], size_t n)                                              \
    {                                                                                                                  \
        (void)values;                                                                                                  \
        return absent(c, #name, n);                                                                                    \
    }

NO_STATES(fmi3SetContinuousStates, const fmi3Float64)
NO_STATES(fmi3GetContinuousStates, fmi3Float64)
NO_STATES(fmi3GetContinuousStateDerivatives, fmi3Float64)
NO_STATES(fmi3GetNominalsOfContinuousStates, fmi3Float64)
NO_STATES(fmi3GetEventIndicators, fmi3Float64)

#define NO_NUMBER(name)                                                                                                \
    FMI3_EXPORT fmi3Status name(fmi3Instance c, size_t *n)                                                             \
    {                                                                                                                  \
        (void)n;                                                                                                       \
        return absent(c, #name, 1);                                                                                    \
    }

NO_NUMBER(fmi3GetNumberOfContinuousStates)
NO_NUMBER(fmi3GetNumberOfEventIndicators)

FMI3_EXPORT fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time)
{
    (void)time;
    return absent(c, "fmi3SetTime", 1);
}

FMI3_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set_state_before, fmi3Boolean *event,
                                                   fmi3Boolean *terminate)
{
    (void)no_set_state_before, (void)event, (void)terminate;
    return absent(c, "fmi3CompletedIntegratorStep", 1);
}

FMI3_EXPORT fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return absent(c, "fmi3ActivateModelPartition", 1);
}

FMI3_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needed, fmi3Boolean *terminate,
                                                fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined,
                                                fmi3Float64 *next)
{
    (void)needed, (void)terminate, (void)nominals, (void)values, (void)defined, (void)next;
    return absent(c, "fmi3UpdateDiscreteStates", 1);
}

FMI3_EXPORT fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference references[], size_t n,
                                                const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values)
{
    (void)references, (void)orders, (void)values, (void)n_values;
    return absent(c, "fmi3GetOutputDerivatives", n);
}

FMI3_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference reference, size_t *n)
{
    (void)reference, (void)n;
    return absent(c, "fmi3GetNumberOfVariableDependencies", 1);
}

FMI3_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                                   fmi3ValueReference independents[], size_t places[], int kinds[],
                                                   size_t n)
{
    (void)dependent, (void)elements, (void)independents, (void)places, (void)kinds, (void)n;
    return absent(c, "fmi3GetVariableDependencies", 1);
}

#if !BLOCK_DERIVATIVES
#define NO_DERIVATIVE(name)                                                                                            \
    FMI3_EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,                \
                                const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],          \
                                size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)                        \
    {                                                                                                                  \
        (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed;                      \
        (void)sensitivity, (void)n_sensitivity;                                                                        \
        return absent(c, #name, 1);                                                                                    \
    }

NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)
#endif

static fmi3Instance no_type(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    if (log != NULL) {
        log(environment, fmi2Error, "logStatusError",
            "expected fmi3InstantiateCoSimulation, the only type of this FMU");
    }
    return NULL;
}

FMI3_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean log,
                                                      fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback listen)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)log;
    return no_type(environment, listen);
}

FMI3_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean log,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback listen, fmi3ClockUpdateCallback update,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)log, (void)update, (void)lock, (void)unlock;
    return no_type(environment, listen);
}
