// SPDX-License-Identifier: Apache-2.0
#include "index/sample.h"

namespace im2fit::index {

std::vector<FeatureGroup> default_groups(std::size_t feature_size) {
  const auto size = static_cast<std::uint32_t>(feature_size);
  if (size < 501) return {{"all", size}};
  std::vector<FeatureGroup> groups = {{"lengths", 4}, {"ratios", 2}, {"fpfh", 495}};
  if (size > 501) groups.push_back({"profile", size - 501});
  return groups;
}

SampleSource source_of(const std::vector<Sample>& samples) {
  return [&samples](const std::function<bool(const Sample&)>& take) -> Status {
    for (const Sample& sample : samples)
      if (!take(sample)) break;
    return Ok{};
  };
}

}  // namespace im2fit::index
