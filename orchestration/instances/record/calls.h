/* The record of the calls of one instance of an FMU: which functions it has, and how it is written.
 *
 * A file begins with lines of text up to an empty one: the FMU, its library, `variable TYPE REFERENCE SIZE NAME`.
 * Then come, without gaps, the calls in their order: a byte that names the function, its arguments, a byte of its
 * answer, its results. Zero in place of a function ends the file; zero in place of an answer is a call that has not
 * returned. Numbers are as a little-endian processor holds them.
 *
 *     SHAPE         function (1), number of references (4), of values (4), the references; it gets the next number
 *     Set and Get   shape (2); values, behind the answer where they are results
 *     Instantiate   name and token, each as length (4) and text
 *     values        a bit for each value that differs from the last one of its shape, in bytes; then those values
 *     texts         each as length (4) and text
 *     all others    their numbers as values of doubles; a state by its address (8) */
#ifndef CALLS_H
#define CALLS_H

#include <stddef.h>
#include <stdint.h>

enum Kind { PLAIN, INSTANTIATE, FREE, SETUP, STEP, SET, GET, STATE_GET, STATE_SET, STATE_FREE, ENDED };

/* Function, kind, version of FMI, bytes of one value (0: text). */
#define OF_TYPE(X, version, name, size)                                                                                \
    X(fmi##version##Set##name, SET, version, size) X(fmi##version##Get##name, GET, version, size)
#define FUNCTIONS(X)                                                                                                   \
    X(fmi2Instantiate, INSTANTIATE, 2, 8)                                                                              \
    X(fmi2FreeInstance, FREE, 2, 8)                                                                                    \
    X(fmi2SetupExperiment, SETUP, 2, 8)                                                                                \
    X(fmi2EnterInitializationMode, PLAIN, 2, 8)                                                                        \
    X(fmi2ExitInitializationMode, PLAIN, 2, 8)                                                                         \
    X(fmi2Terminate, PLAIN, 2, 8)                                                                                      \
    X(fmi2Reset, PLAIN, 2, 8)                                                                                          \
    X(fmi2DoStep, STEP, 2, 8)                                                                                          \
    X(fmi2GetFMUstate, STATE_GET, 2, 8)                                                                                \
    X(fmi2SetFMUstate, STATE_SET, 2, 8)                                                                                \
    X(fmi2FreeFMUstate, STATE_FREE, 2, 8)                                                                              \
    X(fmi2GetBooleanStatus, ENDED, 2, 8)                                                                               \
    OF_TYPE(X, 2, Real, 8)                                                                                             \
    OF_TYPE(X, 2, Integer, 4)                                                                                          \
    OF_TYPE(X, 2, Boolean, 4)                                                                                          \
    OF_TYPE(X, 2, String, 0)                                                                                           \
    X(fmi3InstantiateCoSimulation, INSTANTIATE, 3, 8)                                                                  \
    X(fmi3FreeInstance, FREE, 3, 8)                                                                                    \
    X(fmi3EnterInitializationMode, SETUP, 3, 8)                                                                        \
    X(fmi3ExitInitializationMode, PLAIN, 3, 8)                                                                         \
    X(fmi3Terminate, PLAIN, 3, 8)                                                                                      \
    X(fmi3Reset, PLAIN, 3, 8)                                                                                          \
    X(fmi3DoStep, STEP, 3, 8)                                                                                          \
    X(fmi3GetFMUState, STATE_GET, 3, 8)                                                                                \
    X(fmi3SetFMUState, STATE_SET, 3, 8)                                                                                \
    X(fmi3FreeFMUState, STATE_FREE, 3, 8)                                                                              \
    OF_TYPE(X, 3, Float64, 8)                                                                                          \
    OF_TYPE(X, 3, Float32, 4)                                                                                          \
    OF_TYPE(X, 3, Int8, 1)                                                                                             \
    OF_TYPE(X, 3, UInt8, 1)                                                                                            \
    OF_TYPE(X, 3, Int16, 2)                                                                                            \
    OF_TYPE(X, 3, UInt16, 2)                                                                                           \
    OF_TYPE(X, 3, Int32, 4)                                                                                            \
    OF_TYPE(X, 3, UInt32, 4)                                                                                           \
    OF_TYPE(X, 3, Int64, 8)                                                                                            \
    OF_TYPE(X, 3, UInt64, 8)                                                                                           \
    OF_TYPE(X, 3, Boolean, 1)                                                                                          \
    OF_TYPE(X, 3, String, 0)

#define NUMBER(name, kind, version, size) IS_##name,
enum Function { END, SHAPE, FUNCTIONS(NUMBER) FUNCTION_COUNT };
#undef NUMBER

#define SETUP_VALUES 5 /* tolerance defined, tolerance, start, stop defined, stop */
#define STEP_VALUES 2  /* time, step */
#define STEP_ANSWERS 4 /* FMI 3.0: event, terminate, early return, last time */

#endif
