/* SPDX-License-Identifier: MIT
 *
 * Files of the debugger's machine, opened from the target (Arm's "Semihosting for AArch32 and AArch64", which RISC-V
 * took over): for QEMU and debug probes, not for products.
 */
#ifndef HAPTABLE_SEMIHOSTING_H
#define HAPTABLE_SEMIHOSTING_H

#include <stdint.h>

/* One call to the debugger: the operation's number and its block of words. Assembly, one file a family. */
uint32_t haptable_semihosting_call(uint32_t operation, const void* block);

/* Opens the files, which may be named pipes, that the command line names: IMAGE IN OUT, with blanks between. Returns 0,
 * 64 where it has not these three words, 66 where one of the files cannot be opened (BSD's sysexits.h). */
int haptable_semihosting_files(int* in, int* out);

/* Reads up to `count` bytes, waiting for them. Returns how many came; 0 at the end of the file. */
uint32_t haptable_semihosting_read(int file, void* bytes, uint32_t count);

/* Writes them all. Returns 0, or how many were not written. */
uint32_t haptable_semihosting_write(int file, const void* bytes, uint32_t count);

/* Ends the image; `status` becomes QEMU's own. */
void haptable_semihosting_exit(int status);

#endif
