/* No state of a device can be saved or restored, and modelDescription.xml says so. In the place of the shell's state.c. */
#include "instance.h"

static fmi2Status not_offered(fmi2Component component, const char *function)
{
    fmi2Status status;
    const Instance *c = enter(component, function, IN_ANY, &status);
    return c == NULL ? status : refuse_text(c, function, "not offered: the memory of a device is out of reach");
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    (void)state;
    return not_offered(component, "fmi2GetFMUstate");
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    (void)state;
    return not_offered(component, "fmi2SetFMUstate");
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    (void)state;
    return not_offered(component, "fmi2FreeFMUstate");
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    (void)state, (void)size;
    return not_offered(component, "fmi2SerializedFMUstateSize");
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    (void)state, (void)bytes, (void)size;
    return not_offered(component, "fmi2SerializeFMUstate");
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    (void)bytes, (void)size, (void)state;
    return not_offered(component, "fmi2DeSerializeFMUstate");
}
