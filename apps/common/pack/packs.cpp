// SPDX-License-Identifier: Apache-2.0
#include "apps/common/pack/packs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "apps/common/directory.h"
#include "apps/common/paths.h"
#include "core/crc32c.h"
#include "core/text.h"
#include "formats/json_file.h"
#include "person/data_files.h"

namespace im2fit::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kSchema[] = "im2fit.models/1";
constexpr std::size_t kFilesMax = 100;
constexpr std::size_t kNameBytesMax = 200;
// Where an install unpacks. No name of a pack begins with a point.
constexpr char kUnpackedFolder[] = ".models.part";
constexpr std::size_t kMagicBytes = 4, kHeadBytes = 8;  // magic and version, core/container.h

const KnownModel* known_of(std::string_view magic) {
  for (const KnownModel& known : known_models())
    if (magic == known.magic) return &known;
  return nullptr;
}

// An older or newer file is refused before it is unpacked.
Status check_format(const PackedFile& file, const std::string& what) {
  const KnownModel* known = known_of(file.magic);
  if (known == nullptr || file.format == known->version) return Ok{};
  return other_format(what, known->kind, file.name, file.format, known->version);
}

// Names are written below a directory of ours and nowhere else, and printed.
bool is_safe_name(const std::string& name) {
  if (name.size() > kNameBytesMax || name.substr(0, name.find('/')) == kManifestName) return false;
  for (const char c : name)
    if (c < 0x20 || c >= 0x7F || c == '\\') return false;
  for (std::size_t at = 0; at <= name.size();) {
    const std::size_t end = std::min(name.find('/', at), name.size());
    if (end == at || name[at] == '.') return false;  // "", ".", "..", and what is hidden
    at = end + 1;
  }
  return true;
}

// A number of JSON that is no whole number from 0 on throws.
std::uint64_t whole_number(const Json& json, const char* key) {
  const Json& value = json.at(key);
  if (!value.is_number_unsigned()) throw std::invalid_argument(std::string(key) + " is not a whole number from 0 on");
  return value.get<std::uint64_t>();
}

std::uint32_t checksum(const std::string& text) {
  if (text.size() != 8 || text.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw std::invalid_argument("crc32c is not 8 hexadecimal digits");
  return static_cast<std::uint32_t>(std::stoul(text, nullptr, 16));
}

PackedFile parse_file(const Json& entry) {
  PackedFile file;
  file.name = entry.at("name");
  file.size = whole_number(entry, "bytes");
  file.crc32c = checksum(entry.at("crc32c"));
  file.magic = entry.value("magic", "");
  if (entry.contains("format")) file.format = static_cast<std::uint32_t>(whole_number(entry, "format"));
  return file;
}

// Sizes, names and kinds: before a byte is unpacked. "" or what is wrong.
std::string fault_of_files(const std::vector<PackedFile>& files) {
  if (files.empty() || files.size() > kFilesMax)
    return fmt::format("it lists {} files, expected 1 to {}", files.size(), kFilesMax);
  std::set<std::string> names;
  std::uint64_t sum = 0;
  for (const PackedFile& file : files) {
    if (!is_safe_name(file.name))
      return fmt::format("it lists a file '{}', expected a path below the pack's folder, in letters of ASCII",
                         excerpt(file.name));
    if (!names.insert(file.name).second) return fmt::format("it lists {} twice", file.name);
    if (file.size > kPackBytesMax - sum)
      return fmt::format("its files have more than {} bytes, which no models have", kPackBytesMax);
    sum += file.size;
  }
  // A file and a folder of one name: "a" and "a/b".
  for (const std::string& name : names)
    for (std::size_t at = name.find('/'); at != std::string::npos; at = name.find('/', at + 1))
      if (names.contains(name.substr(0, at))) return fmt::format("{} is a file and a folder", name.substr(0, at));
  for (const KnownModel& known : known_models()) {
    const auto found =
        std::find_if(files.begin(), files.end(), [&](const auto& file) { return file.name == known.file; });
    if (found == files.end()) return fmt::format("it lists no {} ({})", known.kind, known.file);
    if (found->magic != known.magic)
      return fmt::format("{} begins with '{}', expected '{}' of a {}", known.file, excerpt(found->magic), known.magic,
                         known.kind);
  }
  return "";
}

// Of the file of this number and name.
std::string section_name(std::size_t number, const std::string& name) {
  for (const KnownModel& known : known_models())
    if (name == known.file) return name;
  return std::to_string(number);
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
  return json_text(json, 2) + "\n";
}

Result<PackManifest> parse_manifest(const std::string& text, const std::string& what) {
  const auto read = parse_json<Json>(text, what + ": the manifest");
  if (!read) return read.error();
  const Json& json = *read;
  try {
    if (const std::string schema = json.at("schema"); schema != kSchema)
      return Error{ErrorCode::unsupported,
                   fmt::format("{}: the manifest's schema is {}, expected {}", what, excerpt(schema), kSchema)};
    PackManifest manifest;
    manifest.version = json.at("version");
    manifest.made_by = json.at("made_by");
    manifest.source = json.at("source");
    manifest.licence = json.at("licence");
    manifest.people = whole_number(json, "people");
    manifest.clothed = json.at("clothed");
    manifest.provenance = json.at("provenance");
    for (const Json& entry : json.at("files")) manifest.files.push_back(parse_file(entry));
    if (const std::string fault = fault_of_files(manifest.files); !fault.empty())
      return Error{ErrorCode::corrupt, what + ": the manifest: " + fault};
    return manifest;
  } catch (const std::exception& error) {  // of JSON and of numbers
    return Error{ErrorCode::corrupt, what + ": the manifest cannot be read: " + excerpt(error.what())};
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
                                         const std::vector<std::vector<std::byte>>& contents, PackCoding coding) {
  ContainerWriter writer(kPackMagic, kPackVersion);
  const std::string text = manifest_json(manifest);
  writer.add_array<char>(kPackManifest, std::span(text.data(), text.size()));
  for (std::size_t i = 0; i < contents.size(); ++i) {
    auto packed = make_pack_section(contents[i], coding);
    if (!packed) return packed.error();
    writer.add(section_name(i, manifest.files[i].name), std::move(*packed));
  }
  return writer.finish();
}

Result<PackOnDisk> open_pack(const std::string& path) {
  PackOnDisk pack;
  pack.path = path;
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  pack.file = std::move(*file);
  auto opened = ModelPack::parse(pack.file.bytes(), path, true);
  if (!opened) return opened.error();
  pack.pack = std::move(*opened);
  const auto text = pack.pack.section(kPackManifest);
  if (!text) return text.error();
  if (text->size() > kTextBytesMax)
    return Error{ErrorCode::corrupt, fmt::format("{}: the manifest has {} bytes, expected at most {}", path,
                                                 text->size(), kTextBytesMax)};
  auto manifest = parse_manifest({reinterpret_cast<const char*>(text->data()), text->size()}, path);
  if (!manifest) return manifest.error();
  pack.manifest = std::move(*manifest);
  for (const PackedFile& packed : pack.manifest.files)
    if (auto ok = check_format(packed, path); !ok) return ok.error();
  return pack;
}

namespace {

Result<std::vector<std::byte>> unpack(const PackOnDisk& pack, std::size_t number) {
  const PackedFile& packed = pack.manifest.files[number];
  auto content = pack.pack.file(section_name(number, packed.name), packed.size);
  if (!content) return content.error();
  const PackedFile found = describe_file(packed.name, *content);
  if (found.crc32c != packed.crc32c || found.magic != packed.magic || found.format != packed.format)
    return Error{ErrorCode::corrupt,
                 pack.path + ": " + packed.name + " differs from the manifest; get the pack again"};
  return content;
}

// Gone with its owner, and what a killed program left with its next one.
class UnpackedFolder {
 public:
  explicit UnpackedFolder(const std::string& directory) : path_(directory + "/" + kUnpackedFolder) { remove(); }
  ~UnpackedFolder() { remove(); }
  UnpackedFolder(const UnpackedFolder&) = delete;
  UnpackedFolder& operator=(const UnpackedFolder&) = delete;
  std::string path(const std::string& name = "") const { return path_ + "/" + name; }

 private:
  void remove() const {
    std::error_code code;
    std::filesystem::remove_all(path_, code);
  }
  const std::string path_;
};

Status make_parent(const std::string& file) {
  return make_directory(std::filesystem::path(file).parent_path().string());
}

Status rename_to(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) == 0) return Ok{};
  return Error{ErrorCode::io,
               fmt::format("cannot rename to {}: {}; install the pack again", to, std::strerror(errno))};
}

}  // namespace

Status verify_pack(const PackOnDisk& pack) {
  for (std::size_t i = 0; i < pack.manifest.files.size(); ++i)
    if (const auto content = unpack(pack, i); !content) return content.error();
  return Ok{};
}

Status install_pack(const PackOnDisk& pack, const std::string& directory) {
  if (auto ok = make_directory(directory); !ok) return ok;
  const Directory held(directory + "/.");  // which may be a link
  if (!held.lock_if_free())
    return Error{ErrorCode::io, fmt::format("cannot lock {}: {}; is another program installing models there?",
                                            directory, std::strerror(errno))};
  const UnpackedFolder unpacked(directory);
  for (std::size_t i = 0; i < pack.manifest.files.size(); ++i) {
    const std::string& name = pack.manifest.files[i].name;
    const auto content = unpack(pack, i);
    if (!content) return content.error();
    for (const std::string& file : {unpacked.path(name), directory + "/" + name})
      if (auto ok = make_parent(file); !ok) return ok;
    if (auto ok = write_file_atomically(unpacked.path(name), *content); !ok) return ok;
    std::error_code code;
    if (std::filesystem::is_directory(directory + "/" + name, code))
      return Error{ErrorCode::io, directory + "/" + name + " is a directory; move it away"};
  }
  if (auto ok = write_file_atomically(unpacked.path(kManifestName), manifest_json(pack.manifest)); !ok) return ok;
  // From here on nothing is written, so that a full disk stops nothing. The models come last: a name that is new in
  // its folder may still need room.
  const std::string manifest = directory + "/" + kManifestName;
  std::error_code code;
  std::filesystem::remove(manifest, code);
  if (code) return Error{ErrorCode::io, "cannot remove " + manifest + ": " + code.message()};
  // The body last: tracker and index name each other, so that those of two packs are refused.
  const auto turn_of_file = [](const PackedFile& file) {
    return known_of(file.magic) == nullptr ? 0 : file.name == kPackedBody ? 2 : 1;
  };
  for (const int turn : {0, 1, 2})
    for (const PackedFile& file : pack.manifest.files)
      if (turn_of_file(file) == turn)
        if (auto ok = rename_to(unpacked.path(file.name), directory + "/" + file.name); !ok) return ok;
  if (!held.sync()) return Error{ErrorCode::io, "cannot write " + directory + ": " + std::strerror(errno)};
  return rename_to(unpacked.path(kManifestName), manifest);
}

Result<PackManifest> installed_manifest(const std::string& directory) {
  const std::string path = directory + "/" + kManifestName;
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  return parse_manifest({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

Status verify_installed(const PackManifest& manifest, const std::string& directory) {
  for (const PackedFile& expected : manifest.files) {
    const std::string path = directory + "/" + expected.name;
    if (auto ok = check_format(expected, directory); !ok) return ok;
    const auto bytes = read_file(path, kPackBytesMax);
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
