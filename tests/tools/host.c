/* A host that holds no Python: instantiates a controller, or another FMU of FMI 2.0, and prints what it logs.
 * host LIBRARY GUID RESOURCES */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2.h"

typedef fmi2Component (*Instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                                     fmi2Boolean, fmi2Boolean);

static void say(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                fmi2String message, ...)
{
    va_list arguments;
    (void)environment;
    printf("%s %d %s: ", name, (int)status, category);
    va_start(arguments, message);
    vprintf(message, arguments);
    va_end(arguments);
    printf("\n");
}

int main(int count, char **given)
{
    if (count != 4) {
        return 2;
    }
    void *const library = dlopen(given[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        printf("dlopen: %s\n", dlerror());
        return 1;
    }
    union {
        void *pointer;
        Instantiate function;
    } address = {.pointer = dlsym(library, "fmi2Instantiate")};
    const fmi2CallbackFunctions callbacks = {say, calloc, free, NULL, NULL};
    const fmi2Component instance =
        address.function("block", fmi2CoSimulation, given[2], given[3], &callbacks, fmi2False, fmi2False);
    printf("%s\n", instance == NULL ? "no instance" : "an instance");
    return 0;
}
