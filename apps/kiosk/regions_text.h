// SPDX-License-Identifier: Apache-2.0
// The text of the file of kept regions (kept_regions.h).
#pragma once

#include <string>
#include <string_view>

#include "apps/common/events.h"
#include "core/status.h"

namespace im2fit::apps {

inline constexpr char kRegionsSchema[] = "im2fit.regions/1";

// The whole file, whose `cameras` is an object. `path` names it in errors. Error: corrupt.
Result<Json> parse_regions(std::string_view text, const std::string& path);
// As kept_region().
Result<std::string> region_in(std::string_view text, const std::string& path, const std::string& camera);

}  // namespace im2fit::apps
