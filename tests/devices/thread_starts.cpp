// SPDX-License-Identifier: Apache-2.0
#include "tests/devices/thread_starts.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>

namespace {

using Start = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
std::atomic<int> starts_left{-1};  // -1: none fails

}  // namespace

#ifdef __clang__
#pragma clang diagnostic ignored "-Wreserved-identifier"  // the sanitizers' own names
#endif

extern "C" {

// A sanitizer's own, which must see every thread: behind it is the C library's.
[[gnu::weak]] int __interceptor_pthread_create(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);

void fail_thread_start_after(int count) {
  starts_left = count;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) {
  if (starts_left >= 0 && starts_left-- == 0) return EAGAIN;
  static const Start start = __interceptor_pthread_create != nullptr
                                 ? &__interceptor_pthread_create
                                 : reinterpret_cast<Start>(dlsym(RTLD_NEXT, "pthread_create"));
  return start(thread, attributes, run, argument);
}

}  // extern "C"
