/* A record's rows: those up to a time are taken, each port keeps its last sample. */
#ifndef TELEMETRY_ROWS_H
#define TELEMETRY_ROWS_H

#include <stdbool.h>
#include <stdint.h>

#include "host.h"
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
    Host host; /* first */
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

/* Takes the rows up to a time of the host. */
void rows_advance(Telemetry *t, double until);

/* The next row, or NULL behind the last one or where the file ends early. */
const double *rows_peek(Telemetry *t);

/* Back before the first row; false where the file cannot be read. */
bool rows_rewind(Telemetry *t);

/* Reads the head of the record of this GUID; else false with a reason. */
bool rows_open(Telemetry *t, const char *resources, const char *guid, const char **reason);

#endif
