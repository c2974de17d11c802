// SPDX-License-Identifier: Apache-2.0
// A model pack (.i2p) as whatever measures reads it: body, tracker and index in one file, each compressed or stored
// (docs/models.md). Its manifest, which lists all files, is for tools: apps/common/pack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/container.h"
#include "core/status.h"

namespace im2fit {

inline constexpr char kPackMagic[] = "I2PK";
inline constexpr std::uint32_t kPackVersion = 2;
// Of a pack, and of all its files together when they are unpacked. Models of 1,500 people have 8 and 18 MB.
inline constexpr std::uint64_t kPackBytesMax = std::uint64_t{128} << 20;

// The sections of the models; other files of a pack have numbers.
inline constexpr char kPackManifest[] = "manifest";
inline constexpr char kPackedBody[] = "body.i2b", kPackedTracker[] = "tracker.i2t", kPackedIndex[] = "index.i2f";

// How the bytes of a file lie in a pack. The values are those of the file format.
enum class PackCoding : std::uint32_t { stored = 0, zstd = 1 };

// Whether the file begins as a pack does, of any version. A file that cannot be read is none: its reader says why.
bool is_model_pack(const std::string& path);

// A file in a pack that is of another format than this program reads: `kind` is "index", `file` "index.i2f".
Error other_format(const std::string& pack, const std::string& kind, const std::string& file, std::uint32_t found,
                   std::uint32_t read);

// A file's section of a pack. The same bytes from the same libzstd on every machine. Errors: unsupported where this
// program was built without zstd.
Result<std::vector<std::byte>> make_pack_section(std::span<const std::byte> content, PackCoding coding);

// Views into the caller's bytes, which must outlive it and be 8-byte aligned.
class ModelPack {
 public:
  // `what` names the pack in errors. Errors: corrupt; unsupported, naming both versions, for a pack of another
  // version. Checksums of sections are compared when `check_sections` says so; models carry their own. All files
  // together unpack to at most kPackBytesMax, by what their sections state.
  static Result<ModelPack> parse(std::span<const std::byte> bytes, const std::string& what, bool check_sections);
  // A section as it is: the manifest.
  Result<std::span<const std::byte>> section(const std::string& name) const { return container_.section(name); }
  // A file, unpacked; memory is taken only for the size that its section states, and never more than kPackBytesMax,
  // nor where a manifest's size (`expected`) is another. Errors: corrupt; unsupported for a coding that this program
  // cannot read.
  Result<std::vector<std::byte>> file(const std::string& section,
                                      std::optional<std::uint64_t> expected = std::nullopt) const;

 private:
  std::string what_;
  ContainerReader container_;
};

}  // namespace im2fit
