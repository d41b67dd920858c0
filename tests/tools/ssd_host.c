/* A host of a page: loads the FMUs (FMI 2.0) of an unpacked SSP archive and steps them one after the other, each with
 * what the others have given up to then, or all at once (parallel); then it shows what the blocks gave, or (exchanged) what
 * they give with the inputs of the next step. It reads a plan that tests/tools/exchanges.py makes of
 * SystemStructure.ssd, a word a line; prints are rows of doubles on standard output.
 *
 * ssd_host PLAN STEP COUNT INTERVAL sequential|parallel|exchanged */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2.h"

enum { COMPONENTS = 32, WIRES = 1024, SEEN = 256 };

#define TYPED(RETURN, NAME, ...) typedef RETURN (*NAME)(__VA_ARGS__)
TYPED(fmi2Component, Instantiate, fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
      fmi2Boolean, fmi2Boolean);
TYPED(fmi2Status, Setup, fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
TYPED(fmi2Status, Mode, fmi2Component);
TYPED(fmi2Status, DoStep, fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
TYPED(fmi2Status, Real, fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *);
TYPED(fmi2Status, Integer, fmi2Component, const fmi2ValueReference *, size_t, fmi2Integer *);
TYPED(fmi2Status, Text, fmi2Component, const fmi2ValueReference *, size_t, fmi2String *);

typedef struct {
    fmi2Component instance;
    void *library;
    DoStep step;
    Real get_real, set_real;
    Integer get_integer, set_integer, get_boolean, set_boolean;
    Text set_text;
} Component;

typedef struct {
    unsigned from, to, source, target;
    char from_type, to_type; /* r, i or b */
    double factor, offset, value;
} Wire;

static Component components[COMPONENTS];
static Wire wires[WIRES], seen[SEEN];

static void say(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String m, ...)
{
    (void)e, (void)category;
    fprintf(stderr, "%s %d: %s\n", name, (int)status, m);
}

static void check(fmi2Status status, const char *what)
{
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
        exit(1);
    }
}

static void find(const Component *c, const char *name, void *function)
{
    void *const found = dlsym(c->library, name);
    if (found == NULL) {
        fprintf(stderr, "no %s\n", name);
        exit(1);
    }
    memcpy(function, &found, sizeof found);
}

static double get(const Component *c, char type, unsigned reference)
{
    fmi2Real real = 0.0;
    fmi2Integer integer = 0;
    if (type == 'r') {
        check(c->get_real(c->instance, &reference, 1, &real), "fmi2GetReal");
        return real;
    }
    check((type == 'i' ? c->get_integer : c->get_boolean)(c->instance, &reference, 1, &integer), "fmi2Get");
    return integer;
}

static void set(const Component *c, char type, unsigned reference, double value)
{
    fmi2Integer integer = (fmi2Integer)value;
    if (type == 'r') {
        check(c->set_real(c->instance, &reference, 1, &value), "fmi2SetReal");
    } else {
        check((type == 'i' ? c->set_integer : c->set_boolean)(c->instance, &reference, 1, &integer), "fmi2Set");
    }
}

static void load(Component *c, FILE *plan)
{
    static const fmi2CallbackFunctions calls = {say, calloc, free, NULL, NULL};
    char name[256], library[1024], guid[256], resources[1024], type, value[1024];
    unsigned reference;
    Instantiate instantiate;
    Setup setup;
    Mode enter;
    if (fscanf(plan, " %255s %1023[^\n] %255s %1023[^\n]", name, library, guid, resources) != 4) {
        exit(2);
    }
    c->library = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (c->library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    find(c, "fmi2Instantiate", &instantiate);
    find(c, "fmi2SetupExperiment", &setup);
    find(c, "fmi2EnterInitializationMode", &enter);
    find(c, "fmi2DoStep", &c->step);
    find(c, "fmi2GetReal", &c->get_real);
    find(c, "fmi2SetReal", &c->set_real);
    find(c, "fmi2GetInteger", &c->get_integer);
    find(c, "fmi2SetInteger", &c->set_integer);
    find(c, "fmi2GetBoolean", &c->get_boolean);
    find(c, "fmi2SetBoolean", &c->set_boolean);
    find(c, "fmi2SetString", &c->set_text);
    c->instance = instantiate(name, fmi2CoSimulation, guid, resources, &calls, fmi2False, fmi2False);
    check(c->instance == NULL ? fmi2Error : fmi2OK, name);
    while (fscanf(plan, " %c", &type) == 1 && type != '.') {
        if (fscanf(plan, " %u %1023[^\n]", &reference, value) != 2) {
            exit(2);
        }
        if (type == 's') {
            check(c->set_text(c->instance, &reference, 1, (fmi2String[]){value}), "fmi2SetString");
        } else {
            set(c, type, reference, strtod(value, NULL));
        }
    }
    check(setup(c->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0), "fmi2SetupExperiment");
    check(enter(c->instance), "fmi2EnterInitializationMode");
}

static void fetch(Wire *w)
{
    w->value = w->factor * get(&components[w->from], w->from_type, w->source) + w->offset;
}

static void fetch_all(size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        fetch(&wires[i]);
    }
}

/* Passes all values on, of which none is newer than another. */
static void exchange(size_t count)
{
    fetch_all(count);
    for (size_t i = 0; i < count; ++i) {
        set(&components[wires[i].to], wires[i].to_type, wires[i].target, wires[i].value);
    }
}

static void row(size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        fetch(&seen[i]);
        fwrite(&seen[i].value, sizeof(double), 1, stdout);
    }
}

int main(int arguments, char **given)
{
    unsigned parts, links, columns;
    FILE *const plan = arguments == 6 ? fopen(given[1], "r") : NULL;
    if (plan == NULL || fscanf(plan, "%u %u %u", &parts, &links, &columns) != 3 || parts > COMPONENTS ||
        links > WIRES || columns > SEEN) {
        return 2;
    }
    for (unsigned i = 0; i < parts; ++i) {
        load(&components[i], plan);
    }
    for (unsigned i = 0; i < links + columns; ++i) { /* the receiver of a column is not looked at */
        Wire *w = i < links ? &wires[i] : &seen[i - links];
        if (fscanf(plan, " %u %c %u %u %c %u %lf %lf", &w->from, &w->from_type, &w->source, &w->to, &w->to_type,
                   &w->target, &w->factor, &w->offset) != 8) {
            return 2;
        }
    }
    Mode leave;
    for (unsigned i = 0; i < parts; ++i) {
        find(&components[i], "fmi2ExitInitializationMode", &leave);
        check(leave(components[i].instance), "fmi2ExitInitializationMode");
    }
    const double step = strtod(given[2], NULL);
    const long count = atol(given[3]), interval = atol(given[4]);
    const int in_order = strcmp(given[5], "sequential") == 0, exchanged = strcmp(given[5], "exchanged") == 0;
    row(columns);
    exchange(in_order ? 0 : links);
    for (long k = 0; k < count; ++k) {
        for (unsigned c = 0; c < parts; ++c) {
            for (unsigned i = 0; in_order && i < links; ++i) {
                if (wires[i].to == c) {
                    fetch(&wires[i]);
                    set(&components[c], wires[i].to_type, wires[i].target, wires[i].value);
                }
            }
            check(components[c].step(components[c].instance, (double)k * step, step, fmi2True), "fmi2DoStep");
        }
        if (exchanged) {
            exchange(links);
            fetch_all(links); /* a block at an instant of its own holds what it last gave */
        }
        if ((k + 1) % interval == 0) {
            row(columns);
        }
        if (!in_order && !exchanged) {
            exchange(links);
        }
    }
    return 0;
}
