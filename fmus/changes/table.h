/* What happens to signals on their way: channels and operations, as resources/changes.bin has them. */
#ifndef CHANGES_TABLE_H
#define CHANGES_TABLE_H

#include <stdbool.h>
#include <stdint.h>

#include "host.h"

enum { GUID = 40, MAGIC = 8, CHANNELS_MAX = 512, OPERATIONS_MAX = 4096 };
typedef enum { REAL, INTEGER, BOOLEAN } Type;
typedef enum { REPLACE, ADD, FREEZE } Kind;

typedef struct {
    char magic[MAGIC], guid[GUID];
    uint32_t channels, operations;
} Head;

/* One element: value reference 2 i is its input, 2 i + 1 its output. */
typedef struct {
    uint32_t type, fed, delayed, unused; /* fed: it has an input */
    double input, start;                 /* at t = 0; start: of the output, where it is delayed or not fed */
} Channel;

typedef struct {
    uint32_t channel, kind;
    uint32_t before;   /* whether what it acts on belongs to the beginning of a step, else to its end */
    uint32_t at_start; /* whether it acts in initialization mode */
    double from, until, value;
} Operation;

typedef struct {
    bool acts, frozen;
} Acting;

typedef struct {
    Host host; /* first */
    Head head;
    Channel channels[CHANNELS_MAX];
    Operation operations[OPERATIONS_MAX];
    Acting acting[OPERATIONS_MAX];
    double frozen[OPERATIONS_MAX];
    double inputs[CHANNELS_MAX], before[CHANNELS_MAX], delayed[CHANNELS_MAX];
} Changes;

/* Reads the table of this GUID; else false with a reason. */
bool table_open(Changes *c, const char *resources, const char *guid, const char **reason);

/* All as before initialization. */
void table_reset(Changes *c);

/* The inputs of now are those that delayed outputs show after the first step. */
void table_begin(Changes *c);

/* A step from t to t + h: delays go on, and it is seen which operations act. */
void table_step(Changes *c, double t, double h);

/* The output of a channel, as its input stands. */
double table_output(const Changes *c, uint32_t channel);

#endif
