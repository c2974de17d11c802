// SPDX-License-Identifier: Apache-2.0
#include "base/container.h"

#include <cassert>

#include "base/crc32c.h"

namespace im2fit {
namespace {

constexpr std::uint32_t kEndianMark = 0x01020304;
constexpr std::size_t kHeaderSize = 32;
constexpr std::size_t kEntrySize = 40;
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kSectionCountMax = 64;

std::size_t align_up(std::size_t n) {
  return (n + kAlignment - 1) / kAlignment * kAlignment;
}

template <class T>
void put(std::vector<std::byte>& out, std::size_t at, T value) {
  std::memcpy(out.data() + at, &value, sizeof value);
}

template <class T>
T get(std::span<const std::byte> in, std::size_t at) {
  T value;
  std::memcpy(&value, in.data() + at, sizeof value);
  return value;
}

// Once checked against the file's size, offset and size fit this machine's words.
std::span<const std::byte> part_of(std::span<const std::byte> bytes, const ContainerReader::Entry& e) {
  return bytes.subspan(static_cast<std::size_t>(e.offset), static_cast<std::size_t>(e.size));
}

}  // namespace

void ContainerWriter::add(std::string name, std::vector<std::byte> bytes) {
  assert(!name.empty() && name.size() < 16 && sections_.size() < kSectionCountMax);
  sections_.emplace_back(std::move(name), std::move(bytes));
}

std::vector<std::byte> ContainerWriter::finish() const {
  std::size_t size = align_up(kHeaderSize + kEntrySize * sections_.size());
  for (const auto& [name, bytes] : sections_) size = align_up(size + bytes.size());
  std::vector<std::byte> out(size);
  std::memcpy(out.data(), magic_.data(), 4);
  put(out, 4, version_);
  put(out, 8, kEndianMark);
  put(out, 12, static_cast<std::uint32_t>(sections_.size()));
  put(out, 16, static_cast<std::uint64_t>(size));
  std::size_t offset = align_up(kHeaderSize + kEntrySize * sections_.size());
  std::size_t entry = kHeaderSize;
  for (const auto& [name, bytes] : sections_) {
    std::memcpy(out.data() + entry, name.data(), name.size());
    put(out, entry + 16, static_cast<std::uint64_t>(offset));
    put(out, entry + 24, static_cast<std::uint64_t>(bytes.size()));
    put(out, entry + 32, crc32c(bytes));
    if (!bytes.empty()) std::memcpy(out.data() + offset, bytes.data(), bytes.size());
    offset = align_up(offset + bytes.size());
    entry += kEntrySize;
  }
  put(out, 24, crc32c(std::span(out).subspan(kHeaderSize, kEntrySize * sections_.size())));
  return out;
}

Result<ContainerReader> ContainerReader::parse(std::span<const std::byte> bytes, std::string_view magic,
                                               std::uint32_t version, const std::string& what, bool check_sections) {
  const auto bad = [&](const std::string& why) { return Error{ErrorCode::corrupt, what + ": " + why}; };
  if (bytes.size() < kHeaderSize)
    return bad("truncated: " + std::to_string(bytes.size()) + " bytes, the header alone has 32");
  if (std::memcmp(bytes.data(), magic.data(), 4) != 0)
    return bad("not a '" + std::string(magic) + "' file (its first four bytes differ)");
  if (get<std::uint32_t>(bytes, 8) != kEndianMark) return bad("written with another byte order");
  if (const auto found = get<std::uint32_t>(bytes, 4); found != version)
    return bad("format version " + std::to_string(found) + ", this program reads version " + std::to_string(version) +
               "; make the file again with this release");
  const std::size_t count = get<std::uint32_t>(bytes, 12);
  if (count > kSectionCountMax || kHeaderSize + count * kEntrySize > bytes.size())
    return bad("section table truncated");
  if (const auto size = get<std::uint64_t>(bytes, 16); size != bytes.size())
    return bad("truncated: header says " + std::to_string(size) + " bytes, file has " + std::to_string(bytes.size()));
  const auto table = bytes.subspan(kHeaderSize, count * kEntrySize);
  if (crc32c(table) != get<std::uint32_t>(bytes, 24)) return bad("section table damaged (CRC-32C)");

  ContainerReader reader;
  reader.bytes_ = bytes;
  reader.what_ = what;
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = table.subspan(i * kEntrySize, kEntrySize);
    const auto* name = reinterpret_cast<const char*>(row.data());
    const std::string key(name, strnlen(name, 16));
    const Entry e{get<std::uint64_t>(row, 16), get<std::uint64_t>(row, 24), get<std::uint32_t>(row, 32)};
    if (e.offset % kAlignment != 0 || e.offset > bytes.size() || e.size > bytes.size() - e.offset)
      return bad("section '" + key + "' reaches past the end of the file");
    if (check_sections && crc32c(part_of(bytes, e)) != e.crc) return bad("section '" + key + "' damaged (CRC-32C)");
    reader.entries_.emplace(key, e);
  }
  return reader;
}

Result<std::span<const std::byte>> ContainerReader::section(const std::string& name) const {
  const auto it = entries_.find(name);
  if (it == entries_.end()) return Error{ErrorCode::corrupt, what_ + ": section '" + name + "' is missing"};
  return part_of(bytes_, it->second);
}

Error ContainerReader::size_error(const std::string& name, std::size_t found, std::size_t expected,
                                  std::size_t item) const {
  return {ErrorCode::corrupt,
          what_ + ": section '" + name + "' has " + std::to_string(found) + " bytes, expected " +
              (expected > 0 ? std::to_string(expected) : "a multiple of " + std::to_string(item))};
}

}  // namespace im2fit
