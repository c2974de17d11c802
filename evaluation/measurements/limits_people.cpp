// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/limits_people.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>

#include "body/model_data.h"
#include "core/rng.h"

namespace im2fit::lab {
namespace {

using body::Segment;

float weight_of(const SkinRecord& record, Segment segment) {
  float weight = 0;
  for (std::size_t k = 0; k < record.segment.size(); ++k)
    if (record.segment[k] == static_cast<std::uint8_t>(segment)) weight += record.weight[k];
  return weight;
}

Vec3f mixed(Vec3f a, Vec3f b, float share) {
  return a + (b - a) * share;
}

float height_of(std::span<const Vec3f> mesh) {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  for (const Vec3f& p : mesh) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  return high - low;
}

// The head about its joint.
void grow_head(std::span<Vec3f> mesh, std::span<const SkinRecord> skin, Vec3f joint, float by) {
  for (std::size_t i = 0; i < mesh.size() && i < skin.size(); ++i)
    mesh[i] = mixed(mesh[i], joint + (mesh[i] - joint) * by, weight_of(skin[i], Segment::head));
}

// Of `body` vertices of a mesh whose parts all scale.
void scale_to(std::span<Vec3f> all, std::size_t body, std::span<const SkinRecord> skin, body::Skeleton& bones,
              float stature_mm, bool child) {
  const auto head = static_cast<std::size_t>(Segment::head);
  if (child) grow_head(all.first(body), skin, bones.head[head], std::sqrt(height_of(all.first(body)) / stature_mm));
  const float scale = stature_mm / height_of(all.first(body));
  for (Vec3f& p : all) p = p * scale;
  for (Vec3f& p : bones.head) p = p * scale;
  for (Vec3f& p : bones.tail) p = p * scale;
}

// Of one foot, in the rest mesh: heel, ball and toes along it.
struct Foot {
  Vec3f ankle, along;
  float heel = std::numeric_limits<float>::max(), toe = std::numeric_limits<float>::lowest();
};
constexpr float kBallShare = 0.72F;  // of the foot's length from the heel
constexpr float kHeelShare = 0.14F;  // where the heel carries

}  // namespace

void resize(const body::BodyModel& model, float stature_mm, bool child, HeldOutPerson& person) {
  Subject& subject = person.subject;
  if (subject.actor != nullptr) {
    auto actor = std::make_shared<Actor>(*subject.actor);
    scale_to(actor->rest, actor->rest.size(), actor->surface->skin, actor->skeleton, stature_mm, child);
    subject.actor = std::move(actor);
  } else {
    person.rest.resize(static_cast<std::size_t>(model.vertex_count()));
    morph_subject(model, subject, person.rest);
    body::Skeleton bones = body::rest_skeleton(model, person.rest);
    scale_to(person.rest, static_cast<std::size_t>(model.body_vertex_count()), model.data().skin, bones, stature_mm,
             child);
  }
  float& stature = subject.truth[measurement_index(Measurement::stature)];
  const float scale = stature_mm / stature;
  // The weight decides how the arms are held. Nothing else is known.
  const float weight_kg = subject.truth[measurement_index(Measurement::weight)] * scale * scale * scale;
  subject.truth.fill(std::numeric_limits<float>::quiet_NaN());
  stature = stature_mm;
  subject.truth[measurement_index(Measurement::weight)] = weight_kg;
}

void raise_heels(const body::BodyModel& model, float heel_mm, std::vector<Vec3f>& rest) {
  const body::Skeleton bones = body::rest_skeleton(model, rest);
  const auto skin = model.data().skin;
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  for (const Segment segment : {Segment::left_foot, Segment::right_foot}) {
    const auto s = static_cast<std::size_t>(segment);
    Foot foot{bones.head[s], {}};
    foot.along = normalized({bones.tail[s].x - foot.ankle.x, 0, bones.tail[s].z - foot.ankle.z});
    float floor_y = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < count; ++i) {
      if (weight_of(skin[i], segment) < 0.5F) continue;
      const float at = dot(rest[i] - foot.ankle, foot.along);
      foot.heel = std::min(foot.heel, at);
      foot.toe = std::max(foot.toe, at);
      floor_y = std::min(floor_y, rest[i].y);
    }
    const float length = foot.toe - foot.heel;
    const float ball_at = foot.heel + kBallShare * length;
    const float sine = std::min(0.8F, heel_mm / ((kBallShare - kHeelShare) * length));
    const float degrees = std::asin(sine) * 180 / std::numbers::pi_v<float>;
    const Vec3f aside = cross(Vec3f{0, 1, 0}, foot.along);  // turning about it takes the toes down
    const body::Mat3f down = body::rotation_about(aside, degrees);
    const Vec3f ball = foot.ankle + foot.along * ball_at + Vec3f{0, floor_y - foot.ankle.y, 0};
    const Vec3f ball_down = foot.ankle + down * (ball - foot.ankle);
    for (std::size_t i = 0; i < count; ++i) {
      const float weight = weight_of(skin[i], segment);
      if (weight == 0) continue;
      const bool toes = dot(rest[i] - ball, foot.along) > 0;
      const Vec3f moved = toes ? ball_down + (rest[i] - ball) : foot.ankle + down * (rest[i] - foot.ankle);
      rest[i] = mixed(rest[i], moved, weight);
    }
  }
}

namespace {

constexpr int kSkirtAround = 48, kSkirtLevels = 28;
constexpr float kSkirtClearMm = 8;

// What the skirt hangs over: legs and hips, not arms.
std::vector<Vec3f> hung_over(const body::BodyModel& model, std::span<const Vec3f> posed) {
  constexpr Segment kParts[] = {Segment::pelvis,          Segment::abdomen,        Segment::left_upper_leg,
                                Segment::right_upper_leg, Segment::left_lower_leg, Segment::right_lower_leg,
                                Segment::left_foot,       Segment::right_foot};
  std::vector<Vec3f> out;
  const auto skin = model.data().skin;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i)
    if (std::find(std::begin(kParts), std::end(kParts), static_cast<Segment>(skin[i].segment[0])) != std::end(kParts))
      out.push_back(posed[i]);
  return out;
}

DrapedCloth hang_skirt(const std::vector<Vec3f>& over, Vec3f middle, float top, float bottom, float flare_mm,
                       std::uint64_t seed) {
  constexpr auto kTurn = 2 * std::numbers::pi_v<float>;
  std::array<float, kSkirtAround> radius{};
  Rng rng = Rng::for_item(seed, 0x5C127, 0);
  const auto folds = static_cast<float>(6 + rng.index(6));
  const auto phase = static_cast<float>(rng.uniform(0, 6.28));
  DrapedCloth cloth;
  for (int level = 0; level <= kSkirtLevels; ++level) {
    const float down = static_cast<float>(level) / kSkirtLevels;
    const float y = top + (bottom - top) * down;
    const float reach = (top - bottom) / kSkirtLevels;
    // The support function of what is near this level, so that cloth spans hollows; never narrower than above.
    for (int a = 0; a < kSkirtAround; ++a) {
      const float angle = kTurn * static_cast<float>(a) / kSkirtAround;
      for (const Vec3f& p : over) {
        if (std::fabs(p.y - y) > reach) continue;
        const float out = (p.x - middle.x) * std::sin(angle) + (p.z - middle.z) * std::cos(angle) + kSkirtClearMm;
        radius[static_cast<std::size_t>(a)] = std::max(radius[static_cast<std::size_t>(a)], out);
      }
    }
    for (int a = 0; a < kSkirtAround; ++a) {
      const float angle = kTurn * static_cast<float>(a) / kSkirtAround;
      const float fold = 0.3F * flare_mm * std::sin(folds * angle + phase);
      const float r = radius[static_cast<std::size_t>(a)] + down * (flare_mm + fold);
      cloth.vertices.push_back({middle.x + r * std::sin(angle), y, middle.z + r * std::cos(angle)});
    }
  }
  for (std::int32_t level = 0; level < kSkirtLevels; ++level)
    for (std::int32_t a = 0; a < kSkirtAround; ++a) {
      const std::int32_t next = (a + 1) % kSkirtAround, here = level * kSkirtAround, below = here + kSkirtAround;
      cloth.triangles.push_back({here + a, below + a, here + next});
      cloth.triangles.push_back({here + next, below + a, below + next});
    }
  return cloth;
}

}  // namespace

Dresser long_skirt(const body::BodyModel& model, float gap_mm, float flare_mm, std::uint64_t seed) {
  return [&model, gap_mm, flare_mm, seed](std::span<const Vec3f> rest, const body::Skeleton& skeleton,
                                          const body::Pose& pose) {
    std::vector<Vec3f> posed(rest.size());
    body::skin(model, rest, skeleton, pose, posed);
    const body::PosedSkeleton bones = body::pose_skeleton(skeleton, pose);
    const std::vector<Vec3f> over = hung_over(model, posed);
    float low = std::numeric_limits<float>::max();
    for (const Vec3f& p : over) low = std::min(low, p.y);
    const Vec3f middle = bones.head[static_cast<std::size_t>(Segment::pelvis)];
    const float waist = bones.head[static_cast<std::size_t>(Segment::abdomen)].y;
    // Shoes have soles of kSoleLeastMm and more.
    return hang_skirt(over, middle, waist, low - kSoleLeastMm + gap_mm, flare_mm, seed);
  };
}

namespace {

template <class NewDepth>
void change_pixels(const Intrinsics& k, DepthImage picture, const NewDepth& depth) {
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      std::uint16_t& mm = picture.at(u, v);
      if (mm == 0) continue;
      const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), static_cast<float>(mm));
      mm = static_cast<std::uint16_t>(std::lround(std::clamp(depth(p), 0.0F, 65535.0F)));
    }
}

}  // namespace

PictureChange lose_crown(float stature_mm, float lost_mm) {
  return [stature_mm, lost_mm](const Intrinsics& k, const VirtualScene& scene, DepthImage picture) {
    constexpr float kHeadReachMm = 200;
    const FloorPlane floor = scene.floor();
    const Vec3f head = scene.joints(0)[Joint::HE];
    change_pixels(k, picture, [&](Vec3f p) {
      const Vec3f away = p - head;
      const bool hair = dot(floor.up, p) + floor.camera_height_mm > stature_mm - lost_mm &&
                        norm(away - floor.up * dot(floor.up, away)) < kHeadReachMm;
      return hair ? 0 : p.z;
    });
  };
}

PictureChange give_range() {
  return [](const Intrinsics& k, const VirtualScene&, DepthImage picture) {
    change_pixels(k, picture, [](Vec3f p) { return norm(p); });
  };
}

PictureChange distort(float k1) {
  return [k1](const Intrinsics& k, const VirtualScene&, DepthImage picture) {
    std::vector<std::uint16_t> straight;
    straight.reserve(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
    for (int v = 0; v < picture.height; ++v)
      straight.insert(straight.end(), picture.row(v), picture.row(v) + picture.width);
    const DepthView before(straight.data(), picture.width, picture.height);
    for (int v = 0; v < picture.height; ++v)
      for (int u = 0; u < picture.width; ++u) {
        // The ray (x, y) that this lens takes to the pixel: x (1 + k1 r^2) is where it lies, by fixed-point steps.
        const float lens_x = (static_cast<float>(u) - k.cx) / k.fx, lens_y = (static_cast<float>(v) - k.cy) / k.fy;
        float x = lens_x, y = lens_y;
        for (int i = 0; i < 8; ++i) {
          const float bend = 1 + k1 * (x * x + y * y);
          x = lens_x / bend;
          y = lens_y / bend;
        }
        const auto from_u = static_cast<int>(std::lround(k.cx + k.fx * x)),
                   from_v = static_cast<int>(std::lround(k.cy + k.fy * y));
        const bool inside = from_u >= 0 && from_u < picture.width && from_v >= 0 && from_v < picture.height;
        picture.at(u, v) = inside ? before.at(from_u, from_v) : std::uint16_t{0};
      }
  };
}

}  // namespace im2fit::lab
