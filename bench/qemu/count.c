// SPDX-License-Identifier: Apache-2.0
// Counts the instructions a program executes under qemu-user: deterministic, whatever else the machine is doing.
//   qemu-aarch64 -plugin libcount.so,out=FILE PROGRAM ...
// writes one decimal number to FILE (standard error without out=). Every executed guest instruction counts, those of
// the dynamic linker and the C library included: the difference of two runs of different lengths is what a run costs.
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
typedef void (*atexit_t)(qemu_plugin_id_t id, void* data);

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, vcpu_tb_trans_t callback);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb* block, enum qemu_plugin_op op, void* counter,
                                              uint64_t addend);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, atexit_t callback, void* data);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);

#define PLUGIN_EXPORT __attribute__((visibility("default")))
PLUGIN_EXPORT int qemu_plugin_version = 1;
PLUGIN_EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info_t* info, int argc, char** argv);

// The inline add is not atomic: a program with threads may lose counts. The counted programs have one.
static uint64_t executed;
static char out_path[4096];

// A block is counted whole when it is entered. A block left early by a fault is the only error this makes.
static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  qemu_plugin_register_vcpu_tb_exec_inline(block, QEMU_PLUGIN_INLINE_ADD_U64, &executed,
                                           qemu_plugin_tb_n_insns(block));
}

static void finished(qemu_plugin_id_t id, void* data) {
  (void)id;
  (void)data;
  FILE* out = out_path[0] != '\0' ? fopen(out_path, "w") : stderr;
  if (out == NULL) {
    fprintf(stderr, "count: cannot write %s\n", out_path);
    return;
  }
  fprintf(out, "%" PRIu64 "\n", executed);
  if (out != stderr) fclose(out);
}

int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info_t* info, int argc, char** argv) {
  (void)info;
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], "out=", 4) != 0 || strlen(argv[i] + 4) >= sizeof out_path) {
      fprintf(stderr, "count: expected out=FILE, found %s\n", argv[i]);
      return -1;
    }
    strcpy(out_path, argv[i] + 4);
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, finished, NULL);
  return 0;
}
