// SPDX-License-Identifier: Apache-2.0
#include "train/index/sample.h"

#include "perception/observe/observe.h"

namespace im2fit::index {

std::vector<FeatureGroup> default_groups(std::size_t feature_size) {
  const auto size = static_cast<std::uint32_t>(feature_size);
  constexpr std::uint32_t kPaper = kPaperFeatureSize, kTraits = kSensorTraits;
  if (size < kPaper) return {{"all", size}};
  std::vector<FeatureGroup> groups = {{"lengths", 4}, {"ratios", 2}, {"fpfh", kPaper - 6}};
  if (size == kFeatureSize) {
    groups.push_back({"profile", static_cast<std::uint32_t>(kProfileSize)});
    groups.push_back({"sensor", kTraits});
  } else if (size > kPaper) {
    groups.push_back({"profile", size - kPaper});
  }
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
