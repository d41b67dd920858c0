/* Packs files into an FMU, which is a zip archive; nothing is compressed and no date is kept.
 * Use: pack OUT.fmu NAME_IN_ARCHIVE=FILE ... */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FILES_MAX = 64, DATE = (1 << 5) | 1 /* 1 January 1980 */ };

typedef struct {
    const char *name;
    size_t name_length;
    uint32_t crc, size, offset;
} Entry;

static uint32_t crc32_of(const unsigned char *data, size_t n)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < n; ++i) {
        crc ^= data[i];
        for (int k = 0; k < 8; ++k) {
            crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

static void put(FILE *out, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; ++i) {
        fputc((int)((value >> (8 * i)) & 0xFFu), out);
    }
}

/* The fields that a file's own header and its line in the directory share. */
static void put_common(FILE *out, const Entry *e)
{
    put(out, 0x0800, 2); /* names are UTF-8 */
    put(out, 0, 2);      /* stored */
    put(out, 0, 2);
    put(out, DATE, 2);
    put(out, e->crc, 4);
    put(out, e->size, 4);
    put(out, e->size, 4);
    put(out, (uint32_t)e->name_length, 2);
    put(out, 0, 2);
}

static unsigned char *read_all(const char *path, size_t *n)
{
    FILE *in = fopen(path, "rb");
    if (in == NULL) {
        return NULL;
    }
    size_t room = 1 << 16;
    unsigned char *data = malloc(room);
    *n = 0;
    while (data != NULL) {
        *n += fread(data + *n, 1, room - *n, in);
        if (*n < room) {
            break;
        }
        unsigned char *more = realloc(data, room *= 2);
        if (more == NULL) {
            free(data);
        }
        data = more;
    }
    fclose(in);
    return data;
}

/* Appends the file of an argument NAME=FILE; 0 where it cannot be read. */
static int put_file(FILE *out, char *argument, Entry *e)
{
    const char *equals = strchr(argument, '=');
    size_t n = 0;
    unsigned char *data = equals == NULL ? NULL : read_all(equals + 1, &n);
    if (data == NULL) {
        fprintf(stderr, "pack: cannot read %s\n", equals == NULL ? argument : equals + 1);
        return 0;
    }
    e->name = argument;
    e->name_length = (size_t)(equals - argument);
    e->crc = crc32_of(data, n);
    e->size = (uint32_t)n;
    e->offset = (uint32_t)ftell(out);
    put(out, 0x04034B50u, 4);
    put(out, 20, 2);
    put_common(out, e);
    fwrite(e->name, 1, e->name_length, out);
    fwrite(data, 1, n, out);
    free(data);
    return 1;
}

static void put_directory(FILE *out, const Entry *entries, int count)
{
    const uint32_t directory = (uint32_t)ftell(out);
    for (int i = 0; i < count; ++i) {
        const Entry *e = &entries[i];
        put(out, 0x02014B50u, 4);
        put(out, (3 << 8) | 20, 2); /* made under Unix */
        put(out, 20, 2);
        put_common(out, e);
        put(out, 0, 2);
        put(out, 0, 2);
        put(out, 0, 2);
        put(out, (strncmp(e->name, "binaries/", 9) == 0 ? 0100755u : 0100644u) << 16, 4);
        put(out, e->offset, 4);
        fwrite(e->name, 1, e->name_length, out);
    }
    const uint32_t end = (uint32_t)ftell(out);
    put(out, 0x06054B50u, 4);
    put(out, 0, 4);
    put(out, (uint32_t)count, 2);
    put(out, (uint32_t)count, 2);
    put(out, end - directory, 4);
    put(out, directory, 4);
    put(out, 0, 2);
}

int main(int argc, char **argv)
{
    static Entry entries[FILES_MAX];
    if (argc < 3 || argc - 2 > FILES_MAX) {
        fprintf(stderr, "use: pack OUT.fmu NAME_IN_ARCHIVE=FILE ...\n");
        return 2;
    }
    FILE *out = fopen(argv[1], "wb");
    if (out == NULL) {
        perror(argv[1]);
        return 1;
    }
    for (int i = 2; i < argc; ++i) {
        if (!put_file(out, argv[i], &entries[i - 2])) {
            return 1;
        }
    }
    put_directory(out, entries, argc - 2);
    if (fclose(out) != 0) {
        perror(argv[1]);
        return 1;
    }
    return 0;
}
