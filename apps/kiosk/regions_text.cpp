// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/regions_text.h"

#include "apps/common/region_text.h"
#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit::apps {

Result<Json> parse_regions(std::string_view text, const std::string& path) {
  auto json = parse_json<Json>(text, path);
  if (!json) return json;
  if (!json->is_object() || json->value("schema", Json()) != kRegionsSchema ||
      !json->value("cameras", Json()).is_object())
    return Error{ErrorCode::corrupt,
                 path + ": expected an object with schema \"" + kRegionsSchema + "\" and cameras"};
  return json;
}

Result<std::string> region_in(std::string_view text, const std::string& path, const std::string& camera) {
  const auto json = parse_regions(text, path);
  if (!json) return json.error();
  const auto found = (*json)["cameras"].find(camera);
  if (found == (*json)["cameras"].end()) return std::string();
  if (found->is_string() && region_of(found->get<std::string>())) return found->get<std::string>();
  return Error{ErrorCode::corrupt, path + ": cameras." + excerpt(camera) + " is " + excerpt(json_text(*found)) +
                                       ", expected x0,z0,x1,z1 in metres with x0 < x1 and z0 < z1"};
}

}  // namespace im2fit::apps
