// SPDX-License-Identifier: Apache-2.0
// What the library asks of bionic under names that musl, which stands in for it under emulation, does not have.
#include <errno.h>
#include <locale.h>
#include <stdlib.h>

int* __errno(void) {
  return __errno_location();
}
long long strtoll_l(const char* text, char** end, int base, locale_t locale) {
  (void)locale;
  return strtoll(text, end, base);
}
unsigned long long strtoull_l(const char* text, char** end, int base, locale_t locale) {
  (void)locale;
  return strtoull(text, end, base);
}
