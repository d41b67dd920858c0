/* An FMU that plays the rows of resources/telemetry.bin back at their own instants. One library serves any record: the
 * file says how many ports there are. fmus/telemetry/__init__.py writes it and describes it.
 *
 * Value references, in their order: hold, shift, rows, age, ended; then of each port its elements, valid, sample. */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "fmi2.h"
#include "record_file.h"

enum { GUID = 40, MAGIC = 8, PORTS_MAX = 512, VALUES_MAX = 4096, BUFFER = 8192 /* doubles */ };
enum { HOLD, SHIFT, ROWS, AGE, ENDED, FIRST };

typedef struct {
    char magic[MAGIC], guid[GUID];
    uint32_t ports, values;
    uint64_t rows;
} Head;

typedef struct {
    uint32_t size, first; /* elements, and the place of the first among the values of a row */
    fmi2ValueReference reference;
    double time; /* of its last sample */
    int sample;
    bool fresh;
} Port;

typedef struct {
    fmi2CallbackFunctions calls;
    char name[128];
    Head head;
    Port ports[PORTS_MAX];
    RecordFile file;
    double values[VALUES_MAX], buffer[BUFFER];
    size_t at, filled; /* of the buffer */
    uint64_t read;     /* rows that have gone from the file into the buffer */
    double hold, shift, start, now, last;
    int rows;
    bool begun; /* the rows up to the start have been taken */
} Telemetry;

static fmi2Status refuse(const Telemetry *t, const char *message)
{
    if (t->calls.logger != NULL) {
        t->calls.logger(t->calls.componentEnvironment, t->name, fmi2Error, "logStatusError", "%s", message);
    }
    return fmi2Error;
}

static size_t width(const Telemetry *t)
{
    return 1 + (size_t)t->head.values;
}

/* The next row, or NULL behind the last one or where the file ends early. */
static const double *peek(Telemetry *t)
{
    if (t->at == t->filled) {
        uint64_t want = t->head.rows - t->read;
        if (want > BUFFER / width(t)) {
            want = BUFFER / width(t);
        }
        const size_t bytes = (size_t)want * width(t) * sizeof(double);
        if (want == 0 || !record_read(&t->file, t->buffer, bytes)) {
            return NULL;
        }
        t->read += want;
        t->at = 0;
        t->filled = (size_t)want * width(t);
    }
    return t->buffer + t->at;
}

/* Takes a row: a port with an element that is missing (NaN) keeps its last sample. */
static void take(Telemetry *t, const double *row)
{
    t->last = row[0];
    t->rows += 1;
    for (uint32_t i = 0; i < t->head.ports; ++i) {
        Port *p = &t->ports[i];
        bool whole = true;
        for (uint32_t k = p->first; k < p->first + p->size; ++k) {
            whole = whole && row[1 + k] - row[1 + k] == 0.0;
        }
        if (whole) {
            memcpy(t->values + p->first, row + 1 + p->first, p->size * sizeof(double));
            p->time = row[0];
            p->sample += 1;
            p->fresh = true;
        }
    }
    t->at += width(t);
}

static void advance(Telemetry *t, double until)
{
    const double *row;
    t->now = until - t->shift;
    for (uint32_t i = 0; i < t->head.ports; ++i) {
        t->ports[i].fresh = false;
    }
    while ((row = peek(t)) != NULL && row[0] <= t->now + 1e-9) {
        take(t, row);
    }
}

static bool rewind_record(Telemetry *t)
{
    t->at = t->filled = 0;
    t->read = 0;
    t->rows = 0;
    t->now = t->last = 0.0;
    t->begun = false;
    memset(t->values, 0, sizeof t->values);
    for (uint32_t i = 0; i < t->head.ports; ++i) {
        t->ports[i].sample = 0;
        t->ports[i].fresh = false;
    }
    return record_seek(&t->file, sizeof(Head) + (uint64_t)t->head.ports * sizeof(uint32_t));
}

static bool open_record(Telemetry *t, const char *resources, const char *guid)
{
    uint32_t sizes[PORTS_MAX];
    if (!record_open(&t->file, resources) || !record_read(&t->file, &t->head, sizeof t->head)) {
        refuse(t, "resources/telemetry.bin cannot be read");
        return false;
    }
    const Head *h = &t->head;
    if (strcmp(h->magic, "TELEM1") != 0 || strcmp(h->guid, guid) != 0 || h->ports > PORTS_MAX ||
        h->values > VALUES_MAX || !record_read(&t->file, sizes, h->ports * sizeof(uint32_t))) {
        refuse(t, "resources/telemetry.bin is not that of this modelDescription.xml");
        return false;
    }
    fmi2ValueReference reference = FIRST;
    uint32_t first = 0;
    for (uint32_t i = 0; i < h->ports; ++i) {
        t->ports[i] = (Port){.size = sizes[i], .first = first, .reference = reference};
        reference += sizes[i] + 2;
        first += sizes[i];
    }
    return first == h->values && rewind_record(t);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *calls, fmi2Boolean visible, fmi2Boolean log)
{
    (void)visible, (void)log;
    if (calls == NULL || calls->allocateMemory == NULL || calls->freeMemory == NULL || type != fmi2CoSimulation ||
        resources == NULL || guid == NULL) {
        return NULL;
    }
    Telemetry *t = calls->allocateMemory(1, sizeof *t);
    if (t == NULL) {
        return NULL;
    }
    t->calls = *calls;
    for (size_t i = 0; name != NULL && name[i] != '\0' && i < sizeof t->name - 1; ++i) {
        t->name[i] = name[i];
    }
    if (!open_record(t, resources, guid)) {
        fmi2FreeInstance(t);
        return NULL;
    }
    return t;
}

void fmi2FreeInstance(fmi2Component c)
{
    Telemetry *t = c;
    if (t != NULL) {
        record_close(&t->file);
        t->calls.freeMemory(t);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real start, fmi2Boolean s,
                               fmi2Real stop)
{
    (void)d, (void)tolerance, (void)s, (void)stop;
    ((Telemetry *)c)->start = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

/* The row of the start and those before it are taken at the first Get, so that shift may be set before. */
static bool prepared(Telemetry *t)
{
    if (!t->begun) {
        if (!rewind_record(t)) {
            return false;
        }
        advance(t, t->start);
        t->begun = true;
    }
    return true;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return prepared(c) ? fmi2OK : refuse(c, "resources/telemetry.bin cannot be read");
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    Telemetry *t = c;
    t->hold = t->shift = t->start = 0.0;
    return rewind_record(t) ? fmi2OK : refuse(t, "resources/telemetry.bin cannot be read");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no_set_state_before)
{
    (void)no_set_state_before;
    Telemetry *t = c;
    if (!prepared(t)) {
        return refuse(t, "resources/telemetry.bin cannot be read");
    }
    advance(t, time + h);
    if ((uint64_t)t->rows < t->head.rows && peek(t) == NULL) {
        return refuse(t, "resources/telemetry.bin ends before its last row");
    }
    return fmi2OK;
}

static const Port *port_of(const Telemetry *t, fmi2ValueReference reference)
{
    for (uint32_t i = t->head.ports; i-- > 0;) {
        if (reference >= t->ports[i].reference) {
            return reference < t->ports[i].reference + t->ports[i].size + 2 ? &t->ports[i] : NULL;
        }
    }
    return NULL;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] == HOLD || r[i] == SHIFT) {
            v[i] = r[i] == HOLD ? t->hold : t->shift;
        } else if (r[i] == AGE) {
            v[i] = t->rows > 0 ? t->now - t->last : 0.0;
        } else if (p != NULL && r[i] < p->reference + p->size) {
            v[i] = t->values[p->first + r[i] - p->reference];
        } else {
            return refuse(t, "fmi2GetReal: there is no Real variable with this value reference");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] != ROWS && (p == NULL || r[i] != p->reference + p->size + 1)) {
            return refuse(t, "fmi2GetInteger: there is no Integer variable with this value reference");
        }
        v[i] = r[i] == ROWS ? t->rows : p->sample;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
{
    Telemetry *t = c;
    if (!prepared(t)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        const Port *p = port_of(t, r[i]);
        if (r[i] == ENDED) {
            v[i] = (uint64_t)t->rows == t->head.rows;
        } else if (p != NULL && r[i] == p->reference + p->size) {
            v[i] = p->fresh || (p->sample > 0 && t->now - p->time <= t->hold);
        } else {
            return refuse(t, "fmi2GetBoolean: there is no Boolean variable with this value reference");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[])
{
    Telemetry *t = c;
    for (size_t i = 0; i < n; ++i) {
        if (r[i] > SHIFT || !(v[i] - v[i] == 0.0)) {
            return refuse(t, "fmi2SetReal: expected hold or shift, and a finite number");
        }
        *(r[i] == HOLD ? &t->hold : &t->shift) = v[i];
        t->begun = t->begun && r[i] != SHIFT;
    }
    return fmi2OK;
}
