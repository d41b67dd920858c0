#include "rows.h"

#include <string.h>

static size_t width(const Telemetry *t)
{
    return 1 + (size_t)t->head.values;
}

const double *rows_peek(Telemetry *t)
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

void rows_advance(Telemetry *t, double until)
{
    const double *row;
    t->now = until - t->shift;
    for (uint32_t i = 0; i < t->head.ports; ++i) {
        t->ports[i].fresh = false;
    }
    while ((row = rows_peek(t)) != NULL && row[0] <= t->now + 1e-9) {
        take(t, row);
    }
}

bool rows_rewind(Telemetry *t)
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

bool rows_open(Telemetry *t, const char *resources, const char *guid, const char **reason)
{
    uint32_t sizes[PORTS_MAX];
    if (!record_open(&t->file, resources, "telemetry.bin") || !record_read(&t->file, &t->head, sizeof t->head)) {
        *reason = "resources/telemetry.bin cannot be read";
        return false;
    }
    const Head *h = &t->head;
    if (strcmp(h->magic, "TELEM1") != 0 || strcmp(h->guid, guid) != 0 || h->ports > PORTS_MAX ||
        h->values > VALUES_MAX || !record_read(&t->file, sizes, h->ports * sizeof(uint32_t))) {
        *reason = "resources/telemetry.bin is not that of this modelDescription.xml";
        return false;
    }
    fmi2ValueReference reference = FIRST;
    uint32_t first = 0;
    for (uint32_t i = 0; i < h->ports; ++i) {
        t->ports[i] = (Port){.size = sizes[i], .first = first, .reference = reference};
        reference += sizes[i] + 2;
        first += sizes[i];
    }
    return first == h->values && rows_rewind(t);
}
