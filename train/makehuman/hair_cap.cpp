// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/hair_cap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "train/makehuman/smooth.h"

namespace im2fit::body::makehuman {
namespace {

constexpr Vec3f kHeadMiddle = {0, 745, 55};  // level with the ears' tops
constexpr float kRimMm = 16;                 // of skin below the hairline, over which the hair's edge goes under it
constexpr float kBuriedMm = 5;

struct Mark {
  float degrees;  // about the upright axis, 0 before the face, 180 behind the head
  float value;
};

// Heights of the hairline, mm: forehead, temple, sideburn, over or round the ear, nape.
constexpr Mark kManLine[] = {{0, 797},  {25, 795},  {45, 784},  {58, 768},  {66, 742},  {72, 722},  {84, 720},
                             {90, 742}, {108, 748}, {122, 738}, {130, 700}, {140, 672}, {155, 660}, {180, 658}};
constexpr Mark kWomanLine[] = {{0, 800},  {20, 796}, {36, 780},  {48, 755},  {58, 720}, {66, 685},
                               {74, 658}, {90, 642}, {120, 632}, {150, 624}, {180, 620}};

float along(std::span<const Mark> marks, float degrees) {
  for (std::size_t i = 1; i < marks.size(); ++i)
    if (degrees <= marks[i].degrees) {
      const float share = (degrees - marks[i - 1].degrees) / (marks[i].degrees - marks[i - 1].degrees);
      return marks[i - 1].value + share * (marks[i].value - marks[i - 1].value);
    }
  return marks.back().value;
}

// How steeply the hairline rises along the head, mm a mm.
float slope(std::span<const Mark> marks, float degrees) {
  constexpr float kStep = 3, kMmADegree = 1.4F;  // of a head 160 mm broad
  return (along(marks, std::min(degrees + kStep, 180.0F)) - along(marks, std::max(degrees - kStep, 0.0F))) /
         (2 * kStep * kMmADegree);
}

float degrees_about(Vec3f p) {
  return std::atan2(std::fabs(p.x), p.z - kHeadMiddle.z) * 180 / std::numbers::pi_v<float>;
}

bool is_ear(Vec3f p) {
  return std::fabs(p.x) > 75 && p.y < 742 && p.y > 670 && p.z < 56;
}

// The skull's distance from the head's middle, without ears, in every direction.
class Skull {
 public:
  explicit Skull(std::span<const Vec3f> body, std::span<const std::uint8_t> on_head) {
    for (std::size_t v = 0; v < on_head.size(); ++v) {
      const Vec3f p = body[v];
      if (on_head[v] == 0 || p.y < 700 || is_ear(p) || norm(p - kHeadMiddle) < 60) continue;
      directions_.push_back(normalized(p - kHeadMiddle));
      distances_.push_back(norm(p - kHeadMiddle));
    }
  }
  float distance(Vec3f direction) const {
    constexpr float kWidth = 0.15F;  // of a direction: 9 degrees
    float sum = 0, weights = 1e-9F;
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const Vec3f d = directions_[i] - direction;
      const float weight = std::exp(-dot(d, d) / (2 * kWidth * kWidth));
      sum += weight * distances_[i];
      weights += weight;
    }
    return sum / weights;
  }

 private:
  std::vector<Vec3f> directions_;
  std::vector<float> distances_;
};

// How thick hair is where it has its full thickness, mm.
float thickness_mm(Vec3f p, LookOf whose) {
  const float top = smooth(p.y, 745, 835), behind = smooth(degrees_about(p), 60, 150);
  if (whose == LookOf::man) return 5 + 9 * top + 2 * behind * (1 - top);
  return 17 + 1 * top + 5 * behind * (1 - top);
}

// Where the hair over a vertex is. Below the head's middle long hair hangs straight down, a little inwards at its
// end.
Vec3f hair_over(Vec3f p, const Skull& skull, LookOf whose, float above_mm) {
  const bool hangs = p.y < kHeadMiddle.y;
  const Vec3f level = {p.x, hangs ? kHeadMiddle.y : p.y, p.z};
  const Vec3f direction = normalized(level - kHeadMiddle);
  const float own = norm(level - kHeadMiddle);
  float full = skull.distance(direction);
  if (whose == LookOf::man && hangs) full = is_ear(p) ? full : own;  // cropped hair follows the nape
  full += thickness_mm(p, whose);
  if (whose == LookOf::woman && hangs) full -= 14 * smooth(p.y, 690, 620);
  const float buried = std::min(own, is_ear(p) ? skull.distance(direction) : own) - kBuriedMm;
  const float edge_mm = whose == LookOf::woman && hangs ? 10.0F : 22.0F;
  const float share = smooth(above_mm, -3, edge_mm);
  Vec3f at = kHeadMiddle + direction * (buried + (full - buried) * share);
  if (hangs) at.y = p.y;
  return at;
}

bool about_ear(Vec3f p) {
  return std::fabs(p.x) > 56 && p.y > 656 && p.y < 750 && p.z > -20 && p.z < 66;
}

}  // namespace

float above_hairline_mm(Vec3f p, LookOf whose) {
  const std::span<const Mark> line = whose == LookOf::man ? std::span<const Mark>(kManLine) : kWomanLine;
  const float degrees = degrees_about(p), steep = slope(line, degrees);
  return (p.y - along(line, degrees)) / std::sqrt(1 + steep * steep);
}

std::vector<HairRecord> hair_cap(std::span<const Vec3f> body, std::span<const std::uint8_t> on_head) {
  const Skull skull(body, on_head);
  std::array<std::vector<Vec3f>, 2> hair;
  std::array<std::vector<float>, 2> above;
  for (const LookOf whose : {LookOf::man, LookOf::woman}) {
    const auto style = static_cast<std::size_t>(whose);
    for (std::size_t v = 0; v < on_head.size(); ++v) {
      above[style].push_back(on_head[v] != 0 ? above_hairline_mm(body[v], whose) : -1e9F);
      hair[style].push_back(on_head[v] != 0 ? hair_over(body[v], skull, whose, above[style].back()) : body[v]);
    }
  }
  std::vector<HairRecord> records;
  for (std::size_t v = 0; v < on_head.size(); ++v) {
    // The mouth's and the eyes' insides are of the head, too, and never near hair.
    if (on_head[v] == 0 || (norm(body[v] - kHeadMiddle) < 50 && body[v].y > 700)) continue;
    if (std::max(above[0][v], above[1][v]) <= -kRimMm) continue;
    HairRecord record;
    record.vertex = static_cast<std::uint16_t>(v);
    if (about_ear(body[v])) record.above = kHairOverEar;
    for (std::size_t style = 0; style < hair.size(); ++style) {
      if (above[style][v] > 0) record.above = static_cast<std::uint16_t>(record.above | 1U << style);
      const Vec3f offset = (hair[style][v] - body[v]) * (1 / kHairUnitMm);
      const std::array<float, 3> axes = {offset.x, offset.y, offset.z};
      for (std::size_t i = 0; i < 3; ++i)
        record.offset[style][i] = static_cast<std::int16_t>(std::lround(std::clamp(axes[i], -32000.0F, 32000.0F)));
    }
    records.push_back(record);
  }
  return records;
}

}  // namespace im2fit::body::makehuman
