// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/tremor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/rng.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kTremorStream = 0x7E3038;
constexpr double kFrameS = 1.0 / 30;
struct Wave {
  double hertz, share;
};
constexpr std::array<Wave, 4> kWaves = {{{0.3, 0.5}, {0.9, 0.3}, {2, 0.1}, {9, 0.1}}};

}  // namespace

Tremor::Tremor(float amplitude_deg, std::uint64_t seed, const Intrinsics& k)
    : amplitude_rad_(static_cast<double>(amplitude_deg) * std::numbers::pi / 180), seed_(seed), k_(k) {}

Tremor::Turn Tremor::at(std::uint64_t frame) const {
  Rng rng = Rng::for_item(seed_, kTremorStream, 0);
  const auto angle = [&] {
    double sum = 0;
    for (const Wave& wave : kWaves) {
      const double phase = rng.uniform(0, 2 * std::numbers::pi);
      sum += wave.share * std::sin(2 * std::numbers::pi * wave.hertz * kFrameS * static_cast<double>(frame) + phase);
    }
    return amplitude_rad_ * sum;
  };
  Turn turn;
  turn.x = angle();
  turn.y = angle();
  turn.z = angle();
  return turn;
}

hal::CameraPose Tremor::pose(std::uint64_t frame) const {
  const Turn t = at(frame);
  const double cx = std::cos(t.x / 2), sx = std::sin(t.x / 2), cy = std::cos(t.y / 2), sy = std::sin(t.y / 2),
               cz = std::cos(t.z / 2), sz = std::sin(t.z / 2);
  // Quaternions of the turns about z, then y, then x, multiplied.
  return {static_cast<float>(sx * cy * cz + cx * sy * sz),
          static_cast<float>(cx * sy * cz - sx * cy * sz),
          static_cast<float>(cx * cy * sz + sx * sy * cz),
          static_cast<float>(cx * cy * cz - sx * sy * sz),
          {}};
}

void Tremor::run(std::uint64_t frame, DepthImage picture) {
  if (amplitude_rad_ == 0) return;
  before_.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
  const DepthImage before(before_.data(), picture.width, picture.height);
  for (int v = 0; v < picture.height; ++v) std::copy_n(picture.row(v), picture.width, before.row(v));
  const Turn t = at(frame);
  const double cx = std::cos(t.x), sx = std::sin(t.x), cy = std::cos(t.y), sy = std::sin(t.y), cz = std::cos(t.z),
               sz = std::sin(t.z);
  const double fx = static_cast<double>(k_.fx), fy = static_cast<double>(k_.fy), px = static_cast<double>(k_.cx),
               py = static_cast<double>(k_.cy);
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      // The ray of the turned camera's pixel in the axes of the camera at rest: about z, then y, then x.
      const double x = (u - px) / fx, y = (v - py) / fy;
      const double x1 = cz * x - sz * y, y1 = sz * x + cz * y;
      const double x2 = cy * x1 + sy, z2 = cy - sy * x1;
      const double y3 = cx * y1 - sx * z2, z3 = sx * y1 + cx * z2;
      const double from_u = px + fx * x2 / z3 + 0.5, from_v = py + fy * y3 / z3 + 0.5;
      std::uint16_t mm = 0;
      if (from_u >= 0 && from_u < picture.width && from_v >= 0 && from_v < picture.height)
        mm = before.at(static_cast<int>(from_u), static_cast<int>(from_v));
      picture.at(u, v) = mm == 0 ? mm : static_cast<std::uint16_t>(std::lround(mm / z3));
    }
}

}  // namespace im2fit::lab
