/* SPDX-License-Identifier: MIT
 *
 * haptable_pair_compliance.c with blocks in 16 bits, expanded on the stack
 */
#include "haptable_pair_laws.h"
#include "haptable_polynomial.h"

#define HAPTABLE_STORED(name) name##_packed
#define HAPTABLE_GATHER gather_packed
#define HAPTABLE_IS_PACKED 1
#include "haptable_pair_compliance_template.h"
