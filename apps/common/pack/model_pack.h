// SPDX-License-Identifier: Apache-2.0
// A model pack (.i2p): body, tracker and index that were made for each other, with tape, size charts and the licence,
// in one compressed file that a device installs (docs/models.md).
//
// The file is a container (core/container.h, magic "I2PK"): section "manifest" is JSON, schema im2fit.models/1; of
// each file it lists there is a section "0", "1", ... with its bytes compressed (.xz). The same files give the same
// bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::apps {

inline constexpr std::uint32_t kPackVersion = 1;
inline constexpr char kManifestName[] = "models.json";  // beside installed files: which pack they are of

struct PackedFile {
  std::string name;  // "body.i2b", "size-charts/en13402-3-men.csv"
  std::uint64_t size = 0;
  std::uint32_t crc32c = 0;
  // Of files of ours, the four letters and the version they begin with; "" and 0 for others.
  std::string magic;
  std::uint32_t format = 0;
};

struct PackManifest {
  std::string version;  // of the pack: "1.0.0"
  std::string made_by;  // "im2fit-lab 1.0.0"
  std::string source;   // of the body data
  std::string licence;  // SPDX identifier of the models' source data
  std::uint64_t people = 0;
  bool clothed = false;  // whether the index was taught people in clothes
  std::string provenance;
  std::vector<PackedFile> files;
};

std::string manifest_json(const PackManifest& manifest);
// `what` names the file in errors. Errors: corrupt; unsupported for another schema.
Result<PackManifest> parse_manifest(const std::string& text, const std::string& what);

// Describes a file of these bytes, to be packed. Fills in the fields of PackManifest::files.
PackedFile describe_file(const std::string& name, const std::vector<std::byte>& bytes);
// `contents` in the order of manifest.files. A second or two a MB.
Result<std::vector<std::byte>> make_pack(const PackManifest& manifest,
                                         const std::vector<std::vector<std::byte>>& contents);

// A pack that was read and is what this program reads. Errors: corrupt where it is damaged; unsupported, naming the
// file inside and both versions, where it is older or newer.
struct ModelPack {
  PackManifest manifest;
  std::vector<std::vector<std::byte>> contents;
};
Result<ModelPack> read_pack(const std::string& path);

// Writes the files into `directory`, each atomically, the manifest last: until then it is taken away, so that files
// of two packs are never taken for one set.
Status install_pack(const ModelPack& pack, const std::string& directory);

// The manifest beside installed files. Errors: not_found; as parse_manifest.
Result<PackManifest> installed_manifest(const std::string& directory);
// Checks every installed file against the manifest. Errors name the file and the fault.
Status verify_installed(const PackManifest& manifest, const std::string& directory);

}  // namespace im2fit::apps
