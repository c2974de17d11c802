// SPDX-License-Identifier: Apache-2.0
#include "core/lazy_zeros.h"

#include <sys/mman.h>

#include <cstdlib>

namespace im2fit {
namespace {

constexpr std::size_t kMappedMin = std::size_t{256} << 10;  // bytes; rounding to pages is then 2 % at most, of 4 KiB

}  // namespace

void* lazy_zero_bytes(std::size_t size) {
  if (size == 0) return nullptr;
  void* bytes = size < kMappedMin ? std::calloc(size, 1)
                                  : ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (bytes == nullptr || bytes == MAP_FAILED) throw std::bad_alloc();
  return bytes;
}

void free_lazy_zero_bytes(void* bytes, std::size_t size) {
  if (size < kMappedMin)
    std::free(bytes);
  else
    ::munmap(bytes, size);
}

}  // namespace im2fit
