// SPDX-License-Identifier: GPL-2.0-or-later
// A plugin of QEMU's translator: how many instructions run between two addresses, one line a time.
// Arguments: begin=0xADDRESS,end=0xADDRESS,out=FILE; with trace=N the N-th time, from 0, alone, and the address of
// every instruction of it instead, one a line. The interface is QEMU's docs/devel/tcg-plugins; Debian does not ship its
// header, so the few prototypes stand here.
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_info;
enum { NO_REGISTERS = 0, INLINE_ADD_U64 = 0 };

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, void (*call)(qemu_plugin_id_t, struct qemu_plugin_tb*));
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t i);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn* instruction);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn* instruction, void (*call)(unsigned, void*),
                                            int registers, void* data);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn* instruction, int operation, void* to,
                                                uint64_t by);
int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info* info, int argc, char** argv);

extern int qemu_plugin_version;
int qemu_plugin_version = 1;

static uint64_t begin_address;
static uint64_t end_address;
static uint64_t instructions;
static uint64_t begun_at;
static uint64_t times;
static uint64_t traced = UINT64_MAX;
static int tracing;
static FILE* out;

static void on_begin(unsigned processor, void* data) {
    (void)processor;
    (void)data;
    begun_at = instructions;
    tracing = times == traced;
}

static void on_end(unsigned processor, void* data) {
    (void)processor;
    (void)data;
    tracing = 0;
    ++times;
    if (traced == UINT64_MAX) fprintf(out, "%llu\n", (unsigned long long)(instructions - begun_at));
}

static void on_instruction(unsigned processor, void* address) {
    (void)processor;
    if (tracing) fprintf(out, "%llx\n", (unsigned long long)(uintptr_t)address);
}

/* Called once for every block of code before it first runs: asks to be told of the two addresses, and lets the
 * translated code itself add up the rest. */
static void on_block(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
    const size_t count = qemu_plugin_tb_n_insns(block);
    (void)id;
    for (size_t i = 0; i < count; ++i) {
        struct qemu_plugin_insn* instruction = qemu_plugin_tb_get_insn(block, i);
        const uint64_t address = qemu_plugin_insn_vaddr(instruction);
        if (address == begin_address) qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_begin, NO_REGISTERS, NULL);
        if (address == end_address) qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_end, NO_REGISTERS, NULL);
        if (traced != UINT64_MAX)
            qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_instruction, NO_REGISTERS,
                                                   (void*)(uintptr_t)address);
        qemu_plugin_register_vcpu_insn_exec_inline(instruction, INLINE_ADD_U64, &instructions, 1);
    }
}

int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info* info, int argc, char** argv) {
    (void)info;
    for (int i = 0; i < argc; ++i) {
        if (strncmp(argv[i], "begin=", 6) == 0) begin_address = strtoull(argv[i] + 6, NULL, 0);
        if (strncmp(argv[i], "end=", 4) == 0) end_address = strtoull(argv[i] + 4, NULL, 0);
        if (strncmp(argv[i], "trace=", 6) == 0) traced = strtoull(argv[i] + 6, NULL, 0);
        if (strncmp(argv[i], "out=", 4) == 0) out = fopen(argv[i] + 4, "w");
    }
    if (out == NULL || begin_address == 0 || end_address == 0) return 1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
    return 0;
}
