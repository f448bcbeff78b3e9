/* SPDX-License-Identifier: MIT
 *
 * CRC-32 (ISO-HDLC): remainder of the bytes by x^32 + x^26 + x^23 + ... + 1, reflected, begun and ended with ones
 */
#ifndef HAPTABLE_CRC_H
#define HAPTABLE_CRC_H

#include <stdint.h>

#define HAPTABLE_CRC_BEGIN 0xffffffffu

/* The remainder after more bytes; begun with HAPTABLE_CRC_BEGIN, the CRC is its complement. */
uint32_t haptable_crc(uint32_t remainder, const uint8_t* bytes, uint32_t count);

#endif
