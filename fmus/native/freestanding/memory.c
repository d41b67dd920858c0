/* The functions that compilers call by themselves, for FMUs that are linked with no C library at all.
 * Tests: tests/native/test_memory.py. */
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-loop-distribute-patterns") /* which makes a call of memcpy of its loop */
#endif

#if __SIZEOF_POINTER__ == 8
typedef uint64_t __attribute__((may_alias, aligned(1))) Word;
/* In this order: gcc takes a vector whose size comes last as aligned. */
typedef uint64_t __attribute__((vector_size(32), may_alias, aligned(1))) Words;

/* Copies whole Words; returns how many bytes they are. */
static inline size_t copy_words(unsigned char *t, const unsigned char *f, size_t n)
{
    size_t i = 0;
    for (; n - i >= 4 * sizeof(Words); i += 4 * sizeof(Words)) {
        const Words a = *(const Words *)(f + i), b = *(const Words *)(f + i + sizeof(Words));
        const Words c = *(const Words *)(f + i + 2 * sizeof(Words)), d = *(const Words *)(f + i + 3 * sizeof(Words));
        *(Words *)(t + i) = a;
        *(Words *)(t + i + sizeof(Words)) = b;
        *(Words *)(t + i + 2 * sizeof(Words)) = c;
        *(Words *)(t + i + 3 * sizeof(Words)) = d;
    }
    for (; n - i >= sizeof(Words); i += sizeof(Words)) {
        *(Words *)(t + i) = *(const Words *)(f + i);
    }
    return i;
}
#else
typedef uint32_t __attribute__((may_alias, aligned(1))) Word;
/* What a small processor moves with few instructions, where both ends are aligned. */
typedef struct __attribute__((may_alias)) {
    uint32_t word[6]; /* three double */
} Words;

static inline size_t copy_words(unsigned char *t, const unsigned char *f, size_t n)
{
    size_t left = n;
    if ((((uintptr_t)t | (uintptr_t)f) & (_Alignof(Words) - 1)) == 0) {
        for (; left >= sizeof(Words); left -= sizeof(Words), t += sizeof(Words), f += sizeof(Words)) {
            *(Words *)t = *(const Words *)f;
        }
    }
    return n - left;
}
#endif

void *(memcpy)(void *restrict to, const void *restrict from, size_t n)
{
    const size_t copied = copy_words(to, from, n);
    unsigned char *t = (unsigned char *)to + copied;
    const unsigned char *f = (const unsigned char *)from + copied;
    n -= copied;
#pragma clang loop vectorize(disable) unroll(disable)
    for (; n >= sizeof(Word); n -= sizeof(Word), t += sizeof(Word), f += sizeof(Word)) {
        *(Word *)t = *(const Word *)f;
    }
    while (n-- > 0) {
        *t++ = *f++;
    }
    return to;
}

void *(memset)(void *to, int byte, size_t n)
{
    unsigned char *t = to;
    const Word word = (Word)-1 / 255u * (unsigned char)byte;
    for (; n >= sizeof(Word); n -= sizeof(Word), t += sizeof(Word)) {
        *(Word *)t = word;
    }
    while (n-- > 0) {
        *t++ = (unsigned char)byte;
    }
    return to;
}

int memcmp(const void *left, const void *right, size_t n)
{
    const unsigned char *l = left, *r = right;
    while (n >= sizeof(Word) && *(const Word *)l == *(const Word *)r) {
        n -= sizeof(Word), l += sizeof(Word), r += sizeof(Word);
    }
    for (; n > 0; --n, ++l, ++r) {
        if (*l != *r) {
            return *l - *r;
        }
    }
    return 0;
}

size_t strlen(const char *text)
{
    size_t n = 0;
    while (text[n] != '\0') {
        ++n;
    }
    return n;
}

int strcmp(const char *left, const char *right)
{
    while (*left != '\0' && *left == *right) {
        ++left;
        ++right;
    }
    return (unsigned char)*left - (unsigned char)*right;
}

#if defined(_WIN32)
int _fltused; /* its presence says that floating point is used */

int __stdcall DllMainCRTStartup(void *module, unsigned long reason, void *reserved);

int __stdcall DllMainCRTStartup(void *module, unsigned long reason, void *reserved)
{
    (void)module, (void)reason, (void)reserved;
    return 1;
}
#endif
