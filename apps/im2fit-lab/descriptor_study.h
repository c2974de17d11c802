// SPDX-License-Identifier: Apache-2.0
// What the choice of descriptor costs in accuracy: one rendering of each person, described in several ways; an index
// built from each way; the same held-out people asked of all. docs/descriptor.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/common/data_files.h"
#include "index/index.h"
#include "kernels/core/measurement.h"

namespace im2fit::apps {

struct DescriptorWay {
  const char* name;
  float spacing_mm;  // of the grid; 0: every pixel
};
// The device's first, the exact one second: differences are taken from it.
inline constexpr std::array<DescriptorWay, 4> kDescriptorWays = {
    {{"grid 20 mm", 20}, {"exact", 0}, {"grid 15 mm", 15}, {"grid 30 mm", 30}}};
inline constexpr std::size_t kExactWay = 1;

struct DescriptorStudyOptions {
  int training_subjects = 1300;
  int people = 200;
  std::uint64_t seed = 1;  // of training subjects; people are the evaluation's
  int threads = 1;         // does not change the result
};

struct DescriptorStudy {
  int samples = 0;  // that trained or calibrated
  // By way, then person: absolute errors.
  std::array<std::vector<MeasurementValues>, kDescriptorWays.size()> errors;
};

Result<DescriptorStudy> study_descriptors(const body::BodyModel& model, const JointModel& joint_model,
                                          const DescriptorStudyOptions& options);

}  // namespace im2fit::apps
