/* Surroundings of the example: a file in, a file out. */
#ifndef REPLAY_H
#define REPLAY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads exactly `bytes` bytes; returns 0 at the end of the file. */
int io_read(void *buffer, size_t bytes);
/* Writes `bytes` bytes; returns 0 if it failed. */
int io_write(const void *buffer, size_t bytes);

/* Flies all samples; returns 0, or the number of the step that failed. */
int replay(void);

#ifdef __cplusplus
}
#endif

#endif
