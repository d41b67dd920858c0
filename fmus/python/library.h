/* The library beside this one and memory, by the system's own means, so that no C runtime is needed where the system
 * has none. */
#ifndef PYTHON_LIBRARY_H
#define PYTHON_LIBRARY_H

#include <stddef.h>

#define PATH_SIZE 1024

/* PythonFMU's library, which stands beside this one; NULL where it cannot be loaded. */
void *open_library(void);

/* The address of one of its functions, NULL where it has none of the name. */
void *find(void *library, const char *name);

/* Why the last of these calls failed. */
void reason(char *text, size_t size);

/* Memory of zeros, NULL where there is none. */
void *allocate(size_t size);

void release(void *memory);

#endif
