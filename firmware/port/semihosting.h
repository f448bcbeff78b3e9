/* SPDX-License-Identifier: MIT
 *
 * Files of the debugger's machine, opened from the target (Arm's "Semihosting for AArch32 and AArch64", which RISC-V
 * took over): for QEMU and debug probes, not for products.
 */
#ifndef HAPTABLE_SEMIHOSTING_H
#define HAPTABLE_SEMIHOSTING_H

#include <stdint.h>

enum semihosting_mode { SEMIHOSTING_READ = 1, SEMIHOSTING_WRITE = 5 }; /* "rb", "wb" */

/* One call to the debugger: the operation's number and its block of words. Assembly, one file a family. */
uint32_t semihosting_call(uint32_t operation, const void* block);

/* A file handle, or -1. */
int semihosting_open(const char* name, enum semihosting_mode mode);

/* Reads up to `count` bytes, waiting for them. Returns how many came; 0 at the end of the file. */
uint32_t semihosting_read(int file, void* bytes, uint32_t count);

/* Writes them all. Returns 0, or how many were not written. */
uint32_t semihosting_write(int file, const void* bytes, uint32_t count);

/* Ends the image; `status` becomes QEMU's own. */
void semihosting_exit(int status);

/* Copies the command line, words separated by blanks, and puts a 0 after each. Returns the number of words, 0 when
 * there is none or it does not fit; word[i] points into `text`. */
int semihosting_words(char* text, uint32_t size, const char** word, int most);

#endif
