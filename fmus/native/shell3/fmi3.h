/* The part of FMI 3.0 that a co-simulation FMU needs, as in the standard's fmi3PlatformTypes.h and fmi3FunctionTypes.h,
 * written anew so that a build needs no download; and what these files share. */
#ifndef FMI3_H
#define FMI3_H

#include "instance.h"

#if defined(_WIN32)
#define FMI3_EXPORT __declspec(dllexport)
#else
#define FMI3_EXPORT __attribute__((visibility("default")))
#endif

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef bool fmi3Clock;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;

/* The first five of FMI 2.0, by the same numbers. */
typedef fmi2Status fmi3Status;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

/* A variable as FMI 3.0 has it, at the place of its first element: the value reference is that place. */
typedef enum { ARRAY_NONE, ARRAY_FLOAT64, ARRAY_INT32, ARRAY_INT64, ARRAY_BOOLEAN, ARRAY_STRING } ArrayType;
typedef struct {
    uint16_t size; /* elements; 0: no variable begins here */
    uint16_t type;
} Array;

extern const Array arrays[BLOCK_VARIABLES];

enum { TIME = BLOCK_VARIABLES }; /* the value reference of the independent variable */

/* The instance, which from here on calls the function by this name in its messages; NULL of NULL. */
Instance *called(fmi3Instance instance, const char *function);

/* The references of all elements of these variables, in their order; NULL where something is wrong. */
Instance *elements(fmi3Instance instance, const char *function, const fmi3ValueReference references[], size_t n,
                   ArrayType type, const void *values, size_t n_values, fmi2ValueReference all[BLOCK_VARIABLES]);

#if BLOCK_DERIVATIVES
/* The derivatives of the outputs along `seeds`, by value references, where block_outputs succeeds; state NULL: in
 * initialization. Generated (fmus/native/derivatives.py). */
void block_slopes(const double values[BLOCK_VARIABLES], const double seeds[BLOCK_VARIABLES], const State *state,
                  double slopes[BLOCK_VARIABLES]);
#endif

#endif
