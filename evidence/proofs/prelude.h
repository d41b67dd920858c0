/* What this version of Frama-C lacks: signbit, and assertions that the compiler checks. */
#ifndef PROOFS_PRELUDE_H
#define PROOFS_PRELUDE_H

/*@ assigns \result \from x;
    ensures \result == 0 || \result == 1; */
extern int sign_bit_of(double x);

#define signbit(x) sign_bit_of(x)
#define _Static_assert(condition, text) extern int checked_by_the_compiler

#endif
