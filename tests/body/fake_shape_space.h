// SPDX-License-Identifier: Apache-2.0
// A small shape space of random numbers, for tests of files, and the fake body's file with it.
#pragma once

#include <vector>

#include "body/shape_space.h"
#include "core/rng.h"
#include "fake_makehuman.h"
#include "train/makehuman/makehuman.h"

namespace im2fit::body {

inline ShapeSpace fake_shape_space() {
  Rng rng(20261);
  ShapeSpace space;
  space.point_count = kShapePointMin;
  space.shape_count = 3;
  const auto random = [&](std::size_t count, double range) {
    std::vector<float> values(count);
    for (float& v : values) v = static_cast<float>(rng.uniform(-range, range));
    return values;
  };
  space.point_mean = random(space.point_count * kPointValues, 900);
  space.point_basis = random(space.point_count * kPointValues * space.shape_count, 40);
  space.bone_mean = random(kBoneValues, 900);
  space.bone_basis = random(kBoneValues * space.shape_count, 40);
  for (std::size_t i = 0; i < space.point_count; ++i)
    space.skin.push_back({{static_cast<std::uint8_t>(i % kSegmentCount), 2, 0, 0}, {0.75F, 0.25F, 0, 0}});
  return space;
}

// Empty when the fake does not pack.
inline std::vector<std::byte> fake_body_file() {
  const TemporaryFolder folder;
  FakeMakeHuman().write_upstream(folder.path());
  const auto packed = pack_makehuman(folder.path(), kFakeTextureSide);
  if (!packed) return {};
  auto whole = with_shape_space(*packed, fake_shape_space());
  return whole ? std::move(*whole) : std::vector<std::byte>();
}

}  // namespace im2fit::body
