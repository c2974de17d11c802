// SPDX-License-Identifier: Apache-2.0
// Counts the instructions a program executes under qemu-user: deterministic, whatever else the machine is doing.
//   qemu-aarch64 -plugin libcount.so,out=FILE PROGRAM ...
// writes the number of executed instructions to FILE (standard error without out=), the dynamic linker's and the C
// library's included. Before it, one line for each time the program marked its place: any system call whose first
// argument is 0x66326d69 (getpid ignores its arguments) writes the count so far. The difference of two marks is what
// lies between them, and some ten instructions for the call.
//
// QEMU's documented plugin interface (docs/devel/tcg-plugins), version 1, as much of it as is used here: Debian ships
// no qemu-plugin.h. Version 1 is understood by QEMU 4.2 to 8.x at least; later ones may ask for more.
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_info_t;
enum qemu_plugin_op { QEMU_PLUGIN_INLINE_ADD_U64 };
typedef void (*vcpu_tb_trans_t)(qemu_plugin_id_t id, struct qemu_plugin_tb* block);
typedef void (*vcpu_syscall_t)(qemu_plugin_id_t id, unsigned int vcpu, int64_t number, uint64_t a1, uint64_t a2,
                               uint64_t a3, uint64_t a4, uint64_t a5, uint64_t a6, uint64_t a7, uint64_t a8);
typedef void (*atexit_t)(qemu_plugin_id_t id, void* data);

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, vcpu_tb_trans_t callback);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb* block, enum qemu_plugin_op op, void* counter,
                                              uint64_t addend);
void qemu_plugin_register_vcpu_syscall_cb(qemu_plugin_id_t id, vcpu_syscall_t callback);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, atexit_t callback, void* data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);

#define PLUGIN_EXPORT __attribute__((visibility("default")))
PLUGIN_EXPORT int qemu_plugin_version = 1;
PLUGIN_EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info_t* info, int argc, char** argv);

// The inline add is not atomic: a program with threads may lose counts. The counted programs have one.
static uint64_t executed;
static const uint32_t kMark = 0x66326d69;
static FILE* out;

// A block is counted whole when it is entered. A block left early by a fault is the only error this makes.
static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  qemu_plugin_register_vcpu_tb_exec_inline(block, QEMU_PLUGIN_INLINE_ADD_U64, &executed,
                                           qemu_plugin_tb_n_insns(block));
}

static void called(qemu_plugin_id_t id, unsigned int vcpu, int64_t number, uint64_t a1, uint64_t a2, uint64_t a3,
                   uint64_t a4, uint64_t a5, uint64_t a6, uint64_t a7, uint64_t a8) {
  (void)id, (void)vcpu, (void)number, (void)a2, (void)a3, (void)a4, (void)a5, (void)a6, (void)a7, (void)a8;
  if (a1 == kMark) fprintf(out, "%" PRIu64 "\n", executed);
}

static void finished(qemu_plugin_id_t id, void* data) {
  (void)id;
  (void)data;
  fprintf(out, "%" PRIu64 "\n", executed);
  fflush(out);
}

int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info_t* info, int argc, char** argv) {
  (void)info;
  out = stderr;
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], "out=", 4) != 0 || (out = fopen(argv[i] + 4, "w")) == NULL) {
      fprintf(stderr, "count: expected out=FILE that can be written, found %s\n", argv[i]);
      return -1;
    }
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_vcpu_syscall_cb(id, called);
  qemu_plugin_register_atexit_cb(id, finished, NULL);
  return 0;
}
