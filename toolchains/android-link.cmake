# SPDX-License-Identifier: Apache-2.0
# Android without its NDK, for scripts/android-link, which makes what IM2FIT_ANDROID_RUNTIME holds: clang and lld 14, musl's
# headers for bionic's, libc++ 16 and LLVM's unwinder inside the library, a stub of libc.so with bionic's names of API 24.
# What it links is for checks alone: docs/android.md.
set(CMAKE_SYSTEM_NAME Linux)
set(runtime $ENV{IM2FIT_ANDROID_RUNTIME})
if(NOT EXISTS "${runtime}/flags")
  message(FATAL_ERROR "IM2FIT_ANDROID_RUNTIME='${runtime}' is none: run scripts/android-link")
endif()
# An APK holds lib*.so and nothing after that.
set(CMAKE_PLATFORM_NO_VERSIONED_SONAME TRUE)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ANDROID_ABI)
if(ANDROID_ABI STREQUAL armeabi-v7a)
  set(CMAKE_SYSTEM_PROCESSOR armv7-a)
elseif(ANDROID_ABI STREQUAL x86_64)
  set(CMAKE_SYSTEM_PROCESSOR x86_64)
else()
  set(CMAKE_SYSTEM_PROCESSOR aarch64)
endif()
set(CMAKE_C_COMPILER clang-14)
set(CMAKE_CXX_COMPILER clang++-14)
set(CMAKE_AR llvm-ar-14 CACHE FILEPATH "")
set(CMAKE_RANLIB llvm-ranlib-14 CACHE FILEPATH "")
set(CMAKE_STRIP llvm-strip-14 CACHE FILEPATH "")
# Sections of their own, as the NDK's toolchain file has them: the linker leaves out what is never called.
set(CMAKE_C_FLAGS_INIT "@${runtime}/flags -ffunction-sections -fdata-sections")
set(CMAKE_CXX_FLAGS_INIT "@${runtime}/flags-c++ @${runtime}/flags -ffunction-sections -fdata-sections")
# lld's own default would be 64 kB pages on ARM64; Android 15 has 16 kB.
set(linked "@${runtime}/flags-link -Qunused-arguments -Wl,-z,max-page-size=16384 -Wl,--hash-style=both -Wl,--build-id=none -Wl,--error-limit=0")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "${linked}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "${linked}")
set(CMAKE_CXX_STANDARD_LIBRARIES "${runtime}/lib/libc++.a ${runtime}/lib/builtins.a ${runtime}/lib/libc.so")
set(CMAKE_C_STANDARD_LIBRARIES "${runtime}/lib/builtins.a ${runtime}/lib/libc.so")
# As in bionic, threads are the C library's.
set(CMAKE_HAVE_LIBC_PTHREAD TRUE)
# Nothing of this machine: its JSON headers are header-only, and the same for every one.
set(CMAKE_FIND_ROOT_PATH ${runtime}/headers)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
