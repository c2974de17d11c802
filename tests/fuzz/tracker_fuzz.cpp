// SPDX-License-Identifier: Apache-2.0
// A .i2t file: refused with one line, or a model that tracks a figure without harm and with finite joints.
#include <cmath>
#include <cstdint>
#include <vector>

#include "perception/joints/tracker.h"
#include "tests/fuzz/mutator.h"
#include "tests/perception/joints_model_builder.h"

namespace {

constexpr int kWidth = 40, kHeight = 60;

}  // namespace

// Nothing to start from is a sound file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  std::vector<std::byte> bytes(reinterpret_cast<const std::byte*>(data),
                               reinterpret_cast<const std::byte*>(data) + size);
  const auto model = JointModel::parse(bytes, "fuzzed.i2t");
  if (!model) {
    if (model.error().message.empty() || model.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  std::vector<std::uint16_t> depth(kWidth * kHeight, 3000);
  std::vector<std::uint8_t> mask(kWidth * kHeight, 0);
  for (int v = 5; v < 55; ++v)
    for (int u = 12; u < 28; ++u) {
      depth[static_cast<std::size_t>(v * kWidth + u)] = static_cast<std::uint16_t>(2000 + v);
      mask[static_cast<std::size_t>(v * kWidth + u)] = 1;
    }
  const Intrinsics k{kWidth, kHeight, 60, 60, 20, 30};
  Person person;
  person.found = true;
  person.id = person.people_count = 1;
  person.u_min = 12;
  person.v_min = 5;
  person.u_max = 27;
  person.v_max = 54;
  person.pixel_count = 16 * 50;
  person.centroid_mm = {0, 0, 2030};
  JointTracker tracker(*model);
  const auto joints = tracker.track(DepthView(depth.data(), kWidth, kHeight), MaskView(mask.data(), kWidth, kHeight),
                                    k, person, false);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = joints.position_mm[j];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) __builtin_trap();
    if (!(joints.confidence[j] >= 0 && joints.confidence[j] <= 1)) __builtin_trap();
  }
  return 0;
}
