// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/kept_regions.h"

#include "apps/common/events.h"
#include "apps/common/measuring.h"
#include "apps/sessions/store.h"
#include "core/file.h"
#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

constexpr char kRegionsSchema[] = "im2fit.regions/1";

std::string regions_file(const std::string& root) {
  return root + "/" + kKeptRegionsFile;
}

Result<Json> read_regions(const std::string& path) {
  auto json = read_json<Json>(path, kTextBytesMax);
  if (!json) return json;
  if (!json->is_object() || json->value("schema", Json()) != kRegionsSchema ||
      !json->value("cameras", Json()).is_object())
    return Error{ErrorCode::corrupt,
                 path + ": expected an object with schema \"" + kRegionsSchema + "\" and cameras"};
  return json;
}

}  // namespace

Result<std::string> kept_region(const std::string& root, const std::string& camera) {
  const std::string path = regions_file(root);
  const auto json = read_regions(path);
  if (!json && json.error().code == ErrorCode::not_found) return std::string();
  if (!json) return json.error();
  const auto found = (*json)["cameras"].find(camera);
  if (found == (*json)["cameras"].end()) return std::string();
  if (found->is_string() && region_of(found->get<std::string>())) return found->get<std::string>();
  return Error{ErrorCode::corrupt, path + ": cameras." + excerpt(camera) + " is " + excerpt(json_text(*found)) +
                                       ", expected x0,z0,x1,z1 in metres with x0 < x1 and z0 < z1"};
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
