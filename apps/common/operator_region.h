// SPDX-License-Identifier: Apache-2.0
// What the operator's page passes to the run behind it.
#pragma once

#include <cstdint>
#include <optional>

#include "core/floor_region.h"

namespace im2fit::apps {

// Where people are measured; no region: everywhere. `count` is another each time that it is set, and 0 while the
// run's own region holds.
struct OperatorRegion {
  std::uint32_t count = 0;
  std::optional<FloorRegion> region;
};

}  // namespace im2fit::apps
