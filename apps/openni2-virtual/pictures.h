// SPDX-License-Identifier: Apache-2.0
// Where the virtual camera's pictures come from.
#pragma once

#include <memory>

#include "core/camera.h"
#include "core/status.h"
#include "settings.h"

namespace im2fit::openni2_virtual {

class Pictures {
 public:
  virtual ~Pictures() = default;
  virtual const Intrinsics& camera() const = 0;
  // Picture `index`, as the sensor delivers it; depends on the settings and the index only.
  virtual void make(std::uint64_t index, DepthImage out) = 0;
};

Result<std::unique_ptr<Pictures>> folder_pictures(const Settings& settings);
Result<std::unique_ptr<Pictures>> person_pictures(const Settings& settings);

}  // namespace im2fit::openni2_virtual
