/* SPDX-License-Identifier: Apache-2.0 */
/* CHECK for the C test programs: reports every failure, the program ends with check_failures. */
#ifndef IM2FIT_TESTS_C_CHECK_H
#define IM2FIT_TESTS_C_CHECK_H

#include <stdio.h>

static int check_failures = 0;

#define CHECK(condition)                                                      \
  do {                                                                        \
    if (!(condition)) {                                                       \
      fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
      ++check_failures;                                                       \
    }                                                                         \
  } while (0)

#endif
