/* The last look at the outputs, whatever was computed before: what is not finite leaves no flight software.
 * Requirement: FC-4. Tests: tests/native/test_direct.py. */
#include "guard.h"

#include "finite.h"

/*@ axiomatic AnyRow { logic integer any_row; } */

/* The reference to come. */
/*@ requires \valid_read(y);
    assigns \nothing;
    ensures \result && 0 <= any_place < SUPERVISOR_AHEAD ==> \is_finite(y->t_ahead[any_place]);
    ensures \result && 0 <= any_row < SUPERVISOR_AHEAD && 0 <= any_place < 3 ==>
        \is_finite(y->turn_ahead[any_row][any_place]) && \is_finite(y->Omega_ahead[any_row][any_place]); */
static bool is_ahead_finite(const SupervisorOutputs *y)
{
    bool all = run_finite(y->t_ahead, SUPERVISOR_AHEAD);
    /*@ loop invariant 0 <= k <= SUPERVISOR_AHEAD;
        loop invariant all && 0 <= any_place < SUPERVISOR_AHEAD ==> \is_finite(y->t_ahead[any_place]);
        loop invariant all && 0 <= any_row < k && 0 <= any_place < 3 ==> \is_finite(y->turn_ahead[any_row][any_place]);
        loop invariant all && 0 <= any_row < k && 0 <= any_place < 3 ==> \is_finite(y->Omega_ahead[any_row][any_place]);
        loop assigns k, all; */
    for (int k = 0; k < SUPERVISOR_AHEAD; ++k) {
        if (!run_finite(y->turn_ahead[k], 3)) {
            all = false;
        }
        //@ assert any_row == k && all && 0 <= any_place < 3 ==> \is_finite(y->turn_ahead[any_row][any_place]);
        if (!run_finite(y->Omega_ahead[k], 3)) {
            all = false;
        }
        //@ assert any_row == k && all && 0 <= any_place < 3 ==> \is_finite(y->Omega_ahead[any_row][any_place]);
    }
    return all;
}

/*@ requires \valid_read(y) && \valid(f) && \separated(y, f);
    assigns *f;
    ensures \result && 0 <= any_place < 3 ==>
        \is_finite(y->R_ref[0][any_place]) && \is_finite(y->R_ref[1][any_place]) && \is_finite(y->R_ref[2][any_place]);
    ensures \result && 0 <= any_place < 3 ==>
        \is_finite(y->Omega_ref[any_place]) && \is_finite(y->dOmega_ref[any_place]);
    ensures \result && 0 <= any_place < SUPERVISOR_AHEAD ==> \is_finite(y->t_ahead[any_place]);
    ensures \result && 0 <= any_row < SUPERVISOR_AHEAD && 0 <= any_place < 3 ==>
        \is_finite(y->turn_ahead[any_row][any_place]) && \is_finite(y->Omega_ahead[any_row][any_place]);
    ensures \result ==> \is_finite(y->slew_remaining) && \is_finite(y->target_elevation); */
bool supervisor_guard(const SupervisorOutputs *y, Fault *f)
{
    static const char *const expected = "a finite number for this output";
    if (!run_finite(y->R_ref[0], 3) || !run_finite(y->R_ref[1], 3) || !run_finite(y->R_ref[2], 3)) {
        return fault(f, "R_ref", NAN, expected);
    }
    if (!run_finite(y->Omega_ref, 3)) {
        return fault(f, "Omega_ref", NAN, expected);
    }
    if (!run_finite(y->dOmega_ref, 3)) {
        return fault(f, "dOmega_ref", NAN, expected);
    }
    if (!is_ahead_finite(y)) {
        return fault(f, "turn_ahead", NAN, expected);
    }
    if (!is_number(y->slew_remaining)) {
        return fault(f, "slew_remaining", NAN, expected);
    }
    return is_number(y->target_elevation) || fault(f, "target_elevation", NAN, expected);
}
