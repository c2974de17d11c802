// SPDX-License-Identifier: Apache-2.0
// Damaged files of core/container.h: as accidents and attackers make them. Written from docs/formats.md, not from the
// container's code.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/crc32c.h"
#include "core/rng.h"

namespace im2fit::fuzz {

using Bytes = std::vector<std::byte>;

// How many of so many damaged files to try. Under the address sanitizer each takes several times as long, and the
// same build has a fuzzer of the same reader: a quarter.
constexpr int trials(int count) {
#if defined(__SANITIZE_ADDRESS__)
  count /= 4;
#endif
  return count;
}

inline std::uint64_t word_at(const Bytes& bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, size);
  return value;
}

// A section's CRC-32Cs, one for its share of each page of the file (docs/formats.md).
inline std::vector<std::uint32_t> page_checksums(const Bytes& bytes, std::size_t offset, std::size_t length) {
  std::vector<std::uint32_t> sums;
  for (std::size_t at = offset; at < offset + length;) {
    const std::size_t end = std::min((at / 4096 + 1) * 4096, offset + length);
    sums.push_back(crc32c(std::span(bytes).subspan(at, end - at)));
    at = end;
  }
  return sums;
}

// Makes all checksums right again, as an attacker would, so that what lies behind them is reached. What reaches past
// the end is left alone.
inline void mend_checksums(Bytes& bytes) {
  constexpr std::size_t kHeader = 32, kEntry = 40;
  if (bytes.size() < kHeader) return;
  const std::uint64_t size = bytes.size(), count = word_at(bytes, 12, 4);
  std::memcpy(bytes.data() + 16, &size, sizeof size);
  if (count > (bytes.size() - kHeader) / kEntry) return;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = kHeader + i * kEntry;
    const std::uint64_t offset = word_at(bytes, entry + 16, 8), length = word_at(bytes, entry + 24, 8);
    if (offset > bytes.size() || length > bytes.size() - offset) continue;
    const auto first = static_cast<std::size_t>(offset), size_of = static_cast<std::size_t>(length);
    std::uint32_t crc = crc32c(std::span(bytes).subspan(first, size_of));
    if (word_at(bytes, entry + 36, 4) != 0) {
      const auto sums = page_checksums(bytes, first, size_of);
      const std::size_t list = (first + size_of + 63) / 64 * 64;
      if (list > bytes.size() || 4 * sums.size() > bytes.size() - list) continue;
      if (!sums.empty()) std::memcpy(bytes.data() + list, sums.data(), 4 * sums.size());
      crc = crc32c(std::as_bytes(std::span(sums)));
    }
    std::memcpy(bytes.data() + entry + 32, &crc, sizeof crc);
  }
  const std::uint32_t crc = crc32c(std::span(bytes).subspan(kHeader, static_cast<std::size_t>(count) * kEntry));
  std::memcpy(bytes.data() + 24, &crc, sizeof crc);
}

// One to four accidents. Half of them hit the first 4 KiB, where sizes and records are.
inline Bytes damaged(const Bytes& good, Rng& rng) {
  constexpr std::array<std::uint64_t, 12> kOddValues = {0,          1,          0x7F,       0xFF,
                                                        0x7FFF,     0xFFFF,     0x7FFFFFFF, 0x80000000,
                                                        0xFFFFFFFF, 0x7FC00000, 0x7F800000, 0xFFFFFFFFFFFFFFFF};
  Bytes bytes = good;
  const int accidents = 1 + rng.index(4);
  for (int i = 0; i < accidents && bytes.size() > 8; ++i) {
    const std::size_t range = rng.index(2) == 0 && bytes.size() > 4096 ? 4096 : bytes.size();
    const auto at = static_cast<std::size_t>(rng.next() % (range - 8));
    switch (rng.index(5)) {
      case 0:
        bytes[at] ^= std::byte{static_cast<unsigned char>(1U << rng.index(8))};
        break;
      case 1:
        bytes[at] = static_cast<std::byte>(rng.index(256));
        break;
      case 2:
      case 3: {  // a field of a size
        const std::size_t width = std::size_t{1} << rng.index(4);
        const std::uint64_t value = kOddValues[static_cast<std::size_t>(rng.index(12))];
        std::memcpy(bytes.data() + at / width * width, &value, width);
        break;
      }
      default:
        bytes.resize(at);
        break;
    }
  }
  return bytes;
}

}  // namespace im2fit::fuzz
