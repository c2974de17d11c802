// SPDX-License-Identifier: Apache-2.0
#include "core/container.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>

#include "core/crc32c.h"
#include "core/text.h"

namespace im2fit {
namespace {

constexpr std::uint32_t kEndianMark = 0x01020304;
constexpr std::size_t kHeaderSize = 32;
constexpr std::size_t kEntrySize = 40;
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kSectionCountMax = 128;

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

// Pages of the file that a section has a share of.
std::size_t page_count(std::size_t offset, std::size_t size) {
  return size == 0 ? 0 : (offset % PagedBytes::kPage + size - 1) / PagedBytes::kPage + 1;
}

// Of a section that begins `lead` bytes behind the beginning of a page: its share of its page-th page.
std::span<const std::byte> share_of(std::span<const std::byte> section, std::size_t lead, std::size_t page) {
  const std::size_t begin = page == 0 ? 0 : page * PagedBytes::kPage - lead;
  return section.subspan(begin, std::min(section.size(), (page + 1) * PagedBytes::kPage - lead) - begin);
}

// Its checksums; nothing where the file is too short for them.
std::optional<std::span<const std::byte>> list_of(std::span<const std::byte> bytes, const ContainerReader::Entry& e) {
  const auto offset = static_cast<std::size_t>(e.offset), size = static_cast<std::size_t>(e.size);
  const std::size_t begin = align_up(offset + size), length = sizeof(std::uint32_t) * page_count(offset, size);
  if (begin > bytes.size() || length > bytes.size() - begin) return std::nullopt;
  return bytes.subspan(begin, length);
}

std::vector<std::uint32_t> page_sums(std::span<const std::byte> section, std::size_t offset) {
  std::vector<std::uint32_t> sums(page_count(offset, section.size()));
  for (std::size_t page = 0; page < sums.size(); ++page)
    sums[page] = crc32c(share_of(section, offset % PagedBytes::kPage, page));
  return sums;
}

// The program that makes a kind of file.
std::string_view maker_of(std::string_view magic) {
  if (magic == "I2BD") return ": im2fit-lab fetch";
  if (magic == "I2TR") return ": im2fit-lab train";
  if (magic == "I2FX") return ": im2fit-lab index";
  return "";
}

}  // namespace

struct PagedBytes::State {
  std::string what, name;
  std::span<const std::uint32_t> sums;
  std::vector<std::atomic<std::uint32_t>> seen;  // a bit a page
};

void ContainerWriter::add(std::string name, std::vector<std::byte> bytes, Checked checked) {
  assert(!name.empty() && name.size() < 16 && sections_.size() < kSectionCountMax);
  sections_.push_back({std::move(name), std::move(bytes), checked});
}

std::vector<std::byte> ContainerWriter::finish() const {
  const auto list_size = [](const Section& s, std::size_t offset) {
    return s.checked == Checked::whole ? 0 : sizeof(std::uint32_t) * page_count(offset, s.bytes.size());
  };
  const std::size_t table_end = align_up(kHeaderSize + kEntrySize * sections_.size());
  std::size_t size = table_end;
  for (const Section& s : sections_) size = align_up(align_up(size + s.bytes.size()) + list_size(s, size));
  std::vector<std::byte> out(size);
  std::memcpy(out.data(), magic_.data(), 4);
  put(out, 4, version_);
  put(out, 8, kEndianMark);
  put(out, 12, static_cast<std::uint32_t>(sections_.size()));
  put(out, 16, static_cast<std::uint64_t>(size));
  std::size_t offset = table_end;
  std::size_t entry = kHeaderSize;
  for (const Section& s : sections_) {
    std::memcpy(out.data() + entry, s.name.data(), s.name.size());
    put(out, entry + 16, static_cast<std::uint64_t>(offset));
    put(out, entry + 24, static_cast<std::uint64_t>(s.bytes.size()));
    if (!s.bytes.empty()) std::memcpy(out.data() + offset, s.bytes.data(), s.bytes.size());
    const std::size_t end = align_up(offset + s.bytes.size());
    if (s.checked == Checked::by_page) {
      const std::vector<std::uint32_t> sums = page_sums(s.bytes, offset);
      if (!sums.empty()) std::memcpy(out.data() + end, sums.data(), list_size(s, offset));
      put(out, entry + 32, crc32c(std::as_bytes(std::span(sums))));
      put(out, entry + 36, static_cast<std::uint32_t>(PagedBytes::kPage));
    } else {
      put(out, entry + 32, crc32c(s.bytes));
    }
    offset = align_up(end + list_size(s, offset));
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
               "; make it again" + std::string(maker_of(magic)));
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
  reader.checked_ = check_sections;
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = table.subspan(i * kEntrySize, kEntrySize);
    const auto* name = reinterpret_cast<const char*>(row.data());
    const std::string key(name, strnlen(name, 16));
    const std::string shown = printable(key);  // in messages, of one line
    const auto page = get<std::uint32_t>(row, 36);
    const Entry e{get<std::uint64_t>(row, 16), get<std::uint64_t>(row, 24), get<std::uint32_t>(row, 32), page != 0};
    if (e.offset % kAlignment != 0 || e.offset > bytes.size() || e.size > bytes.size() - e.offset)
      return bad("section '" + shown + "' reaches past the end of the file");
    if (page != 0 && page != PagedBytes::kPage)
      return bad("section '" + shown + "' is checked by pages of " + std::to_string(page) + " bytes, expected " +
                 std::to_string(PagedBytes::kPage));
    if (e.by_page && !list_of(bytes, e)) return bad("the checksums of section '" + shown + "' are cut off");
    if (check_sections && crc32c(e.by_page ? *list_of(bytes, e) : part_of(bytes, e)) != e.crc)
      return bad(std::string(e.by_page ? "the checksums of " : "") + "section '" + shown + "' damaged (CRC-32C)");
    reader.entries_.emplace(key, e);
  }
  return reader;
}

Result<std::span<const std::byte>> ContainerReader::section(const std::string& name) const {
  const auto found = paged(name);
  if (!found) return found.error();
  if (const auto sound = found->check_all(); !sound) return sound.error();
  return found->bytes();
}

Result<PagedBytes> ContainerReader::paged(const std::string& name) const {
  const auto it = entries_.find(name);
  if (it == entries_.end()) return Error{ErrorCode::corrupt, what_ + ": section '" + name + "' is missing"};
  const Entry& e = it->second;
  PagedBytes out;
  out.bytes_ = part_of(bytes_, e);
  if (!e.by_page || !checked_ || e.size == 0) return out;
  const auto list = *list_of(bytes_, e);
  const std::size_t count = list.size() / sizeof(std::uint32_t);
  out.lead_ = static_cast<std::size_t>(e.offset) % PagedBytes::kPage;
  out.state_ = std::make_shared<PagedBytes::State>(
      PagedBytes::State{what_,
                        name,
                        {reinterpret_cast<const std::uint32_t*>(list.data()), count},
                        std::vector<std::atomic<std::uint32_t>>((count + 31) / 32)});
  out.seen_ = out.state_->seen.data();
  return out;
}

Error ContainerReader::size_error(const std::string& name, std::size_t found, std::size_t expected,
                                  std::size_t item) const {
  return {ErrorCode::corrupt,
          what_ + ": section '" + name + "' has " + std::to_string(found) + " bytes, expected " +
              (expected > 0 ? std::to_string(expected) : "a multiple of " + std::to_string(item))};
}

std::span<const std::byte> PagedBytes::share(std::size_t page) const {
  return share_of(bytes_, lead_, page);
}

bool PagedBytes::check_page(std::size_t page) const {
  if (crc32c(share(page)) != state_->sums[page]) return false;
  seen_[page / 32].fetch_or(1U << page % 32, std::memory_order_relaxed);
  return true;
}

Error PagedBytes::damage(ByteRange range) const {
  return {ErrorCode::corrupt, state_->what + ": section '" + state_->name + "' damaged (CRC-32C) within bytes " +
                                  std::to_string(range.first) + " to " +
                                  std::to_string(range.first + range.count - 1) + "; copy or make the file again"};
}

Status PagedBytes::check_all() const {
  for (std::size_t page = 0; state_ != nullptr && page < state_->sums.size(); ++page) {
    const auto part = share(page);
    if (auto sound = check({static_cast<std::size_t>(part.data() - bytes_.data()), part.size()}); !sound)
      return sound;
  }
  return Ok{};
}

std::size_t PagedBytes::pages_seen() const {
  std::size_t count = 0;
  if (state_ != nullptr)
    for (const auto& word : state_->seen) count += static_cast<std::size_t>(std::popcount(word.load()));
  return count;
}

}  // namespace im2fit
