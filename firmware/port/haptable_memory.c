/* SPDX-License-Identifier: MIT
 *
 * The four functions that a freestanding gcc may call for struct copies (GCC manual, "Standards"). A project that
 * links a C library leaves this file out.
 */
#include <stddef.h>

void* memcpy(void* to, const void* from, size_t count);
void* memmove(void* to, const void* from, size_t count);
void* memset(void* to, int value, size_t count);
int memcmp(const void* a, const void* b, size_t count);

void* memcpy(void* to, const void* from, size_t count) {
    unsigned char* t = to;
    const unsigned char* f = from;
    while (count-- > 0) *t++ = *f++;
    return to;
}

void* memmove(void* to, const void* from, size_t count) {
    unsigned char* t = to;
    const unsigned char* f = from;
    if (t < f) return memcpy(to, from, count);
    while (count-- > 0) t[count] = f[count];
    return to;
}

void* memset(void* to, int value, size_t count) {
    unsigned char* t = to;
    while (count-- > 0) *t++ = (unsigned char)value;
    return to;
}

int memcmp(const void* a, const void* b, size_t count) {
    const unsigned char* p = a;
    const unsigned char* q = b;
    for (; count > 0; --count, ++p, ++q)
        if (*p != *q) return *p < *q ? -1 : 1;
    return 0;
}
