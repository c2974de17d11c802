// SPDX-License-Identifier: Apache-2.0
// Put before every file by toolchains/android-link.cmake, whose C headers are musl's: what bionic names differently,
// or has at API 24 and musl has not, and libc++ asks for.
#ifndef IM2FIT_TOOLCHAINS_BIONIC_FIRST_H
#define IM2FIT_TOOLCHAINS_BIONIC_FIRST_H
// It speaks for the C library, so it may use names that are reserved for it.
#pragma clang system_header
#define __errno_location __errno
#ifdef __cplusplus
#include <locale.h>
extern "C" {
long long strtoll_l(const char* text, char** end, int base, locale_t locale);
unsigned long long strtoull_l(const char* text, char** end, int base, locale_t locale);
}
#endif
#endif
