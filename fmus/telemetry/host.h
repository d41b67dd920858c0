/* What the instance of a record and that of an FMU of changes begin with: the host's functions and their name there. */
#ifndef TELEMETRY_HOST_H
#define TELEMETRY_HOST_H

#include "fmi2.h"

typedef struct {
    fmi2CallbackFunctions calls;
    char name[128];
} Host;

/* An instance of so many bytes, zero behind its Host; NULL where the host asks for another kind or has no memory. */
void *host_instance(size_t size, fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                    const fmi2CallbackFunctions *calls);

/* Tells the host, and returns fmi2Error. The message has no %: some hosts show the format itself. */
fmi2Status host_refuse(const Host *host, const char *message);

#endif
