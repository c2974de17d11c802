// SPDX-License-Identifier: Apache-2.0
// The one container behind .i2b (body), .i2t (tracker) and .i2f (index): named sections, each with its CRC-32C,
// memory-mappable, no pointers. Little-endian; layout in docs/formats.md.
//
//   0  char[4] magic        "I2BD" | "I2TR" | "I2FX"
//   4  u32     version      of the kind of file
//   8  u32     endianness   0x01020304 as written by the machine
//  12  u32     section count (<= 64)
//  16  u64     file size
//  24  u32     CRC-32C of the section table
//  28  u32     zero
//  32  table: per section { char name[16]; u64 offset; u64 size; u32 crc32c; u32 page }   (40 bytes)
//  ..  sections, each starting at a multiple of 64
//
// page 0: crc32c is of the section. page 4096: the section is checked page by page, as it is read; behind it, at the
// next multiple of 64, stands a list of u32, the CRC-32C of its share of each page of the file that it has a share
// of, and crc32c is of that list.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/status.h"

namespace im2fit {

enum class Checked { whole, by_page };

class ContainerWriter {
 public:
  ContainerWriter(std::string_view magic, std::uint32_t version) : magic_(magic), version_(version) {}
  // Names: 1 to 15 characters, unique.
  void add(std::string name, std::vector<std::byte> bytes, Checked checked = Checked::whole);
  template <class T>
  void add_array(const std::string& name, std::span<const T> values, Checked checked = Checked::whole) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto bytes = std::as_bytes(values);
    add(name, {bytes.begin(), bytes.end()}, checked);
  }
  std::vector<std::byte> finish() const;

 private:
  struct Section {
    std::string name;
    std::vector<std::byte> bytes;
    Checked checked;
  };
  std::string magic_;
  std::uint32_t version_;
  std::vector<Section> sections_;
};

// Of the bytes of a section.
struct ByteRange {
  std::size_t first = 0, count = 0;
};

// A section's bytes; each page is checked against its checksum on first use. Copies share the checked pages. Bytes
// that were checked before, or need no check, count as intact.
class PagedBytes {
 public:
  static constexpr std::size_t kPage = 4096;  // of the file
  PagedBytes() = default;
  std::span<const std::byte> bytes() const { return bytes_; }
  // Whether these, inside bytes(), are as they were written. Any thread, lock-free, no allocation. The first check of
  // a page computes its CRC, later ones read a bit. The bit depends only on bytes that never change: a thread that
  // sees it late checks again, so no memory order is needed.
  bool intact(ByteRange range) const {
    if (seen_ == nullptr || range.count == 0) return true;
    const std::size_t last = (lead_ + range.first + range.count - 1) / kPage;
    for (std::size_t page = (lead_ + range.first) / kPage; page <= last; ++page)
      if ((seen_[page / 32].load(std::memory_order_relaxed) >> page % 32 & 1U) == 0 && !check_page(page))
        return false;
    return true;
  }
  // Of bytes that are not intact: which they are, and of which file.
  Error damage(ByteRange range) const;
  Status check(ByteRange range) const {
    if (intact(range)) return Ok{};
    return damage(range);
  }
  // All of it; the error names the page.
  Status check_all() const;
  std::size_t pages_seen() const;  // found intact so far

 private:
  friend class ContainerReader;
  struct State;
  bool check_page(std::size_t page) const;
  std::span<const std::byte> share(std::size_t page) const;

  std::span<const std::byte> bytes_;
  std::size_t lead_ = 0;  // of the first page, what lies before the section
  std::atomic<std::uint32_t>* seen_ = nullptr;
  std::shared_ptr<State> state_;
};

// Views into the caller's bytes, which must outlive the reader and be 8-byte aligned (a mapping or a vector is).
class ContainerReader {
 public:
  // `what` names the file in errors. `check_sections`: verify every section's CRC now (else only the table's); of a
  // section checked by page that of its list.
  static Result<ContainerReader> parse(std::span<const std::byte> bytes, std::string_view magic,
                                       std::uint32_t version, const std::string& what, bool check_sections = true);
  // A section checked by page is checked here, unless no section was to be.
  Result<std::span<const std::byte>> section(const std::string& name) const;
  // To be checked as it is read.
  Result<PagedBytes> paged(const std::string& name) const;
  // The section as values of T; an error if the size is not a multiple of T or, when given, not `count` values.
  template <class T>
  Result<std::span<const T>> array(const std::string& name, std::size_t count = SIZE_MAX) const {
    static_assert(std::is_trivially_copyable_v<T>);
    auto bytes = section(name);
    if (!bytes) return bytes.error();
    if (bytes->size() % sizeof(T) != 0 || (count != SIZE_MAX && bytes->size() != count * sizeof(T)))
      return size_error(name, bytes->size(), count == SIZE_MAX ? 0 : count * sizeof(T), sizeof(T));
    return std::span<const T>(reinterpret_cast<const T*>(bytes->data()), bytes->size() / sizeof(T));
  }
  // The same into `out`, which an error leaves as it is.
  template <class T>
  Status take(const std::string& name, std::span<const T>& out, std::size_t count = SIZE_MAX) const {
    auto values = array<T>(name, count);
    if (!values) return values.error();
    out = *values;
    return Ok{};
  }
  struct Entry {
    std::uint64_t offset = 0;
    std::uint64_t size = 0;
    std::uint32_t crc = 0;
    bool by_page = false;
  };
  const std::map<std::string, Entry>& entries() const { return entries_; }

 private:
  Error size_error(const std::string& name, std::size_t found, std::size_t expected, std::size_t item) const;
  std::span<const std::byte> bytes_;
  std::string what_;
  bool checked_ = true;
  std::map<std::string, Entry> entries_;
};

}  // namespace im2fit
