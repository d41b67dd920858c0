#include "host.h"

void *host_instance(size_t size, fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                    const fmi2CallbackFunctions *calls)
{
    if (calls == NULL || calls->allocateMemory == NULL || calls->freeMemory == NULL || type != fmi2CoSimulation ||
        resources == NULL || guid == NULL) {
        return NULL;
    }
    Host *host = calls->allocateMemory(1, size);
    if (host != NULL) {
        host->calls = *calls;
        for (size_t i = 0; name != NULL && name[i] != '\0' && i < sizeof host->name - 1; ++i) {
            host->name[i] = name[i];
        }
    }
    return host;
}

fmi2Status host_refuse(const Host *host, const char *message)
{
    if (host->calls.logger != NULL) {
        host->calls.logger(host->calls.componentEnvironment, host->name, fmi2Error, "logStatusError", message);
    }
    return fmi2Error;
}
