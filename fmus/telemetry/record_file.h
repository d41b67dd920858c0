/* A file that is read in order: by the operating system's own calls, since on Windows there is no C library. */
#ifndef RECORD_FILE_H
#define RECORD_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    intptr_t handle;
    bool open;
} RecordFile;

enum { PATH_SIZE = 1024 }; /* a function has 4 KB of stack where there is no C library */

/* file:///folder%20name/resources as /folder name/resources/NAME; on Windows without the first slash. Returns whether it
 * fits. */
bool resource_path(char path[PATH_SIZE], const char *uri, const char *name);

/* Opens a file in the folder of a file URI, as FMI 2.0 gives that of the resources. */
bool record_open(RecordFile *file, const char *resources, const char *name);

/* Reads all of these bytes; false where there are fewer. */
bool record_read(RecordFile *file, void *into, size_t bytes);

bool record_seek(RecordFile *file, uint64_t at);

void record_close(RecordFile *file);

#endif
