// SPDX-License-Identifier: Apache-2.0
// A model pack (.i2p): body, tracker and index that were made for each other, with tape, size charts and the licence,
// in one compressed file that a device installs (docs/models.md).
//
// The file is a container (formats/model_pack.h): section "manifest" is JSON, schema im2fit.models/1; each file that
// it lists has a section: the models by their names, others by their numbers in the list. The same files give the
// same bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/status.h"
#include "formats/model_pack.h"

namespace im2fit::apps {

inline constexpr char kManifestName[] = "models.json";  // beside installed files: which pack they are of

struct PackedFile {
  std::string name;  // "body.i2b", "size-charts/en13402-3-men.csv": letters of ASCII, no control characters
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
// Nothing in it is beyond a limit, each file has a name of its own, and the three models are there.
// `what` names the file in errors. Errors: corrupt; unsupported for another schema.
Result<PackManifest> parse_manifest(const std::string& text, const std::string& what);

// Describes a file of these bytes, to be packed. Fills in the fields of PackManifest::files.
PackedFile describe_file(const std::string& name, const std::vector<std::byte>& bytes);
// `contents` in the order of manifest.files. A second a MB where they are compressed.
Result<std::vector<std::byte>> make_pack(const PackManifest& manifest,
                                         const std::vector<std::vector<std::byte>>& contents,
                                         PackCoding coding = PackCoding::zstd);

// A pack that is what this program reads, by its manifest; its files are still packed.
struct PackOnDisk {
  std::string path;
  MappedFile file;
  ModelPack pack;
  PackManifest manifest;
};
// Errors: corrupt where it is damaged; unsupported, naming the file inside and both versions, where it is older or
// newer.
Result<PackOnDisk> open_pack(const std::string& path);
// Unpacks every file, one at a time, and keeps none. Errors: corrupt, naming the file inside.
Status verify_pack(const PackOnDisk& pack);

// Unpacks the files into a folder of their own within `directory`, one at a time, then renames each to its place, the
// manifest last: until then it is taken away, so that files of two packs are never taken for one set. A full disk or
// a damaged pack leaves the old models. Errors: as verify_pack; io, also while another program installs there.
Status install_pack(const PackOnDisk& pack, const std::string& directory);

// The manifest beside installed files. Errors: not_found; as parse_manifest.
Result<PackManifest> installed_manifest(const std::string& directory);
// Checks every installed file against the manifest. Errors name the file and the fault.
Status verify_installed(const PackManifest& manifest, const std::string& directory);

}  // namespace im2fit::apps
