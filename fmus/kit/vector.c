/* Plays a test vector through the block, behind the FMI functions that the FMU exports, and compares its outputs.
 * Use: vector FOLDER [TOLERANCE]     FOLDER/parameters.csv: name,value     FOLDER/vector.csv: time, inputs, outputs
 * The tolerance is relative to the largest value of each output. Exit status 0 where all outputs are within it, else
 * 1. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

enum { LINE_SIZE = 1 << 16, COLUMNS_MAX = 1024 };

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String text, ...)
{
    va_list arguments;
    (void)environment, (void)category;
    if (status != fmi2OK) {
        fprintf(stderr, "%s: ", name);
        va_start(arguments, text);
        vfprintf(stderr, text, arguments);
        va_end(arguments);
        fprintf(stderr, "\n");
    }
}

static void *allocate(size_t n, size_t size)
{
    return calloc(n, size);
}

static void give_up(const char *what)
{
    fprintf(stderr, "vector: %s\n", what);
    exit(1);
}

/* Takes `x[1][2]`, as it stands in a table, for `x[1,2]`. */
static fmi2ValueReference reference_of(const char *label)
{
    char name[256];
    size_t n = 0;
    for (const char *c = label; *c != '\0' && n + 1 < sizeof name; ++c) {
        if (c[0] == ']' && c[1] == '[') {
            name[n++] = ',';
            ++c;
        } else {
            name[n++] = *c;
        }
    }
    name[n] = '\0';
    for (fmi2ValueReference r = 0; r < BLOCK_VARIABLES; ++r) {
        if (strcmp(variables[r].name, name) == 0) {
            return r;
        }
    }
    fprintf(stderr, "vector: the block has no variable %s\n", name);
    exit(1);
}

static void set(fmi2Component c, fmi2ValueReference r, const char *text)
{
    const fmi2Real real = strtod(text, NULL);
    const fmi2Integer integer = (fmi2Integer)real;
    const fmi2Boolean boolean = real != 0.0 ? fmi2True : fmi2False;
    fmi2Status status = fmi2Error;
    switch (variables[r].kind) {
    case KIND_REAL:
        status = fmi2SetReal(c, &r, 1, &real);
        break;
    case KIND_INTEGER:
        status = fmi2SetInteger(c, &r, 1, &integer);
        break;
    case KIND_BOOLEAN:
        status = fmi2SetBoolean(c, &r, 1, &boolean);
        break;
    case KIND_STRING:
        status = fmi2SetString(c, &r, 1, &text);
        break;
    }
    if (status != fmi2OK) {
        give_up("a value of the table was refused");
    }
}

static double get(fmi2Component c, fmi2ValueReference r)
{
    fmi2Real real = NAN;
    fmi2Integer integer = 0;
    fmi2Boolean boolean = fmi2False;
    fmi2Status status = fmi2Error;
    switch (variables[r].kind) {
    case KIND_REAL:
        status = fmi2GetReal(c, &r, 1, &real);
        break;
    case KIND_INTEGER:
        status = fmi2GetInteger(c, &r, 1, &integer);
        real = integer;
        break;
    case KIND_BOOLEAN:
        status = fmi2GetBoolean(c, &r, 1, &boolean);
        real = boolean == fmi2False ? 0.0 : 1.0;
        break;
    case KIND_STRING:
        break;
    }
    if (status != fmi2OK) {
        give_up("an output could not be read");
    }
    return real;
}

/* The next line, cut at its commas; the number of cells, 0 at the end. */
static int read_row(FILE *in, char line[LINE_SIZE], char *cells[COLUMNS_MAX])
{
    int n = 0;
    if (fgets(line, LINE_SIZE, in) == NULL) {
        return 0;
    }
    line[strcspn(line, "\r\n")] = '\0';
    for (char *c = line; c != NULL && n < COLUMNS_MAX;) {
        cells[n++] = c;
        c = strchr(c, ',');
        if (c != NULL) {
            *c++ = '\0';
        }
    }
    return n;
}

static FILE *open_table(const char *folder, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *in = fopen(path, "r");
    if (in == NULL) {
        perror(path);
        exit(1);
    }
    return in;
}

/* The comparison of each column. */
static char line[LINE_SIZE];
static char *cells[COLUMNS_MAX];
static fmi2ValueReference references[COLUMNS_MAX];
static double worst[COLUMNS_MAX], peak[COLUMNS_MAX], when[COLUMNS_MAX];

static void set_parameters(fmi2Component c, const char *folder)
{
    FILE *table = open_table(folder, "parameters.csv");
    read_row(table, line, cells); /* name,value */
    while (read_row(table, line, cells) == 2) {
        set(c, reference_of(cells[0]), cells[1]);
    }
    fclose(table);
}

/* Compares the row's outputs at a time. */
static void compare(fmi2Component c, int columns, double time)
{
    for (int i = 1; i < columns; ++i) {
        if (variables[references[i]].causality == CAUSALITY_OUTPUT) {
            const double expected = strtod(cells[i], NULL), difference = fabs(get(c, references[i]) - expected);
            peak[i] = fmax(peak[i], fabs(expected));
            if (difference > worst[i] || isnan(difference)) {
                worst[i] = isnan(difference) ? INFINITY : difference;
                when[i] = time;
            }
        }
    }
}

/* Plays vector.csv through the block; returns the number of its columns. */
static int play(fmi2Component c, const char *folder, int *rows)
{
    FILE *table = open_table(folder, "vector.csv");
    const int n = read_row(table, line, cells);
    for (int i = 1; i < n; ++i) {
        references[i] = reference_of(cells[i]);
    }
    double last = 0.0;
    for (*rows = 0; read_row(table, line, cells) == n; ++*rows) {
        const double time = strtod(cells[0], NULL);
        if (*rows == 0 && fmi2EnterInitializationMode(c) != fmi2OK) {
            give_up("initialization failed");
        }
        for (int i = 1; i < n; ++i) {
            if (variables[references[i]].causality == CAUSALITY_INPUT) {
                set(c, references[i], cells[i]);
            }
        }
        if ((*rows == 0 ? fmi2ExitInitializationMode(c) : fmi2DoStep(c, last, time - last, fmi2True)) != fmi2OK) {
            give_up(*rows == 0 ? "initialization failed" : "a step failed");
        }
        last = time;
        compare(c, n, time);
    }
    fclose(table);
    return n;
}

/* Prints the differences; returns how many outputs differ by more than the tolerance. */
static int report(int columns, int rows, double tolerance)
{
    int wrong = 0;
    printf("%d rows, tolerance %g of the largest value\n\n        %-24s %12s %10s  %s\n", rows, tolerance, "output",
           "difference", "relative", "at");
    for (int i = 1; i < columns; ++i) {
        const Variable *v = &variables[references[i]];
        if (v->causality == CAUSALITY_OUTPUT) {
            const double relative = peak[i] > 0.0 ? worst[i] / peak[i] : worst[i];
            const int within = relative <= tolerance || worst[i] <= 1e-15; /* which is rounding */
            wrong += !within;
            printf("%s  %-24s %12.4g %10.2g", within ? "ok    " : "DIFFER", v->name, worst[i], relative);
            if (worst[i] > 0.0) {
                printf("  %g s", when[i]);
            }
            printf("\n");
        }
    }
    printf("\n%s\n", wrong == 0 ? "all outputs are as expected" : "outputs differ from what is expected");
    return wrong;
}

int main(int argc, char **argv)
{
    const fmi2CallbackFunctions callbacks = {log_message, allocate, free, NULL, NULL};
    if (argc < 2) {
        give_up("use: vector FOLDER [TOLERANCE]");
    }
    const double tolerance = argc > 2 ? strtod(argv[2], NULL) : 1e-6;
    fmi2Component c = fmi2Instantiate("vector", fmi2CoSimulation, BLOCK_GUID, "", &callbacks, fmi2False, fmi2False);
    if (c == NULL || fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) != fmi2OK) {
        give_up("the block could not be instantiated");
    }
    int rows;
    set_parameters(c, argv[1]);
    const int columns = play(c, argv[1], &rows);
    fmi2Terminate(c);
    fmi2FreeInstance(c);
    return report(columns, rows, tolerance) == 0 ? 0 : 1;
}
