// SPDX-License-Identifier: Apache-2.0
#include "formats/model_pack.h"

#include <cstring>
#include <utility>

#include "core/file.h"

#ifdef IM2FIT_HAVE_ZSTD
#include <zstd.h>
#endif

namespace im2fit {
namespace {

constexpr std::size_t kMagicBytes = 4, kHeadBytes = 8;  // magic and version, core/container.h
// Before a file's bytes: how they are coded, a zero, and how many they are when unpacked. As long as keeps a stored
// file aligned to 8 bytes.
struct SectionHead {
  PackCoding coding;
  std::uint32_t zero;
  std::uint64_t size;
};
static_assert(sizeof(SectionHead) == 16);

Error corrupt(const std::string& what) {
  return {ErrorCode::corrupt, what + "; get the pack again"};
}

// "...2, older than the 3 this im2fit reads; get a newer pack"
std::string other_version(std::uint32_t found, std::uint32_t read) {
  const bool older = found < read;
  return std::to_string(found) + ", " + (older ? "older" : "newer") + " than the " + std::to_string(read) +
         " this im2fit reads; get a " + (older ? "newer pack" : "newer im2fit, or an older pack");
}

// A pack of another version is not damaged.
Status check_version(std::span<const std::byte> bytes, const std::string& what) {
  if (bytes.size() < kHeadBytes || std::memcmp(bytes.data(), kPackMagic, kMagicBytes) != 0)
    return Error{ErrorCode::corrupt, what + " is not a model pack; expected a file im2fit-models-VERSION.i2p"};
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kMagicBytes, sizeof version);
  if (version == kPackVersion) return Ok{};
  return Error{ErrorCode::unsupported, what + " is a model pack of format " + other_version(version, kPackVersion)};
}

Status check_sizes(const ContainerReader& container, const std::string& what) {
  std::uint64_t sum = 0;
  for (const auto& [name, entry] : container.entries()) {
    if (name == kPackManifest) continue;
    const auto found = container.section(name);
    if (!found) return found.error();
    SectionHead head{};
    if (found->size() < sizeof head)
      return corrupt(what + ": " + name + " ends after " + std::to_string(found->size()) + " bytes");
    std::memcpy(&head, found->data(), sizeof head);
    if (head.size > kPackBytesMax - sum)
      return corrupt(what + ": its files have more than " + std::to_string(kPackBytesMax) +
                     " bytes, which no models have");
    sum += head.size;
  }
  return Ok{};
}

#ifdef IM2FIT_HAVE_ZSTD
constexpr int kLevel = 19;  // 20 to 22 make no model smaller

// The frame states its size: what is too short, too long or states another is refused.
Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> bytes, std::uint64_t size,
                                           const std::string& what) {
  if (ZSTD_getFrameContentSize(bytes.data(), bytes.size()) != size)
    return corrupt(what + " does not unpack to the " + std::to_string(size) + " bytes it is said to have");
  std::vector<std::byte> out(static_cast<std::size_t>(size));
  const std::size_t written = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(written) != 0) return corrupt(what + " does not unpack (" + ZSTD_getErrorName(written) + ")");
  if (written != out.size())
    return corrupt(what + " unpacks to " + std::to_string(written) + " bytes, expected " + std::to_string(size));
  return out;
}
#else
Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte>, std::uint64_t, const std::string& what) {
  return Error{
      ErrorCode::unsupported,
      what + " is compressed, and this im2fit was built without zstd; make the pack with im2fit-lab pack --stored"};
}
#endif

}  // namespace

Error other_format(const std::string& pack, const std::string& kind, const std::string& file, std::uint32_t found,
                   std::uint32_t read) {
  return {ErrorCode::unsupported,
          pack + ": its " + kind + " (" + file + ") is of format " + other_version(found, read)};
}

bool is_model_pack(const std::string& path) {
  std::vector<std::byte> first;
  return read_file_into(path, SIZE_MAX, kMagicBytes, first) && first.size() == kMagicBytes &&
         std::memcmp(first.data(), kPackMagic, kMagicBytes) == 0;
}

Result<std::vector<std::byte>> make_pack_section(std::span<const std::byte> content, PackCoding coding) {
  const SectionHead head{coding, 0, content.size()};
  std::vector<std::byte> out(sizeof head);
  std::memcpy(out.data(), &head, sizeof head);
  if (coding == PackCoding::stored) {
    out.insert(out.end(), content.begin(), content.end());
    return out;
  }
#ifdef IM2FIT_HAVE_ZSTD
  out.resize(sizeof head + ZSTD_compressBound(content.size()));
  const std::size_t written =
      ZSTD_compress(out.data() + sizeof head, out.size() - sizeof head, content.data(), content.size(), kLevel);
  if (ZSTD_isError(written) != 0)
    return Error{ErrorCode::io, std::string("cannot compress: ") + ZSTD_getErrorName(written)};
  out.resize(sizeof head + written);
  return out;
#else
  return Error{ErrorCode::unsupported, "this im2fit was built without zstd; use --stored"};
#endif
}

Result<ModelPack> ModelPack::parse(std::span<const std::byte> bytes, const std::string& what, bool check_sections) {
  if (auto ok = check_version(bytes, what); !ok) return ok.error();
  if (bytes.size() > kPackBytesMax)
    return corrupt(what + " has " + std::to_string(bytes.size()) + " bytes, expected at most " +
                   std::to_string(kPackBytesMax));
  auto container = ContainerReader::parse(bytes, kPackMagic, kPackVersion, what, check_sections);
  if (!container) return container.error();
  if (auto ok = check_sizes(*container, what); !ok) return ok.error();
  ModelPack pack;
  pack.what_ = what;
  pack.container_ = std::move(*container);
  return pack;
}

Result<std::vector<std::byte>> ModelPack::file(const std::string& section,
                                               std::optional<std::uint64_t> expected) const {
  const auto found = container_.section(section);
  if (!found) return found.error();
  const std::string what = what_ + ": " + section;
  SectionHead head{};  // which parse has found whole
  std::memcpy(&head, found->data(), sizeof head);
  const auto bytes = found->subspan(sizeof head);
  if (expected && head.size != *expected)
    return corrupt(what + " unpacks to " + std::to_string(head.size) + " bytes, expected " +
                   std::to_string(*expected) + " by the manifest");
  if (head.coding == PackCoding::zstd) return unpack_zstd(bytes, head.size, what);
  if (head.coding != PackCoding::stored)
    return Error{ErrorCode::unsupported, what + " is coded in a way (" +
                                             std::to_string(static_cast<std::uint32_t>(head.coding)) +
                                             ") that this im2fit does not read; get a newer im2fit"};
  if (bytes.size() != head.size)
    return corrupt(what + " has " + std::to_string(bytes.size()) + " bytes, expected " + std::to_string(head.size));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace im2fit
