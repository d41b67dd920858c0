/* What leaves the block is finite. Generated from its interface; do not edit. Requirement: FC-4. */
#ifndef ACTUATORS_GUARD_H
#define ACTUATORS_GUARD_H

#include "actuators_ports.h"
#include "finite.h"

/* What the guard promises, for the proof: of each number that it is finite. */
#ifdef __FRAMAC__
#define ACTUATORS_FINITE \
    ensures \result ==> (0 <= any_place < 3 ==> \is_finite((&y->coil[0])[any_place])); \
    ensures \result ==> \is_finite(y->wheel_motor); \
    ensures \result ==> \is_finite(y->field_on_wheel);
#endif

/* Notes a number that is not finite; false. */
/*@ assigns *f;
    ensures !\result; */
static inline bool actuators_refuse(const ActuatorsOutputs *y, Fault *f)
{
    if (!run_finite(&y->coil[0], 3)) {
        return not_finite(&y->coil[0], 3, "coil", f);
    }
    if (!is_number(y->wheel_motor)) {
        return not_finite(&y->wheel_motor, 1, "wheel_motor", f);
    }
    if (!is_number(y->field_on_wheel)) {
        return not_finite(&y->field_on_wheel, 1, "field_on_wheel", f);
    }
    return false;
}

/* Whether each number is finite; else the fault names an output that has one that is not. */
/*@ requires \separated(y, f);
    assigns *f;
    ACTUATORS_FINITE */
static inline bool actuators_guard(const ActuatorsOutputs *y, Fault *f)
{
    if (run_finite(&y->coil[0], 3) &&
        is_number(y->wheel_motor) &&
        is_number(y->field_on_wheel)) {
        return true;
    }
    return actuators_refuse(y, f);
}

#endif
