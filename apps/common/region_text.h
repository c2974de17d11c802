// SPDX-License-Identifier: Apache-2.0
// The text of a region: --region, the operator's page, sessions and im2fitd have the same.
#pragma once

#include <optional>
#include <string>

#include "core/floor_region.h"

namespace im2fit::apps {

// The region that a text "x0,z0,x1,z1" means, in metres on the floor. No value for any other text.
std::optional<FloorRegion> region_of(const std::string& text);
// The fault in such a text, "" for none.
std::string region_fault(const std::string& text);

}  // namespace im2fit::apps
