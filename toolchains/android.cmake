# SPDX-License-Identifier: Apache-2.0
# Android by its NDK, for the presets android-arm64, android-armv7 and android-x86_64, which set the ABI. Eigen,
# nanoflann and nlohmann-json are headers, found below IM2FIT_ANDROID_PREFIX and nowhere else: beside Debian's own in
# /usr/include lie glibc's, which would come before bionic's.
if(NOT EXISTS "$ENV{ANDROID_NDK_HOME}/build/cmake/android.toolchain.cmake")
  message(FATAL_ERROR "ANDROID_NDK_HOME='$ENV{ANDROID_NDK_HOME}' is no NDK (docs/android.md). Without one, "
                      "scripts/android-check compiles but cannot link.")
endif()
if(NOT IS_DIRECTORY "$ENV{IM2FIT_ANDROID_PREFIX}")
  message(FATAL_ERROR "IM2FIT_ANDROID_PREFIX='$ENV{IM2FIT_ANDROID_PREFIX}' is no directory (docs/android.md)")
endif()
set(ANDROID_PLATFORM android-24)
set(ANDROID_STL c++_static)
include($ENV{ANDROID_NDK_HOME}/build/cmake/android.toolchain.cmake)
list(APPEND CMAKE_FIND_ROOT_PATH $ENV{IM2FIT_ANDROID_PREFIX})
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
