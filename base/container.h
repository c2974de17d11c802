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
//  32  table: per section { char name[16]; u64 offset; u64 size; u32 crc32c; u32 zero }   (40 bytes)
//  ..  sections, each starting at a multiple of 64
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/status.h"

namespace im2fit {

class ContainerWriter {
 public:
  ContainerWriter(std::string_view magic, std::uint32_t version) : magic_(magic), version_(version) {}
  // Names: 1 to 15 characters, unique.
  void add(std::string name, std::vector<std::byte> bytes);
  template <class T>
  void add_array(const std::string& name, std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto bytes = std::as_bytes(values);
    add(name, {bytes.begin(), bytes.end()});
  }
  std::vector<std::byte> finish() const;

 private:
  std::string magic_;
  std::uint32_t version_;
  std::vector<std::pair<std::string, std::vector<std::byte>>> sections_;
};

// Views into the caller's bytes, which must outlive the reader and be 8-byte aligned (a mapping or a vector is).
class ContainerReader {
 public:
  // `what` names the file in errors. `check_sections`: verify every section's CRC now (else only the table's).
  static Result<ContainerReader> parse(std::span<const std::byte> bytes, std::string_view magic,
                                       std::uint32_t version, const std::string& what, bool check_sections = true);
  Result<std::span<const std::byte>> section(const std::string& name) const;
  // The section as values of T; an error if the size is no multiple of T or, when given, not `count` values.
  template <class T>
  Result<std::span<const T>> array(const std::string& name, std::size_t count = SIZE_MAX) const {
    static_assert(std::is_trivially_copyable_v<T>);
    auto bytes = section(name);
    if (!bytes) return bytes.error();
    if (bytes->size() % sizeof(T) != 0 || (count != SIZE_MAX && bytes->size() != count * sizeof(T)))
      return size_error(name, bytes->size(), count == SIZE_MAX ? 0 : count * sizeof(T), sizeof(T));
    return std::span<const T>(reinterpret_cast<const T*>(bytes->data()), bytes->size() / sizeof(T));
  }
  struct Entry {
    std::uint64_t offset = 0;
    std::uint64_t size = 0;
    std::uint32_t crc = 0;
  };
  const std::map<std::string, Entry>& entries() const { return entries_; }

 private:
  Error size_error(const std::string& name, std::size_t found, std::size_t expected, std::size_t item) const;
  std::span<const std::byte> bytes_;
  std::string what_;
  std::map<std::string, Entry> entries_;
};

}  // namespace im2fit
