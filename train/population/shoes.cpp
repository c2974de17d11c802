// SPDX-License-Identifier: Apache-2.0
#include "train/population/shoes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "body/model_data.h"

namespace im2fit::lab {
namespace {

using body::Segment;

constexpr int kStations = 12;  // heel to toe
constexpr float kCuffMm = 12;  // above the ankle joint

// Round a section: across 0 (inner side) .. 1, up 0 (sole) .. 1 (instep).
constexpr std::array<std::array<float, 2>, 12> kRound = {{{0.10F, 0.0F},
                                                          {0.5F, 0.0F},
                                                          {0.90F, 0.0F},
                                                          {1.0F, 0.12F},
                                                          {1.0F, 0.45F},
                                                          {0.93F, 0.75F},
                                                          {0.75F, 0.95F},
                                                          {0.5F, 1.0F},
                                                          {0.25F, 0.95F},
                                                          {0.07F, 0.75F},
                                                          {0.0F, 0.45F},
                                                          {0.0F, 0.12F}}};

struct Section {
  float low = 1e9F, high = -1e9F, top = -1e9F;
};

struct FootFrame {
  Vec3f along, aside;
};

void widen(Section& s, const Section& other) {
  s.low = std::min(s.low, other.low);
  s.high = std::max(s.high, other.high);
  s.top = std::max(s.top, other.top);
}

// Each station holds its neighbours', too: the shoe bridges what lies between toes and under the instep.
std::array<Section, kStations> spread(const std::array<Section, kStations>& raw) {
  std::array<Section, kStations> out = raw;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (i > 0) widen(out[i], raw[i - 1]);
    if (i + 1 < raw.size()) widen(out[i], raw[i + 1]);
  }
  return out;
}

void make_one(const body::BodyModel& model, std::span<const Vec3f> rest, const body::Skeleton& skeleton,
              Segment segment, float leather, float sole, std::vector<Vec3f>& vertices,
              std::vector<Triangle>& triangles) {
  const Vec3f ankle = skeleton.head[static_cast<std::size_t>(segment)];
  const Vec3f toe = skeleton.tail[static_cast<std::size_t>(segment)];
  const Vec3f along = normalized({toe.x - ankle.x, 0, toe.z - ankle.z});
  const Vec3f aside{along.z, 0, -along.x};
  float heel_s = 1e9F, toe_s = -1e9F, floor_y = 1e9F;
  const auto skin = model.data().skin;
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  const auto of_foot = [&](std::size_t i) { return static_cast<Segment>(skin[i].segment[0]) == segment; };
  for (std::size_t i = 0; i < count; ++i) {
    if (!of_foot(i)) continue;
    const float s = dot(rest[i] - ankle, along);
    heel_s = std::min(heel_s, s);
    toe_s = std::max(toe_s, s);
    floor_y = std::min(floor_y, rest[i].y);
  }
  const float step = (toe_s - heel_s) / static_cast<float>(kStations - 1);
  std::array<Section, kStations> sections{};
  for (std::size_t i = 0; i < count; ++i) {
    if (!of_foot(i)) continue;
    const Vec3f p = rest[i] - ankle;
    const int at = std::clamp(static_cast<int>(std::lround((dot(p, along) - heel_s) / step)), 0, kStations - 1);
    const float w = dot(p, aside), y = std::min(rest[i].y, ankle.y + kCuffMm);
    widen(sections[static_cast<std::size_t>(at)], {w, w, y});
  }
  sections = spread(sections);

  const auto first = static_cast<std::int32_t>(vertices.size());
  const auto ring = [&](const Section& s, float at, float across, float up) {
    const float middle = (s.low + s.high) / 2, half = (s.high - s.low) / 2 + leather;
    const float bottom = floor_y - sole, height = (s.top + leather - bottom) * up;
    for (const auto& [x, y] : kRound)
      vertices.push_back(Vec3f{ankle.x, 0, ankle.z} + along * at + aside * (middle + (2 * x - 1) * half * across) +
                         Vec3f{0, bottom + y * height, 0});
  };
  ring(sections.front(), heel_s - leather, 0.6F, 0.85F);
  for (int i = 0; i < kStations; ++i)
    ring(sections[static_cast<std::size_t>(i)], heel_s + step * static_cast<float>(i), 1, 1);
  ring(sections.back(), toe_s + leather + 5, 0.6F, 0.7F);
  const auto around = static_cast<std::int32_t>(kRound.size());
  const std::int32_t rings = kStations + 2;
  const auto heel_cap = static_cast<std::int32_t>(vertices.size());
  const auto centre = [&](std::int32_t of) {
    Vec3f sum;
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t at = first + of * around + i;
      sum = sum + vertices[static_cast<std::size_t>(at)];
    }
    return sum * (1 / static_cast<float>(around));
  };
  const Vec3f heel_middle = centre(0) - along * 2, toe_middle = centre(rings - 1) + along * 5;
  vertices.push_back(heel_middle);
  vertices.push_back(toe_middle);

  std::vector<Triangle> made;
  for (std::int32_t r = 0; r + 1 < rings; ++r) {
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t a = first + r * around + i, b = first + r * around + (i + 1) % around;
      made.push_back({a, a + around, b});
      made.push_back({b, a + around, b + around});
    }
  }
  const std::int32_t last = first + (rings - 1) * around;
  for (std::int32_t i = 0; i < around; ++i) {
    made.push_back({heel_cap, first + i, first + (i + 1) % around});
    made.push_back({heel_cap + 1, last + (i + 1) % around, last + i});
  }
  float volume = 0;
  const auto from_ankle = [&](std::int32_t v) { return vertices[static_cast<std::size_t>(v)] - ankle; };
  for (const Triangle& t : made) volume += dot(from_ankle(t[0]), cross(from_ankle(t[1]), from_ankle(t[2])));
  for (Triangle& t : made) {
    if (volume < 0) std::swap(t[1], t[2]);
    triangles.push_back(t);
  }
}

}  // namespace

void make_shoes(const body::BodyModel& model, std::span<const Vec3f> rest, const body::Skeleton& skeleton,
                float leather_mm, float sole_mm, std::vector<Vec3f>& vertices, std::vector<Triangle>& triangles) {
  vertices.clear();
  triangles.clear();
  for (const Segment foot : {Segment::left_foot, Segment::right_foot})
    make_one(model, rest, skeleton, foot, leather_mm, sole_mm, vertices, triangles);
}

}  // namespace im2fit::lab
