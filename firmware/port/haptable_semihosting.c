/* SPDX-License-Identifier: MIT
 *
 * Operation numbers and blocks of words: Arm, "Semihosting for AArch32 and AArch64", section 6.
 */
#include "haptable_semihosting.h"

#include "haptable_port.h"

enum { SYS_OPEN = 0x01, SYS_WRITE = 0x05, SYS_READ = 0x06, SYS_GET_CMDLINE = 0x15, SYS_EXIT_EXTENDED = 0x20 };

/* The reason of an exit that the program asked for. */
#define APPLICATION_EXIT 0x20026u

static uint32_t word_of(const void* address) { return (uint32_t)(uintptr_t)address; }

static uint32_t length_of(const char* text) {
    uint32_t length = 0;
    while (text[length] != 0) ++length;
    return length;
}

enum mode { READ = 1, WRITE = 5 }; /* "rb", "wb" */

/* A file handle, or -1. */
static int open_file(const char* name, enum mode mode) {
    uint32_t block[3];
    block[0] = word_of(name);
    block[1] = (uint32_t)mode;
    block[2] = length_of(name);
    return (int)haptable_semihosting_call(SYS_OPEN, block);
}

uint32_t haptable_semihosting_read(int file, void* bytes, uint32_t count) {
    uint32_t block[3];
    block[0] = (uint32_t)file;
    block[1] = word_of(bytes);
    block[2] = count;
    return count - haptable_semihosting_call(SYS_READ, block);
}

uint32_t haptable_semihosting_write(int file, const void* bytes, uint32_t count) {
    uint32_t block[3];
    block[0] = (uint32_t)file;
    block[1] = word_of(bytes);
    block[2] = count;
    return haptable_semihosting_call(SYS_WRITE, block);
}

/* From the linker script. */
extern uint32_t haptable_port_data_begin[];
extern uint32_t haptable_port_data_end[];
extern const uint32_t haptable_port_data_flash[];
extern uint32_t haptable_port_bss_begin[];
extern uint32_t haptable_port_bss_end[];

void haptable_port_begin(void) {
    const uint32_t* from = haptable_port_data_flash;
    for (uint32_t* to = haptable_port_data_begin; to < haptable_port_data_end; ++to) *to = *from++;
    for (uint32_t* to = haptable_port_bss_begin; to < haptable_port_bss_end; ++to) *to = 0;
    haptable_semihosting_exit(haptable_port_main());
}

void haptable_semihosting_exit(int status) {
    uint32_t block[2];
    block[0] = APPLICATION_EXIT;
    block[1] = (uint32_t)status;
    haptable_semihosting_call(SYS_EXIT_EXTENDED, block);
}

/* Copies the command line, words separated by blanks, and puts a 0 after each. Returns the number of words, 0 when
 * there is none or it does not fit; word[i] points into `text`. */
static int words_of(char* text, uint32_t size, const char** word, int most) {
    uint32_t block[2];
    int words = 0;
    char before = ' ';
    block[0] = word_of(text);
    block[1] = size;
    if (haptable_semihosting_call(SYS_GET_CMDLINE, block) != 0) return 0;
    for (char* c = text; *c != 0; ++c) {
        if (*c != ' ' && before == ' ' && words < most) word[words++] = c;
        before = *c;
        if (*c == ' ') *c = 0;
    }
    return words;
}

int haptable_semihosting_files(int* in, int* out) {
    static char text[512];
    const char* word[3] = {0, 0, 0};
    if (words_of(text, sizeof text, word, 3) != 3) return 64;
    *in = open_file(word[1], READ);
    *out = open_file(word[2], WRITE);
    return *in < 0 || *out < 0 ? 66 : 0;
}
