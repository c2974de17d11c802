// SPDX-License-Identifier: Apache-2.0
#include "hal/steady_view.h"

#include <algorithm>
#include <cassert>

#include "hal/source.h"

namespace im2fit::hal {
namespace {

// Of half of kTurnMaxDeg: the scalar part of a unit quaternion.
constexpr float kTurnMaxHalfCosine = 0.99619470F;
// With a step the ray that meets a pixel of the view depends on the depth there: from the depth of the ray before,
// twice. A person's depth changes by some mm within a step's pixels.
constexpr int kStepRounds = 2;

struct Turn {
  float x, y, z, w;
};
// a after b.
Turn product(const Turn& a, const Turn& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

std::array<float, 9> matrix_of(const Turn& q) {
  return {1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.z * q.w),     2 * (q.x * q.z + q.y * q.w),
          2 * (q.x * q.y + q.z * q.w),     1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.x * q.w),
          2 * (q.x * q.z - q.y * q.w),     2 * (q.y * q.z + q.x * q.w),     1 - 2 * (q.x * q.x + q.y * q.y)};
}

Vec3f turned(const std::array<float, 9>& m, Vec3f v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}
Vec3f turned_back(const std::array<float, 9>& m, Vec3f v) {
  return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
          m[2] * v.x + m[5] * v.y + m[8] * v.z};
}

// The pixel that sees a point before the camera; null outside the picture.
const std::uint16_t* seen(const Intrinsics& k, const std::uint16_t* pixels, Vec3f p) {
  if (!(p.z > 0)) return nullptr;
  const float inverse = 1 / p.z;
  const float column = k.cx + k.fx * (p.x * inverse) + 0.5F, row = k.cy + k.fy * (p.y * inverse) + 0.5F;
  if (!(column >= 0 && column < static_cast<float>(k.width) && row >= 0 && row < static_cast<float>(k.height)))
    return nullptr;
  return pixels + static_cast<std::ptrdiff_t>(row) * k.width + static_cast<std::ptrdiff_t>(column);
}

std::uint16_t whole_mm(float mm) {
  return mm > 0 && mm < 65535.0F ? static_cast<std::uint16_t>(mm + 0.5F) : std::uint16_t{0};
}

}  // namespace

CameraMotion motion_between(const CameraPose& from, const CameraPose& to) {
  const Turn turn = product({-to.x, -to.y, -to.z, to.w}, {from.x, from.y, from.z, from.w});
  return {matrix_of(turn), turned_back(matrix_of({to.x, to.y, to.z, to.w}), from.position_mm - to.position_mm)};
}

void SteadyView::forget() {
  first_.reset();
  before_mm_.reset();
  speed_mm_s_ = {};
  walks_ = false;
}

// The mean over some frames: a told place trembles by some mm.
bool SteadyView::walking(const CameraPose& pose, float seconds) {
  if (!follow_walks_) return false;
  if (before_mm_ && seconds > 0) {
    const Vec3f speed = (pose.position_mm - *before_mm_) * (1 / seconds);
    speed_mm_s_ = speed_mm_s_ + (speed - speed_mm_s_) * (seconds / (seconds + kWalkingS));
  }
  before_mm_ = pose.position_mm;
  walks_ = norm(speed_mm_s_) > (walks_ ? kStandMmS : kWalkMmS);
  return walks_;
}

void SteadyView::prepare(int width, int height) {
  frame_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

bool SteadyView::take(const CameraPose& pose, float seconds) {
  const CameraPose first = first_ ? *first_ : pose;
  const Turn turn = product({-first.x, -first.y, -first.z, first.w}, {pose.x, pose.y, pose.z, pose.w});
  const Vec3f step = pose.position_mm - first.position_mm;
  const bool elsewhere = walking(pose, seconds) || std::max(turn.w, -turn.w) < kTurnMaxHalfCosine ||
                         dot(step, step) > kStepMaxMm * kStepMaxMm;
  // To the bit: a quaternion times its inverse is not quite none.
  const bool at_first = first.x == pose.x && first.y == pose.y && first.z == pose.z && first.w == pose.w &&
                        step.x == 0 && step.y == 0 && step.z == 0;
  first_ = elsewhere ? pose : first;
  to_view_ = elsewhere || at_first ? CameraMotion{} : motion_between(pose, first);
  return !(elsewhere || at_first);
}

Vec3f SteadyView::in_view(Vec3f direction) const {
  return turned(to_view_.turn, direction);
}

void SteadyView::run(const Intrinsics& k, DepthImage frame) {
  assert(frame.width == k.width && frame.height == k.height);
  assert(frame_.size() == static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  for (int v = 0; v < k.height; ++v)
    std::copy_n(frame.row(v), k.width, frame_.data() + static_cast<std::ptrdiff_t>(v) * k.width);
  const float per_fx = 1 / k.fx, per_fy = 1 / k.fy;
  const bool steps = dot(to_view_.step_mm, to_view_.step_mm) > 0;
  const Vec3f forward = turned_back(to_view_.turn, {0, 0, 1});
  for (int v = 0; v < k.height; ++v) {
    const float y = (static_cast<float>(v) - k.cy) * per_fy;
    std::uint16_t* row = frame.row(v);
    for (int u = 0; u < k.width; ++u) {
      const Vec3f ray = {(static_cast<float>(u) - k.cx) * per_fx, y, 1};  // in the view
      const Vec3f direction = turned_back(to_view_.turn, ray);
      const std::uint16_t* from = seen(k, frame_.data(), direction);
      row[u] = 0;
      if (from == nullptr || *from == 0) continue;
      if (!steps) {
        row[u] = whole_mm(static_cast<float>(*from) / direction.z);
        continue;
      }
      float depth_mm = static_cast<float>(*from) / direction.z + to_view_.step_mm.z;
      for (int round = 0; round < kStepRounds && from != nullptr && *from != 0; ++round) {
        from = seen(k, frame_.data(), turned_back(to_view_.turn, ray * depth_mm - to_view_.step_mm));
        if (from == nullptr || *from == 0) break;
        const auto at = static_cast<int>(from - frame_.data());
        const int from_v = at / k.width, from_u = at - from_v * k.width;
        const Vec3f there = {(static_cast<float>(from_u) - k.cx) * per_fx,
                             (static_cast<float>(from_v) - k.cy) * per_fy, 1};
        depth_mm = dot(forward, there) * static_cast<float>(*from) + to_view_.step_mm.z;
      }
      if (from != nullptr && *from != 0) row[u] = whole_mm(depth_mm);
    }
  }
}

}  // namespace im2fit::hal
