// SPDX-License-Identifier: Apache-2.0
// The tailor's measurements (which part a vertex is of) and hair.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "body/model_data.h"
#include "train/population/clothing.h"
#include "train/population/drape.h"

namespace im2fit::lab {
namespace {

using body::Segment;

constexpr int kNormalPasses = 2;
constexpr int kHairPasses = 4;
constexpr double kLongHairShareWomen = 0.55;
constexpr double kLongHairShareMen = 0.08;

float along_bone(Vec3f p, Vec3f head, Vec3f tail) {
  const Vec3f bone = tail - head;
  return dot(p - head, bone) / dot(bone, bone);
}

}  // namespace

bool in_hair_region(const body::Skeleton& skeleton, float crown_y_mm, Vec3f p) {
  const Vec3f low = skeleton.head[static_cast<std::size_t>(Segment::head)];
  const float height = crown_y_mm - low.y;
  const float up = (p.y - low.y) / height;
  const float back = (low.z - p.z) / height;
  return up > 0.78F || (up > 0.25F && back > -0.12F && up - 0.5F * (0.3F - back) > 0.1F);
}

Tailor::Tailor(const body::BodyModel& model) : model_(model) {
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  std::vector<std::vector<std::int32_t>> beside(count);
  for (const auto& quad : model.body_quads()) {
    for (std::size_t c = 0; c < 4; ++c) {
      const std::int32_t a = quad[c], b = quad[(c + 1) % 4];
      if (a == b) continue;
      beside[static_cast<std::size_t>(a)].push_back(b);
      beside[static_cast<std::size_t>(b)].push_back(a);
    }
  }
  for (auto& list : beside) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    neighbour_first_.push_back(static_cast<std::int32_t>(neighbour_.size()));
    neighbour_.insert(neighbour_.end(), list.begin(), list.end());
  }
  neighbour_first_.push_back(static_cast<std::int32_t>(neighbour_.size()));
}

// Area-weighted, then averaged with the neighbours': cloth does not follow every wrinkle of the skin.
void Tailor::find_normals(std::span<const Vec3f> rest) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  normal_.assign(count, {});
  for (const Triangle& t : model_.body_triangles()) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(rest[b] - rest[a], rest[c] - rest[a]);
    for (const std::size_t v : {a, b, c}) normal_[v] = normal_[v] + n;
  }
  for (Vec3f& n : normal_) n = normalized(n);
  for (int pass = 0; pass < kNormalPasses; ++pass) {
    spare_ = normal_;
    for (std::size_t i = 0; i < count; ++i) {
      Vec3f sum = spare_[i];
      for (auto j = neighbour_first_[i]; j < neighbour_first_[i + 1]; ++j)
        sum = sum + spare_[static_cast<std::size_t>(neighbour_[static_cast<std::size_t>(j)])];
      normal_[i] = normalized(sum);
    }
  }
}

void Tailor::locate(std::span<const Vec3f> rest, const body::Skeleton& skeleton) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  const auto skin = model_.data().skin;
  const auto head = [&](Segment s) { return skeleton.head[static_cast<std::size_t>(s)]; };
  hips_y_ = (head(Segment::left_upper_leg).y + head(Segment::right_upper_leg).y) / 2;
  shoulders_y_ = (head(Segment::left_upper_arm).y + head(Segment::right_upper_arm).y) / 2;
  axis_ = (head(Segment::left_upper_leg) + head(Segment::right_upper_leg) + head(Segment::left_upper_arm) +
           head(Segment::right_upper_arm)) *
          0.25F;
  place_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto segment = static_cast<Segment>(skin[i].segment[0]);
    const auto at = static_cast<std::size_t>(segment);
    const Vec3f from = skeleton.head[at], to = skeleton.tail[at];
    const float t = along_bone(rest[i], from, to);
    Place& place = place_[i];
    const Vec3f out = rest[i] - axis_;
    const float up = (rest[i].y - hips_y_) / (shoulders_y_ - hips_y_);
    place = {Part::trunk,
             t,
             norm(rest[i] - (from + (to - from) * t)),
             up,
             std::hypot(out.x, out.z),
             std::atan2(out.x, out.z)};
    switch (segment) {
      case Segment::neck:
        place.part = Part::neck;
        break;
      case Segment::head:
        place.part = Part::head;
        break;
      case Segment::left_upper_arm:
      case Segment::right_upper_arm:
        place.part = Part::arm;
        place.along = std::min(t, 1.0F);
        break;
      case Segment::left_lower_arm:
      case Segment::right_lower_arm:
        place.part = Part::arm;
        place.along = 1 + std::max(t, 0.0F);
        break;
      case Segment::left_hand:
      case Segment::right_hand:
        place.part = Part::hand;
        break;
      case Segment::left_upper_leg:
      case Segment::right_upper_leg:
        place.part = Part::leg;
        place.along = std::min(t, 1.0F);
        break;
      case Segment::left_lower_leg:
      case Segment::right_lower_leg:
        place.part = Part::leg;
        place.along = 1 + std::max(t, 0.0F);
        break;
      case Segment::left_foot:
      case Segment::right_foot:
        place.part = Part::foot;
        break;
      default:
        place.along = up;
    }
  }
}

// Volume away from the head's middle, fading at the hairline; long hair also covers the neck's back and sides.
void Tailor::grow_hair(std::span<const Vec3f> rest, const body::Skeleton& skeleton, bool woman, Rng& rng,
                       Outfit& out) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  const float volume = static_cast<float>(kHairMostMm) * static_cast<float>(rng.uniform() * rng.uniform(0.4, 1));
  const bool long_hair = rng.uniform() < (woman ? kLongHairShareWomen : kLongHairShareMen);
  const Folds curls(rng, 50, 140, {0, 1, 0}, 2);
  const Vec3f low = skeleton.head[static_cast<std::size_t>(Segment::head)];
  float crown = low.y;
  for (std::size_t i = 0; i < count; ++i) crown = std::max(crown, rest[i].y);
  const Vec3f middle{low.x, low.y + 0.55F * (crown - low.y), low.z};
  ease_.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const Part part = place_[i].part;
    const bool head = part == Part::head && in_hair_region(skeleton, crown, rest[i]);
    const bool nape = long_hair && part == Part::neck && out.cover[i] == Cover::bare && rest[i].z < low.z + 25;
    if (head || nape) ease_[i] = 1;
  }
  for (int pass = 0; pass < kHairPasses; ++pass) {
    next_.assign(ease_.begin(), ease_.end());
    for (std::size_t i = 0; i < count; ++i) {
      if (ease_[i] <= 0) continue;
      float sum = ease_[i], shares = 1;
      for (auto j = neighbour_first_[i]; j < neighbour_first_[i + 1]; ++j) {
        sum += ease_[static_cast<std::size_t>(neighbour_[static_cast<std::size_t>(j)])];
        shares += 1;
      }
      next_[i] = sum / shares;
    }
    ease_.swap(next_);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (ease_[i] <= 0) continue;
    const float thick = std::clamp(volume * ease_[i] * (1 + 0.2F * curls.at(rest[i])), 0.0F, kHairMostMm);
    const Vec3f away = rest[i].y < middle.y ? Vec3f{rest[i].x - middle.x, 0, rest[i].z - middle.z} : rest[i] - middle;
    out.rest[i] = rest[i] + normalized(away) * thick;
    out.cover[i] = Cover::hair;
  }
}

}  // namespace im2fit::lab
