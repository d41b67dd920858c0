/* A host of a container, linked with its C: a flight, its states and their damaged bytes, and a second flight.
 *
 * container_host RESOURCES GUID STEP STEPS; prints the time and the sum of the other real numbers at the ends of the
 * flights, which is the same for both and after going back to a state. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2.h"

static int said;

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    char text[2048];
    va_list given;
    (void)environment;
    (void)status;
    va_start(given, message);
    vsnprintf(text, sizeof text, message, given);
    va_end(given);
    said += strlen(name) + strlen(category) + strlen(text) > 0;
}

static void *allocate(size_t count, size_t size)
{
    return calloc(count, size);
}

static void need(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s\n", what);
        exit(1);
    }
}
#define OK(CALL) need((CALL) == fmi2OK, #CALL)
#define REFUSED(CALL) need((CALL) == fmi2Error, #CALL)

static double sum(fmi2Component c)
{
    double total = 0.0, value;
    for (fmi2ValueReference r = 1; r < 4000; ++r) {
        total += fmi2GetReal(c, &r, 1, &value) == fmi2OK ? value : 0.0;
    }
    return total;
}

static double fly(fmi2Component c, double step, int first, int last)
{
    for (int k = first; k < last; ++k) {
        OK(fmi2DoStep(c, k * step, step, fmi2True));
    }
    return sum(c);
}

static void begin(fmi2Component c)
{
    OK(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    OK(fmi2EnterInitializationMode(c));
    OK(fmi2ExitInitializationMode(c));
}

/* Each byte of the beginning and some of the others are damaged, and each length is tried that is too short. */
static void damage(fmi2Component c, const fmi2Byte *bytes, size_t size)
{
    fmi2Byte *spoilt = malloc(size);
    need(spoilt != NULL, "memory");
    for (size_t i = 0; i < size; i += i < 200 ? 1 : 97) {
        fmi2FMUstate state = NULL;
        memcpy(spoilt, bytes, size);
        spoilt[i] = (fmi2Byte)~spoilt[i];
        if (fmi2DeSerializeFMUstate(c, spoilt, size, &state) == fmi2OK) {
            OK(fmi2FreeFMUstate(c, &state));
        }
        need(state == NULL, "no state is left of bytes that are refused");
        fmi2Byte *cut = malloc(i + 1); /* of its own, so that a byte too far is seen */
        need(cut != NULL, "memory");
        memcpy(cut, bytes, i + 1);
        if (i + 1 < size) {
            REFUSED(fmi2DeSerializeFMUstate(c, cut, i + 1, &state));
            need(state == NULL, "no state is left of bytes that are too few");
        }
        free(cut);
    }
    free(spoilt);
}

int main(int count, char **words)
{
    need(count == 5, "container_host RESOURCES GUID STEP STEPS");
    const fmi2CallbackFunctions calls = {logger, allocate, free, NULL, NULL};
    const double step = atof(words[3]);
    const int steps = atoi(words[4]);
    need(fmi2Instantiate("other", fmi2CoSimulation, "another", words[1], &calls, fmi2False, fmi2True) == NULL, "GUID");
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, words[2], words[1], &calls, fmi2False, fmi2True);
    need(c != NULL, "fmi2Instantiate");
    REFUSED(fmi2DoStep(c, 0.0, step, fmi2True));
    OK(fmi2SetDebugLogging(c, fmi2False, 0, NULL));
    begin(c);
    fly(c, step, 0, steps / 2);
    fmi2FMUstate state = NULL;
    OK(fmi2GetFMUstate(c, &state));
    OK(fmi2GetFMUstate(c, &state));
    const double first = fly(c, step, steps / 2, steps);
    size_t size = 0;
    OK(fmi2SerializedFMUstateSize(c, state, &size));
    fmi2Byte *bytes = malloc(size);
    need(bytes != NULL, "memory");
    OK(fmi2SerializeFMUstate(c, state, bytes, size));
    REFUSED(fmi2SerializeFMUstate(c, state, bytes, size - 1));
    OK(fmi2FreeFMUstate(c, &state));
    damage(c, bytes, size);
    REFUSED(fmi2SetFMUstate(c, NULL));
    OK(fmi2DeSerializeFMUstate(c, bytes, size, &state));
    OK(fmi2SetFMUstate(c, state));
    OK(fmi2FreeFMUstate(c, &state));
    const double back = fly(c, step, steps / 2, steps);
    REFUSED(fmi2DoStep(c, 0.0, step, fmi2True));
    OK(fmi2Terminate(c));
    OK(fmi2Reset(c));
    begin(c);
    const double second = fly(c, step, 0, steps);
    fmi2FreeInstance(c);
    free(bytes);
    need(said > 0, "a refusal is told");
    printf("%a %a %a\n", first, back, second);
    return 0;
}
