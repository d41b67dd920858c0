#ifndef PYTHON_HANDED_THROUGH_H
#define PYTHON_HANDED_THROUGH_H

#include "fmi2.h"

/* Every function that is handed through: its name, its parameters, and the arguments behind the component. */
#define HANDED_THROUGH(X)                                                                                              \
    X(fmi2SetupExperiment, (fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f),        \
      (I, a, b, d, e, f))                                                                                              \
    X(fmi2EnterInitializationMode, (fmi2Component c), (I))                                                             \
    X(fmi2ExitInitializationMode, (fmi2Component c), (I))                                                              \
    X(fmi2Terminate, (fmi2Component c), (I))                                                                           \
    X(fmi2Reset, (fmi2Component c), (I))                                                                               \
    X(fmi2GetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]), (I, r, n, v))              \
    X(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]), (I, r, n, v))        \
    X(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]), (I, r, n, v))        \
    X(fmi2GetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]), (I, r, n, v))          \
    X(fmi2SetReal, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]), (I, r, n, v))        \
    X(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]), (I, r, n, v))  \
    X(fmi2SetString, (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]), (I, r, n, v))    \
    X(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate * s), (I, s))                                                    \
    X(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate s), (I, s))                                                      \
    X(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate s, size_t *n), (I, s, n))                             \
    X(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n), (I, s, b, n))                  \
    X(fmi2DeSerializeFMUstate, (fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s), (I, b, n, s))         \
    X(fmi2GetDirectionalDerivative,                                                                                    \
      (fmi2Component c, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], size_t m,                \
       const fmi2Real x[], fmi2Real y[]),                                                                              \
      (I, u, n, k, m, x, y))                                                                                           \
    X(fmi2SetRealInputDerivatives,                                                                                     \
      (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[]),            \
      (I, r, n, o, v))                                                                                                 \
    X(fmi2GetRealOutputDerivatives,                                                                                    \
      (fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[]), (I, r, n, o, v)) \
    X(fmi2DoStep, (fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean b), (I, t, h, b))                              \
    X(fmi2CancelStep, (fmi2Component c), (I))                                                                          \
    X(fmi2GetStatus, (fmi2Component c, fmi2StatusKind k, fmi2Status * v), (I, k, v))                                   \
    X(fmi2GetRealStatus, (fmi2Component c, fmi2StatusKind k, fmi2Real * v), (I, k, v))                                 \
    X(fmi2GetIntegerStatus, (fmi2Component c, fmi2StatusKind k, fmi2Integer * v), (I, k, v))                           \
    X(fmi2GetBooleanStatus, (fmi2Component c, fmi2StatusKind k, fmi2Boolean * v), (I, k, v))                           \
    X(fmi2GetStringStatus, (fmi2Component c, fmi2StatusKind k, fmi2String * v), (I, k, v))

#endif
