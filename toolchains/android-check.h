// SPDX-License-Identifier: Apache-2.0
// Put before every file by scripts/android-check. What bionic declares at API 24 and libc++ asks for but musl does
// not have: functions of bionic's <stdlib.h> since API 21.
#ifndef IM2FIT_TOOLCHAINS_ANDROID_CHECK_H
#define IM2FIT_TOOLCHAINS_ANDROID_CHECK_H
#include <locale.h>
extern "C" {
long long strtoll_l(const char* text, char** end, int base, locale_t locale);
unsigned long long strtoull_l(const char* text, char** end, int base, locale_t locale);
}
// Most files include these, directly or not: parsed once, half of the work is gone.
#include <string>
#include <vector>
#endif
