// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/kept_regions.h"

#include "apps/kiosk/regions_text.h"
#include "apps/sessions/store.h"
#include "core/file.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

std::string regions_file(const std::string& root) {
  return root + "/" + kKeptRegionsFile;
}

Result<Json> read_regions(const std::string& path) {
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  return parse_regions({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

}  // namespace

Result<std::string> kept_region(const std::string& root, const std::string& camera) {
  const std::string path = regions_file(root);
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes && bytes.error().code == ErrorCode::not_found) return std::string();
  if (!bytes) return bytes.error();
  return region_in({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path, camera);
}

Status keep_region(const std::string& root, const std::string& camera, const std::string& region) {
  if (auto made = sessions::make_root(root); !made) return made;
  auto json = read_regions(regions_file(root));
  if (!json && json.error().code != ErrorCode::not_found && json.error().code != ErrorCode::corrupt)
    return json.error();
  Json all = json ? std::move(*json) : Json{{"schema", kRegionsSchema}, {"cameras", Json::object()}};
  if (region.empty())
    all["cameras"].erase(camera);
  else
    all["cameras"][camera] = region;
  return write_file_atomically(regions_file(root), json_text(all, 2) + "\n", Readable::by_owner);
}

}  // namespace im2fit::apps
