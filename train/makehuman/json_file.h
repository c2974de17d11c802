// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/status.h"

namespace im2fit::body::makehuman {

// Reads and parses; the error names the file.
Result<nlohmann::json> read_json(const std::string& path);

}  // namespace im2fit::body::makehuman
