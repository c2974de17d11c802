// SPDX-License-Identifier: Apache-2.0
#include "engine/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/observe/observe.h"

namespace im2fit {
namespace {

constexpr int kLooks = 8;               // of one still: a person without a clear head is confirmed after six frames
constexpr float kUsualHeightMm = 1690;  // mean of women and men of ANSUR II
constexpr float kScoreOfFound = 0.01F;  // of a person of whatever height

// 1 for a person of usual height, less for others, 0 for none.
float person_score(DepthView depth, const Intrinsics& intrinsics, const JointModel& joint_model) {
  PersonDetector detector(depth.width, depth.height, joint_model);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
  const MaskImage mask(pixels.data(), depth.width, depth.height);
  Detection seen;
  for (int i = 0; i < kLooks; ++i) seen = detector.sense(depth, intrinsics, mask);
  const Person& person = seen.person;
  if (!person.found) return 0;
  if (!person.floor.known) return kScoreOfFound;
  const float top = mask_height_mm(depth, mask, intrinsics, person);
  if (!(top > 0)) return kScoreOfFound;
  const float ratio = top / kUsualHeightMm;
  return std::max(kScoreOfFound, ratio < 1 ? ratio : 1 / ratio);
}

}  // namespace

hal::DepthDiagnosis diagnose(DepthView depth, const Intrinsics& intrinsics, const JointModel* joint_model) {
  const bool fits =
      intrinsics.width == depth.width && intrinsics.height == depth.height && intrinsics.fx > 0 && intrinsics.fy > 0;
  const auto judge = [&](float unit_mm) {
    std::vector<std::uint16_t> scaled;
    scaled.reserve(static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
    for (int v = 0; v < depth.height; ++v)
      for (int u = 0; u < depth.width; ++u)
        scaled.push_back(
            static_cast<std::uint16_t>(std::min(65535.0F, static_cast<float>(depth.at(u, v)) * unit_mm + 0.5F)));
    return person_score({scaled.data(), depth.width, depth.height}, intrinsics, *joint_model);
  };
  const bool judged = joint_model != nullptr && fits;
  hal::DepthDiagnosis values = hal::depth_diagnosis(depth, judged ? hal::UnitJudge(judge) : nullptr);
  return values.code != hal::DiagnosisCode::none ? values : hal::intrinsics_diagnosis(intrinsics);
}

}  // namespace im2fit
