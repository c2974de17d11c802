// SPDX-License-Identifier: Apache-2.0
// The region in which each camera measures, as the operator set it: kept in a file until it is set again.
#pragma once

#include <string>

#include "core/status.h"

namespace im2fit::apps {

// Beside the sessions, hidden from their list; its owner alone may read it.
inline constexpr char kKeptRegionsFile[] = ".regions.json";

// "x0,z0,x1,z1" in metres (region_of()), or "": everywhere. A camera is known by the name that its source has.
// Errors: io; corrupt, naming the file and the camera whose region is none.
Result<std::string> kept_region(const std::string& root, const std::string& camera);
// Keeps the regions of other cameras. Replaces a damaged file. Makes `root`. Errors: io.
Status keep_region(const std::string& root, const std::string& camera, const std::string& region);

}  // namespace im2fit::apps
