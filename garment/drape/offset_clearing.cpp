// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/offset_clearing.h"

#include <algorithm>
#include <utility>

namespace im2fit::body {
namespace {

constexpr float kReachMm = 40, kCrumpledReachMm = 60;
constexpr unsigned kLookEvery = 4;  // times; in between skin is followed from where it was
// One vertex's push may take another back in, where limbs meet; and what is pushed may meet other skin.
constexpr int kPushes = 3, kLooks = 2;
// Where segments are turned so far against each other that half of an offset is lost, a push would be a leap.
constexpr float kLeastSquared = 0.25F;

}  // namespace

OffsetClearing::OffsetClearing(ClothPart fine, std::span<const Refinement::Spot> spots, const Cloth& cloth)
    : rest_(std::move(fine.rest)),
      segments_(std::move(fine.segments)),
      weights_(std::move(fine.weights)),
      spots_(spots.begin(), spots.end()),
      triangles_(cloth.mesh().triangles),
      shown_(rest_.size()),
      normals_(rest_.size()),
      hint_(rest_.size(), -1),
      far_(rest_.size(), 0),
      place_(rest_.size()) {
  std::int32_t corners = 0;
  for (const Refinement::Spot& spot : spots_)
    corners = std::max({corners, spot.corner[0], spot.corner[1], spot.corner[2]});
  moved_.resize(static_cast<std::size_t>(corners) + 1);
  for (std::size_t v = 0; v < rest_.size(); ++v) limbs_.push_back(cloth.limbs(v));
  inside_.reserve(rest_.size());
}

Vec3f OffsetClearing::offset_of(std::size_t vertex, std::span<const Vec3f> offsets) const {
  const Refinement::Spot& spot = spots_[vertex];
  Vec3f sum{};
  for (std::size_t k = 0; k < 3; ++k) sum = sum + offsets[static_cast<std::size_t>(spot.corner[k])] * spot.share[k];
  return sum;
}

bool OffsetClearing::is_moved(std::size_t vertex) const {
  const auto& corner = spots_[vertex].corner;
  return (moved_[static_cast<std::size_t>(corner[0])] | moved_[static_cast<std::size_t>(corner[1])] |
          moved_[static_cast<std::size_t>(corner[2])]) != 0;
}

void OffsetClearing::show(const Unposing& unposing, std::span<const Vec3f> offsets) {
  for (std::size_t v = 0; v < rest_.size(); ++v)
    if (is_moved(v)) shown_[v] = unposing.motion(segments_[v], weights_[v]).of(rest_[v] + offset_of(v, offsets));
}

// Not of length 1.
void OffsetClearing::update_normals() {
  std::fill(normals_.begin(), normals_.end(), Vec3f{});
  for (const auto& t : triangles_) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(shown_[b] - shown_[a], shown_[c] - shown_[a]);
    for (const std::size_t v : {a, b, c}) normals_[v] = normals_[v] + n;
  }
}

// The skin's grid is of the frame's beginning: what is found there is followed to where it is at the end.
bool OffsetClearing::find_skin(const BodySurface& skin, std::size_t v) {
  SkinPlace& place = place_[v];
  if (far_[v] > 0 && far_[v]++ < kLookEvery) return false;
  far_[v] = 0;
  const bool look = hint_[v] < 0 || (looks_ + v) % kLookEvery == 0;
  if (hint_[v] < 0 && v > 0) hint_[v] = hint_[v - 1];
  const bool found = (!look || skin.nearest(shown_[v], normals_[v], 0, limbs_[v], kReachMm, hint_[v], place)) &&
                     skin.follow_at_end(shown_[v], normals_[v], 0, limbs_[v], kReachMm, hint_[v], place);
  if (found) {
    const Vec3f off = shown_[v] - skin.at(place, true);
    const float before = dot(off, skin.facing(place, true));
    if (before >= 0 || 2 * before * before >= dot(off, off)) return true;
  }
  // As in Cloth: crumpled cloth faces skin that it does not lie on, and gives way to the nearest.
  std::int32_t hint = hint_[v];
  const bool near = skin.nearest(shown_[v], {}, -1, limbs_[v], kCrumpledReachMm, hint, place) &&
                    skin.follow_at_end(shown_[v], {}, -1, limbs_[v], kCrumpledReachMm, hint, place);
  if (!near) far_[v] = 1;
  return near;
}

void OffsetClearing::find_inside(const BodySurface& skin, const Unposing& unposing, std::span<const Vec3f> offsets) {
  inside_.clear();
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    if (!is_moved(v) || !find_skin(skin, v)) continue;
    const Vec3f facing = skin.facing(place_[v], true);
    const float off_mm = dot(shown_[v] - skin.at(place_[v], true), facing);
    if (off_mm >= kOffMm) continue;
    const Vec3f per_offset = unposing.motion(segments_[v], weights_[v]).transposed(facing);
    if (dot(per_offset, per_offset) < kLeastSquared) continue;
    inside_.push_back({static_cast<std::int32_t>(v), off_mm, per_offset, offset_of(v, offsets)});
  }
  ++looks_;
}

// Each vertex in its turn moves its three rough vertices by as little as clears it (Kaczmarz 1937, of inequalities).
void OffsetClearing::push_out(std::span<Vec3f> offsets) {
  for (const Inside& inside : inside_) {
    const auto v = static_cast<std::size_t>(inside.vertex);
    const float lacks = kOffMm - inside.off_mm - dot(inside.per_offset, offset_of(v, offsets) - inside.offset);
    if (lacks <= 0) continue;
    const Refinement::Spot& spot = spots_[v];
    float squared = 0;
    for (const float share : spot.share) squared += share * share;
    const float length = lacks / (squared * dot(inside.per_offset, inside.per_offset));
    for (std::size_t k = 0; k < 3; ++k) {
      moved_[static_cast<std::size_t>(spot.corner[k])] = 1;
      Vec3f& offset = offsets[static_cast<std::size_t>(spot.corner[k])];
      offset = offset + inside.per_offset * (length * spot.share[k]);
    }
  }
}

void OffsetClearing::clear(const BodySurface& skin, const Unposing& unposing, std::span<Vec3f> offsets) {
  std::fill(moved_.begin(), moved_.end(), std::uint8_t{1});
  for (int look = 0; look < kLooks; ++look) {
    show(unposing, offsets);
    if (look == 0) update_normals();
    find_inside(skin, unposing, offsets);
    std::fill(moved_.begin(), moved_.end(), std::uint8_t{0});
    for (int push = 0; push < kPushes; ++push) push_out(offsets);
  }
}

}  // namespace im2fit::body
