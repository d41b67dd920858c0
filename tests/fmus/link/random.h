/* Random numbers and damage for the fuzz programs. */
#ifndef RANDOM_H
#define RANDOM_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static uint64_t seed;

static unsigned pick(unsigned n)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(seed >> 33) % n;
}

/* Leaves a frame as it is, changes some of its bits, cuts it, or puts other bytes before it; its size then. */
static size_t damage(uint8_t *frame, size_t n, size_t room)
{
    const unsigned kind = pick(8);
    if (kind == 0) {
        return pick((unsigned)n + 1);
    }
    if (kind == 1 && n + 8 <= room) {
        memmove(frame + 8, frame, n);
        for (size_t i = 0; i < 8; ++i) {
            frame[i] = pick(3) == 0 ? (uint8_t)(pick(2) == 0 ? 0xA5 : 0x5A) : (uint8_t)pick(256);
        }
        return n + 8;
    }
    for (unsigned k = kind < 5 ? 1 + pick(4) : 0; k > 0; --k) {
        const size_t at = pick(2) == 0 ? pick((unsigned)n) : pick(n < 14 ? (unsigned)n : 14);
        frame[at] = (uint8_t)(frame[at] ^ (1u << pick(8)));
    }
    return n;
}

#endif
