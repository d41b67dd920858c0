#include "noise.h"

#include <math.h>

Words plant_sensors_philox(Words counter, uint32_t key_low, uint32_t key_high)
{
    for (int i = 0; i < 10; ++i) {
        const uint64_t x = (uint64_t)counter.word[0] * 0xD2511F53u, y = (uint64_t)counter.word[2] * 0xCD9E8D57u;
        counter = (Words){{(uint32_t)(y >> 32) ^ counter.word[1] ^ key_low, (uint32_t)y,
                           (uint32_t)(x >> 32) ^ counter.word[3] ^ key_high, (uint32_t)x}};
        key_low += 0x9E3779B9u;
        key_high += 0xBB67AE85u;
    }
    return counter;
}

/* The middle of one of 2^52 equal parts of (0, 1). */
static double uniform(uint32_t high, uint32_t low)
{
    const uint64_t part = ((uint64_t)high << 32 | low) >> 12;
    return ((double)part + 0.5) * 0x1p-52;
}

static Words random_words(Draw draw, uint32_t pair)
{
    const uint64_t number = (uint64_t)draw.sample;
    const Words counter = {{(uint32_t)number, (uint32_t)(number >> 32), draw.sensor, pair}};
    return plant_sensors_philox(counter, (uint32_t)draw.seed, 0u);
}

void plant_sensors_normal_pair(Draw draw, uint32_t pair, double out[2])
{
    const Words random = random_words(draw, pair);
    const double radius = sqrt(-2.0 * log(uniform(random.word[0], random.word[1])));
    const double angle = 6.28318530717958647693 * uniform(random.word[2], random.word[3]);
    out[0] = radius * cos(angle);
    out[1] = radius * sin(angle);
}

Vector plant_sensors_normals(Draw draw)
{
    double xy[2], z[2];
    plant_sensors_normal_pair(draw, 0, xy);
    plant_sensors_normal_pair(draw, 1, z);
    return (Vector){xy[0], xy[1], z[0]};
}

double plant_sensors_uniform(Draw draw)
{
    const Words random = random_words(draw, 0);
    return uniform(random.word[0], random.word[1]);
}
