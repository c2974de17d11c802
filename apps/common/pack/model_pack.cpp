// SPDX-License-Identifier: Apache-2.0
#include "apps/common/pack/model_pack.h"

#include <fmt/format.h>
#include <lzma.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "body/model_data.h"
#include "core/container.h"
#include "core/crc32c.h"
#include "core/file.h"
#include "core/status.h"
#include "index/format.h"
#include "perception/joints/model_data.h"

namespace im2fit::apps {
namespace {

// .xz, whole. Body files come out 0.1 % larger than with 9, whose dictionary of 64 MiB unpacking would need as well.
constexpr std::uint32_t kPreset = 6;
constexpr std::uint64_t kUnpackBytesMax = std::uint64_t{32} << 20;

const std::uint8_t* octets(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

// One thread and one fixed setting: the same bytes from the same liblzma on every machine.
Result<std::vector<std::byte>> compress_xz(std::span<const std::byte> bytes) {
  std::vector<std::byte> out(lzma_stream_buffer_bound(bytes.size()));
  std::size_t written = 0;
  const lzma_ret done = lzma_easy_buffer_encode(kPreset, LZMA_CHECK_CRC64, nullptr, octets(bytes), bytes.size(),
                                                reinterpret_cast<std::uint8_t*>(out.data()), &written, out.size());
  if (done != LZMA_OK) return Error{ErrorCode::io, "cannot compress (liblzma error " + std::to_string(done) + ")"};
  out.resize(written);
  return out;
}

// `size` is what must come out; more or less is an error, so that a file that claims little cannot fill the memory.
Result<std::vector<std::byte>> decompress_xz(std::span<const std::byte> bytes, std::size_t size,
                                             const std::string& what) {
  std::vector<std::byte> out(size);
  std::uint64_t memory = kUnpackBytesMax;
  std::size_t read = 0, written = 0;
  const lzma_ret done = lzma_stream_buffer_decode(&memory, 0, nullptr, octets(bytes), &read, bytes.size(),
                                                  reinterpret_cast<std::uint8_t*>(out.data()), &written, out.size());
  if (done != LZMA_OK || read != bytes.size() || written != size)
    return Error{ErrorCode::corrupt, what + " does not unpack to " + std::to_string(size) + " bytes (liblzma error " +
                                         std::to_string(done) + "); get it again"};
  return out;
}

using Json = nlohmann::ordered_json;

constexpr char kPackMagic[] = "I2PK";
constexpr char kSchema[] = "im2fit.models/1";
constexpr std::size_t kFilesMax = 100;
constexpr std::uint64_t kFileBytesMax = std::uint64_t{256} << 20;
constexpr std::size_t kMagicBytes = 4, kHeadBytes = 8;  // magic and version, core/container.h

// What this program reads of its own files.
struct Known {
  const char* magic;
  const char* name;
  std::uint32_t version;
};
constexpr Known kKnown[] = {{"I2BD", "body", body::kBodyVersion},
                            {"I2TR", "tracker", joints::kTrackerVersion},
                            {"I2FX", "index", index::kVersion}};

const Known* known_of(std::string_view magic) {
  for (const Known& known : kKnown)
    if (magic == known.magic) return &known;
  return nullptr;
}

// An older or newer file is refused before it is unpacked.
Status check_format(const PackedFile& file, const std::string& what) {
  const Known* known = known_of(file.magic);
  if (known == nullptr || file.format == known->version) return Ok{};
  const bool older = file.format < known->version;
  return Error{ErrorCode::unsupported,
               fmt::format("{}: its {} ({}) is of format {}, {} than the {} this im2fit reads; get a {}", what,
                           known->name, file.name, file.format, older ? "older" : "newer", known->version,
                           older ? "newer pack" : "newer im2fit, or an older pack")};
}

// Names are written below a directory of ours and nowhere else.
bool is_safe_name(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.back() == '/' || name == kManifestName) return false;
  for (const auto& part : std::filesystem::path(name))
    if (part == ".." || part == ".") return false;
  return name.find('\\') == std::string::npos && name.find('\0') == std::string::npos;
}

std::string section_name(std::size_t number) {
  return std::to_string(number);
}

Result<std::string> text_of(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

// A pack of another version of the pack format is not damaged.
Status check_pack_version(std::span<const std::byte> bytes, const std::string& path) {
  if (bytes.size() < kHeadBytes || std::memcmp(bytes.data(), kPackMagic, kMagicBytes) != 0)
    return Error{ErrorCode::corrupt, path + " is not a model pack; expected a file im2fit-models-VERSION.i2p"};
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kMagicBytes, sizeof version);
  if (version == kPackVersion) return Ok{};
  return Error{ErrorCode::unsupported,
               fmt::format("{} is a model pack of format {}, {} than the {} this im2fit reads; get a {}", path,
                           version, version < kPackVersion ? "older" : "newer", kPackVersion,
                           version < kPackVersion ? "newer pack" : "newer im2fit, or an older pack")};
}

}  // namespace

std::string manifest_json(const PackManifest& manifest) {
  Json files = Json::array();
  for (const PackedFile& file : manifest.files) {
    Json json = {{"name", file.name}, {"bytes", file.size}, {"crc32c", fmt::format("{:08x}", file.crc32c)}};
    if (!file.magic.empty()) {
      json["magic"] = file.magic;
      json["format"] = file.format;
    }
    files.push_back(json);
  }
  const Json json = {
      {"schema", kSchema},           {"version", manifest.version},       {"made_by", manifest.made_by},
      {"source", manifest.source},   {"licence", manifest.licence},       {"people", manifest.people},
      {"clothed", manifest.clothed}, {"provenance", manifest.provenance}, {"files", files}};
  return json.dump(2) + "\n";
}

Result<PackManifest> parse_manifest(const std::string& text, const std::string& what) {
  try {
    const Json json = Json::parse(text);
    if (const std::string schema = json.at("schema"); schema != kSchema)
      return Error{ErrorCode::unsupported, what + ": the manifest's schema is " + schema + ", expected " + kSchema};
    PackManifest manifest;
    manifest.version = json.at("version");
    manifest.made_by = json.at("made_by");
    manifest.source = json.at("source");
    manifest.licence = json.at("licence");
    manifest.people = json.at("people");
    manifest.clothed = json.at("clothed");
    manifest.provenance = json.at("provenance");
    for (const Json& entry : json.at("files")) {
      PackedFile file;
      file.name = entry.at("name");
      file.size = entry.at("bytes");
      file.crc32c = static_cast<std::uint32_t>(std::stoul(entry.at("crc32c").get<std::string>(), nullptr, 16));
      file.magic = entry.value("magic", "");
      file.format = entry.value("format", 0U);
      if (!is_safe_name(file.name) || file.size > kFileBytesMax)
        return Error{ErrorCode::corrupt, what + ": the manifest lists a file '" + file.name + "' of " +
                                             std::to_string(file.size) +
                                             " bytes, expected a path below the pack's folder and at most " +
                                             std::to_string(kFileBytesMax) + " bytes"};
      manifest.files.push_back(std::move(file));
    }
    if (manifest.files.empty() || manifest.files.size() > kFilesMax)
      return Error{ErrorCode::corrupt, what + ": the manifest lists " + std::to_string(manifest.files.size()) +
                                           " files, expected 1 to " + std::to_string(kFilesMax)};
    return manifest;
  } catch (const std::exception& error) {  // of JSON and of numbers
    return Error{ErrorCode::corrupt, what + ": the manifest cannot be read: " + error.what()};
  }
}

PackedFile describe_file(const std::string& name, const std::vector<std::byte>& bytes) {
  PackedFile file;
  file.name = name;
  file.size = bytes.size();
  file.crc32c = crc32c(bytes);
  if (bytes.size() < kHeadBytes) return file;
  const std::string magic(reinterpret_cast<const char*>(bytes.data()), kMagicBytes);
  if (known_of(magic) == nullptr) return file;
  file.magic = magic;
  std::memcpy(&file.format, bytes.data() + kMagicBytes, sizeof file.format);
  return file;
}

Result<std::vector<std::byte>> make_pack(const PackManifest& manifest,
                                         const std::vector<std::vector<std::byte>>& contents) {
  ContainerWriter writer(kPackMagic, kPackVersion);
  const std::string text = manifest_json(manifest);
  writer.add_array<char>("manifest", std::span(text.data(), text.size()));
  for (std::size_t i = 0; i < contents.size(); ++i) {
    auto packed = compress_xz(contents[i]);
    if (!packed) return packed.error();
    writer.add(section_name(i), std::move(*packed));
  }
  return writer.finish();
}

Result<ModelPack> read_pack(const std::string& path) {
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  if (auto ok = check_pack_version(file->bytes(), path); !ok) return ok.error();
  const auto container = ContainerReader::parse(file->bytes(), kPackMagic, kPackVersion, path);
  if (!container) return container.error();
  const auto text = container->array<char>("manifest");
  if (!text) return text.error();
  auto manifest = parse_manifest(std::string(text->data(), text->size()), path);
  if (!manifest) return manifest.error();
  ModelPack pack;
  pack.manifest = std::move(*manifest);
  for (const PackedFile& packed : pack.manifest.files)
    if (auto ok = check_format(packed, path); !ok) return ok.error();
  for (std::size_t i = 0; i < pack.manifest.files.size(); ++i) {
    const PackedFile& packed = pack.manifest.files[i];
    const auto bytes = container->section(section_name(i));
    if (!bytes) return bytes.error();
    auto content = decompress_xz(*bytes, static_cast<std::size_t>(packed.size), path + ": " + packed.name);
    if (!content) return content.error();
    const PackedFile found = describe_file(packed.name, *content);
    if (found.crc32c != packed.crc32c || found.magic != packed.magic || found.format != packed.format)
      return Error{ErrorCode::corrupt, path + ": " + packed.name + " differs from the manifest; get the pack again"};
    pack.contents.push_back(std::move(*content));
  }
  return pack;
}

Status install_pack(const ModelPack& pack, const std::string& directory) {
  if (auto ok = make_directory(directory); !ok) return ok;
  const std::string manifest = directory + "/" + kManifestName;
  std::error_code code;
  std::filesystem::remove(manifest, code);
  if (code) return Error{ErrorCode::io, "cannot remove " + manifest + ": " + code.message()};
  for (std::size_t i = 0; i < pack.contents.size(); ++i) {
    const std::filesystem::path path = std::filesystem::path(directory) / pack.manifest.files[i].name;
    if (auto ok = make_directory(path.parent_path().string()); !ok) return ok;
    if (auto ok = write_file_atomically(path.string(), pack.contents[i]); !ok) return ok;
  }
  return write_file_atomically(manifest, manifest_json(pack.manifest));
}

Result<PackManifest> installed_manifest(const std::string& directory) {
  const std::string path = directory + "/" + kManifestName;
  const auto text = text_of(path);
  if (!text) return text.error();
  return parse_manifest(*text, path);
}

Status verify_installed(const PackManifest& manifest, const std::string& directory) {
  for (const PackedFile& expected : manifest.files) {
    const std::string path = directory + "/" + expected.name;
    if (auto ok = check_format(expected, directory); !ok) return ok;
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    const PackedFile found = describe_file(expected.name, *bytes);
    if (found.size != expected.size || found.crc32c != expected.crc32c)
      return Error{ErrorCode::corrupt,
                   fmt::format("{}: {} bytes with CRC-32C {:08x}, expected {} with {:08x}; install the pack again",
                               path, found.size, found.crc32c, expected.size, expected.crc32c)};
  }
  return Ok{};
}

}  // namespace im2fit::apps
