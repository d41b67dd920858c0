/* What watch and trial of a wheel of a set share. */
#ifndef ALLOCATOR_BOUNDED_TRIAL_H
#define ALLOCATOR_BOUNDED_TRIAL_H

#include "allocator_bounded.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

/* Of a wheel's limit: what friction may take of a command. */
static const double FRICTION = 0.05;
/* s, after which a wheel that failed is tried again; it is tried as it is found, too. */
static const double RETRY = 3000.0;

/* 1, or -1 of a wheel that is reversed. */
double allocator_bounded_sign(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i);

/* Forgets what wheel i gave of its commands. */
void allocator_bounded_forget(AllocatorBoundedState *x, int i);

/* What the trial of wheel i shows, which failed, a step of h later; `forth` is the sign by which its command counts. */
void allocator_bounded_try_again(AllocatorBoundedState *x, double forth, double h, int i);

#endif

#endif
