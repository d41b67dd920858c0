/* The part of <string.h> that the shell uses, for FMUs that are linked with no C library; see memory.c. */
#ifndef FREESTANDING_STRING_H
#define FREESTANDING_STRING_H

#include <stddef.h>

#if defined(__ELF__)
#pragma GCC visibility push(hidden)
#endif
void *(memcpy)(void *restrict to, const void *restrict from, size_t n);
void *(memset)(void *to, int byte, size_t n);
int memcmp(const void *left, const void *right, size_t n);
size_t strlen(const char *text);
int strcmp(const char *left, const char *right);
#if defined(__ELF__)
#pragma GCC visibility pop
#endif

/* The compiler's own, which become plain moves where the size is small and known. */
#define memcpy(to, from, n) __builtin_memcpy(to, from, n)
#define memset(to, byte, n) __builtin_memset(to, byte, n)

#endif
