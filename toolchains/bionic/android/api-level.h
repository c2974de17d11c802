// SPDX-License-Identifier: Apache-2.0
// libc++ includes it on Android; the compiler's target says the level (__ANDROID_API__).
#ifndef IM2FIT_TOOLCHAINS_ANDROID_API_LEVEL_H
#define IM2FIT_TOOLCHAINS_ANDROID_API_LEVEL_H
#endif
