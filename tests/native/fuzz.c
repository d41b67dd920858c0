/* Random calls of the FMI functions, right and wrong, on several instances of one block: `fuzz SEED CALLS`.
 * Linked with the shell and a block; run under sanitizers. Exit status 1 where a status is out of its range or memory
 * was not given back. */
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

enum { INSTANCES = 3, STATES = 4, MANY = 6 };

static uint64_t seed;
static long blocks_held, refusals, steps;

static unsigned pick(unsigned n)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(seed >> 33) % n;
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String text, ...)
{
    (void)environment;
    char buffer[1024];
    va_list arguments;
    va_start(arguments, text);
    (void)vsnprintf(buffer, sizeof buffer, text, arguments);
    va_end(arguments);
    if (strlen(buffer) + strlen(name) + strlen(category) > 0 && status == fmi2Error) {
        ++refusals;
    }
}

static void *allocate(size_t count, size_t size)
{
    if (pick(50) == 0) {
        return NULL;
    }
    unsigned char *memory = malloc(count * size);
    if (memory != NULL) {
        memset(memory, 0xA5, count * size);
        ++blocks_held;
    }
    return memory;
}

static void release(void *memory)
{
    --blocks_held;
    free(memory);
}

static double number(void)
{
    static const double odd[] = {0.0, 1.0, -1.0, 0.5, 1e-9, -1e-300, 1e300, -1e300, 1e7, 7e6, 2e-5, 0.1, 1e-6};
    switch (pick(8)) {
    case 0:
        return NAN;
    case 1:
        return pick(2) == 0 ? INFINITY : -INFINITY;
    case 2:
        return (double)pick(2000) / 1000.0 - 1.0;
    default:
        return odd[pick(sizeof odd / sizeof odd[0])];
    }
}

/* Often a start value, so that some calls succeed. */
static double value_for(fmi2ValueReference reference)
{
    return reference < BLOCK_VARIABLES && pick(3) > 0 ? variables[reference].start * (pick(4) == 0 ? 1.01 : 1.0)
                                                      : number();
}

static int expect(fmi2Status status)
{
    if (status != fmi2OK && status != fmi2Error && status != fmi2Discard) {
        (void)fprintf(stderr, "status %d\n", (int)status);
        exit(1);
    }
    return status == fmi2OK;
}

static void variables_of(fmi2Component c)
{
    static const fmi2String texts[] = {
        "2009-08-10T00:00:00Z",
        "",
        "nonsense %s %n #",
        "2009-02-29",
        NULL,
        "a text of far more than sixty-three bytes, which no string of this FMU can hold in its buffer"};
    fmi2ValueReference references[MANY];
    fmi2Real reals[MANY];
    fmi2Integer integers[MANY];
    fmi2String strings[MANY];
    const size_t n = pick(MANY + 1);
    const unsigned first = pick(BLOCK_VARIABLES + 3);
    for (size_t i = 0; i < MANY; ++i) {
        references[i] = pick(5) > 0 ? first + (unsigned)i : pick(20) > 0 ? pick(BLOCK_VARIABLES + 2) : 4294967295u;
        reals[i] = value_for(references[i]);
        integers[i] = pick(4) > 0 ? 1 + (int)pick(3) : pick(2) > 0 ? (int)pick(15) : -2147483647 - 1;
        strings[i] = texts[pick(6)];
    }
    const bool null = pick(40) == 0;
    switch (pick(8)) {
    case 0:
        expect(fmi2SetInteger(c, null ? NULL : references, n, integers));
        break;
    case 1:
        expect(fmi2SetBoolean(c, references, n, null ? NULL : integers));
        break;
    case 2:
        expect(fmi2SetString(c, null ? NULL : references, n, strings));
        break;
    case 3:
        expect(fmi2GetReal(c, references, n, null ? NULL : reals));
        break;
    case 4:
        expect(fmi2GetInteger(c, references, n, integers));
        expect(fmi2GetBoolean(c, null ? NULL : references, n, integers));
        break;
    case 5:
        if (expect(fmi2GetString(c, references, n, null ? NULL : strings))) {
            for (size_t i = 0; i < n; ++i) {
                refusals += strlen(strings[i]) > 63;
            }
        }
        break;
    default:
        expect(fmi2SetReal(c, references, n, null ? NULL : reals));
        break;
    }
}

static void saved_states(fmi2Component c, fmi2FMUstate states[STATES])
{
    fmi2FMUstate *state = &states[pick(STATES)];
    size_t size = 0;
    switch (pick(4)) {
    case 0:
        expect(fmi2GetFMUstate(c, pick(20) == 0 ? NULL : state));
        break;
    case 1:
        expect(fmi2SetFMUstate(c, *state));
        break;
    case 2:
        expect(fmi2FreeFMUstate(c, pick(20) == 0 ? NULL : state));
        break;
    default:
        if (expect(fmi2SerializedFMUstateSize(c, *state, &size))) {
            char *bytes = malloc(size);
            if (bytes == NULL) {
                return;
            }
            expect(fmi2SerializeFMUstate(c, *state, bytes, size - pick(2)));
            if (expect(fmi2SerializeFMUstate(c, *state, bytes, size))) {
                if (pick(2) == 0) {
                    bytes[pick((unsigned)size)] ^= (char)(1u << pick(8));
                }
                expect(fmi2DeSerializeFMUstate(c, bytes, size - (pick(8) == 0 ? pick((unsigned)size) : 0),
                                               &states[pick(STATES)]));
            }
            free(bytes);
        }
        break;
    }
}

static void one_call(fmi2Component c, fmi2FMUstate states[STATES], double *time)
{
    static const double lengths[] = {0.1, 0.1, 0.1, 1e-3, 2.0, 0.0, -0.1, 1e300};
    static const fmi2String categories[] = {"logAll", "logStatusError", "nonsense", NULL};
    const double h = pick(20) == 0 ? number() : lengths[pick(8)];
    double real;
    int integer;
    fmi2Status status;
    switch (pick(16)) {
    case 0:
        if (expect(fmi2SetupExperiment(c, 0, 0.0, pick(10) == 0 ? number() : 0.0, (int)pick(2),
                                       pick(10) == 0 ? number() : 1e6))) {
            *time = 0.0;
        }
        break;
    case 1:
        expect(fmi2EnterInitializationMode(c));
        break;
    case 2:
        expect(fmi2ExitInitializationMode(c));
        break;
    case 3:
        expect(pick(30) == 0 ? fmi2Terminate(c) : fmi2OK);
        break;
    case 4:
        expect(pick(30) == 0 ? fmi2Reset(c) : fmi2OK);
        break;
    case 5:
        expect(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, time));
        expect(fmi2GetRealStatus(c, (fmi2StatusKind)pick(4), pick(9) == 0 ? NULL : &real));
        expect(fmi2GetStatus(c, (fmi2StatusKind)pick(4), &status));
        expect(fmi2GetBooleanStatus(c, (fmi2StatusKind)pick(4), pick(9) == 0 ? NULL : &integer));
        expect(fmi2GetIntegerStatus(c, (fmi2StatusKind)pick(4), &integer));
        expect(fmi2GetStringStatus(c, (fmi2StatusKind)pick(4), NULL));
        break;
    case 6:
        expect(fmi2SetDebugLogging(c, (int)pick(2), pick(4), pick(9) == 0 ? NULL : categories));
        expect(fmi2CancelStep(c));
        expect(fmi2GetDirectionalDerivative(c, NULL, 1, NULL, 1, NULL, NULL));
        expect(fmi2SetRealInputDerivatives(c, NULL, 1, NULL, NULL));
        expect(fmi2GetRealOutputDerivatives(c, NULL, 1, NULL, NULL));
        break;
    case 7:
    case 8:
        saved_states(c, states);
        break;
    case 9:
    case 10:
    case 11:
    case 12:
        (void)fmi2GetRealStatus(c, fmi2LastSuccessfulTime, time);
        steps += expect(fmi2DoStep(c, pick(30) == 0 ? number() : *time, h, (int)pick(2)));
        break;
    default:
        variables_of(c);
        break;
    }
}

int main(int count, char **words)
{
    const fmi2CallbackFunctions callbacks = {logger, allocate, release, NULL, NULL};
    fmi2Component instances[INSTANCES] = {NULL};
    fmi2FMUstate states[STATES] = {NULL};
    double times[INSTANCES] = {0.0};
    seed = count > 1 ? strtoull(words[1], NULL, 10) : 1;
    for (long calls = count > 2 ? strtol(words[2], NULL, 10) : 10000; calls > 0; --calls) {
        const unsigned i = pick(INSTANCES);
        if (instances[i] == NULL) {
            instances[i] =
                fmi2Instantiate(pick(9) == 0 ? NULL : "it", pick(9) == 0 ? fmi2ModelExchange : fmi2CoSimulation,
                                pick(9) == 0 ? "{other}" : BLOCK_GUID, NULL, pick(9) == 0 ? NULL : &callbacks, 0, 1);
        }
        if (pick(400) == 0) {
            fmi2FreeInstance(instances[i]);
            instances[i] = NULL;
        }
        one_call(instances[i], states, &times[i]);
    }
    while (instances[0] == NULL) {
        instances[0] = fmi2Instantiate("it", fmi2CoSimulation, BLOCK_GUID, NULL, &callbacks, 0, 0);
    }
    for (int k = 0; k < STATES; ++k) {
        (void)fmi2FreeFMUstate(instances[0], &states[k]);
    }
    for (int i = 0; i < INSTANCES; ++i) {
        fmi2FreeInstance(instances[i]);
    }
    (void)printf("%ld refusals, %ld steps\n", refusals, steps);
    if (blocks_held != 0) {
        (void)fprintf(stderr, "%ld blocks of memory were not given back\n", blocks_held);
    }
    return blocks_held != 0 || refusals == 0 || steps == 0;
}
