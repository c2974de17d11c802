// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/lean.h"

#include <algorithm>
#include <array>

#include "perception/profile/person_frame.h"

namespace im2fit {
namespace {

constexpr float kBinMm = 25.0F;
constexpr int kBinCount = 100;  // from the floor up
constexpr int kHeadBins = 7;
constexpr float kHeadReachMm = 220.0F;   // from the crown: excludes raised hands
constexpr float kLegsFromShare = 0.10F;  // of the crown's height: above the feet, which point at the camera
constexpr float kLegsToShare = 0.38F;
constexpr float kEndShare = 0.004F;  // of the points above the crown or below the soles: noise
constexpr int kPointsMin = 20;
constexpr int kAcross = 160;  // points read along the picture's long side

struct Bin {
  int count = 0;
  float side = 0, depth = 0, height = 0;  // sums
  void operator+=(const Bin& b) {
    count += b.count;
    side += b.side;
    depth += b.depth;
    height += b.height;
  }
};
using Bins = std::array<Bin, kBinCount>;

Bin sum_of(const Bins& bins, int first, int last) {
  Bin sum;
  for (int i = std::max(0, first); i <= std::min(last, kBinCount - 1); ++i) sum += bins[static_cast<std::size_t>(i)];
  return sum;
}

int top_of(const Bins& bins) {
  const float few = kEndShare * static_cast<float>(sum_of(bins, 0, kBinCount - 1).count);
  int above = 0;
  for (int i = kBinCount - 1; i > 0; --i)
    if (static_cast<float>(above += bins[static_cast<std::size_t>(i)].count) > few) return i;
  return 0;
}

}  // namespace

Lean lean_of(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person, const User* head) {
  Lean lean;
  if (!person.floor.known || person.pixel_count == 0) return lean;
  const PersonFrame frame = person_frame(person.floor, person.centroid_mm);
  const int step = std::max(1, (std::max(depth.width, depth.height) + kAcross / 2) / kAcross);
  const bool crowned = head != nullptr && head->has_head;
  const Vec3f crown = crowned ? head->head_mm : Vec3f{};
  Bins all{};
  Bins about_head{};
  for (int v = person.v_min; v <= person.v_max; v += step) {
    for (int u = person.u_min; u <= person.u_max; u += step) {
      if (mask.at(u, v) == 0) continue;
      const Vec3f p =
          unproject(intrinsics, static_cast<float>(u), static_cast<float>(v), static_cast<float>(depth.at(u, v)));
      const float height = frame.height(p);
      if (!(height >= 0 && height < kBinMm * kBinCount)) continue;
      const Bin one = {1, frame.side(p), frame.depth(p), height};
      const auto bin = static_cast<std::size_t>(height / kBinMm);
      all[bin] += one;
      const float side = one.side - frame.side(crown), away = one.depth - frame.depth(crown);
      if (crowned && side * side + away * away < kHeadReachMm * kHeadReachMm) about_head[bin] += one;
    }
  }
  const Bins& of_head = crowned ? about_head : all;
  const int top = top_of(of_head);
  const Bin upper = sum_of(of_head, top - kHeadBins, top);
  const auto tall = static_cast<float>(top + 1);
  const Bin lower = sum_of(all, static_cast<int>(kLegsFromShare * tall), static_cast<int>(kLegsToShare * tall));
  if (upper.count < kPointsMin || lower.count < kPointsMin) return lean;
  const float a = 1.0F / static_cast<float>(upper.count), b = 1.0F / static_cast<float>(lower.count);
  const float side = upper.side * a - lower.side * b;
  const float away = upper.depth * a - lower.depth * b;
  lean.seen = true;
  lean.tangent = norm({side, 0, away}) / (upper.height * a - lower.height * b);
  return lean;
}

}  // namespace im2fit
