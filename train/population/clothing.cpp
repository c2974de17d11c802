// SPDX-License-Identifier: Apache-2.0
#include "train/population/clothing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "body/model_data.h"
#include "train/common/draw.h"
#include "train/population/drape.h"
#include "train/population/shoes.h"

namespace im2fit::lab {
namespace {

constexpr float kLimbMostMm = 20;  // of loose clothes, off the trunk
// Upper bounds: of a shirt off a slim waist below chest and shoulder blades; of sleeves and legs. Judgement.
constexpr float kHangingMostMm = 120, kHangingLimbMostMm = 28;
constexpr int kDrapePasses = 5;
constexpr float kStiffness = 0.3F;      // how much of its own ease the cloth keeps in a pass
constexpr double kBarefootShare = 0.2;  // of people in clothes, so that shoes do not stand for these: judgement
constexpr double kSkirtShare = 0.3;     // of women not in tight clothes

float smooth(float x) {  // 0..1, level at both ends
  const float t = std::clamp(x, 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}
float mix(float a, float b, float t) {
  return a + (b - a) * t;
}

}  // namespace

EaseRange ease_range(Clothing clothing, bool shirt) {
  switch (clothing) {
    case Clothing::tight:
      return {3, 8};
    case Clothing::normal:
      return {4, 20};
    case Clothing::loose:
      return {6, shirt ? 28.0F : kLimbMostMm};
    case Clothing::hanging:
      return {4, shirt ? kHangingMostMm : kHangingLimbMostMm};
    default:
      return {};
  }
}

// What one person wears. Limb ends as Place::along.
struct Tailor::Cut {
  Clothing clothing = Clothing::none;
  float trunk_mm = 0, arm_mm = 0, leg_mm = 0, fold_mm = 0;
  float sleeve_end = 0, leg_end = 0, collar = 0;
  float hem = 0, waist = 0.35F;  // of upper and lower garment, on the trunk
  float flare = 1;               // of the trouser leg at its end
  float slack_mm = 0;            // TrunkHang
  std::optional<HangingCut> hanging;
  bool skirt = false;
  float skirt_end = 1;  // share of the length from hips to ankles
};

Tailor::Cut Tailor::draw_cut(Clothing clothing, bool woman, Rng& rng) {
  Cut cut;
  cut.clothing = clothing;
  switch (clothing) {
    case Clothing::tight:
      cut.trunk_mm = draw(rng, 3, 5);
      cut.arm_mm = draw(rng, 3, 4.5);
      cut.leg_mm = draw(rng, 3, 4.5);
      cut.fold_mm = 0.4F;
      break;
    case Clothing::normal:
      cut.trunk_mm = draw(rng, 6, 14);
      cut.arm_mm = draw(rng, 5, 11);
      cut.leg_mm = draw(rng, 5, 12);
      cut.fold_mm = draw(rng, 2.0, 4.2);
      break;
    case Clothing::hanging:
      cut.trunk_mm = draw(rng, 5, 26);  // 60 to 140 mm of girth (data/garments, good_mm) are 10 to 22
      cut.arm_mm = draw(rng, 4, 14);
      cut.leg_mm = draw(rng, 4, 12);
      cut.fold_mm = draw(rng, 2.5, 8);
      break;
    default:
      cut.trunk_mm = draw(rng, 14, 24);
      cut.arm_mm = draw(rng, 10, 16);
      cut.leg_mm = draw(rng, 10, 16);
      cut.fold_mm = draw(rng, 4.0, 7.5);
  }
  const double sleeve = rng.uniform();
  cut.sleeve_end = sleeve < 0.08 ? 0.05F : sleeve < 0.45 ? draw(rng, 0.4, 0.95) : draw(rng, 1.7, 1.98);
  cut.leg_end = rng.uniform() < 0.2 ? draw(rng, 0.5, 1.15) : draw(rng, 1.85, 1.98);
  cut.collar = rng.uniform() < 0.1 ? draw(rng, 0.6, 0.9) : draw(rng, -0.2, 0.3);
  cut.hem = rng.uniform() < 0.3 ? 0.3F : draw(rng, -0.25, 0.15);  // tucked in, or over the trousers
  cut.flare = draw(rng, 0.75, 1.35);
  if (clothing == Clothing::hanging) {
    cut.hem = 0.05F;  // of the layer on the skin; the tail falls over it
    cut.flare = 0.7F;
    cut.slack_mm = draw(rng, 0, 1);
  } else {
    cut.slack_mm = clothing == Clothing::loose ? draw(rng, 0, 4) : draw(rng, 2, 9);
  }
  cut.skirt = woman && clothing != Clothing::tight && rng.uniform() < kSkirtShare;
  cut.skirt_end = rng.uniform() < 0.3 ? draw(rng, 0.85, 0.97) : draw(rng, 0.4, 0.75);
  if (clothing == Clothing::hanging) cut.hanging = draw_hanging_cut(rng, cut.sleeve_end, cut.leg_end, cut.skirt);
  return cut;
}

EaseRange Tailor::range_of(std::size_t vertex, const Cut& cut) const {
  return ease_range(cut.clothing, place_[vertex].part == Part::trunk);
}

Cover Tailor::cover_of(const Place& place, const Cut& cut) const {
  switch (place.part) {
    case Part::trunk:
      return place.along >= cut.hem ? Cover::upper : Cover::lower;
    case Part::neck:
      return place.along <= cut.collar ? Cover::upper : Cover::bare;
    case Part::arm:
      return place.along <= cut.sleeve_end ? Cover::upper : Cover::bare;
    case Part::leg:
      if (place.up >= cut.hem) return Cover::upper;
      return place.along <= (cut.skirt ? 0.3F : cut.leg_end) ? Cover::lower : Cover::bare;
    default:
      return Cover::bare;
  }
}

float Tailor::ease_of(std::size_t vertex, const Cut& cut, Cover cover) const {
  const Place& place = place_[vertex];
  const float least = ease_range(cut.clothing, false).least_mm;
  switch (place.part) {
    case Part::trunk: {
      // Cloth lies on the shoulders and hangs from the chest; clothes under a shirt lie closer.
      const float hanging = smooth((0.95F - place.along) / 0.45F) * (1 - 0.7F * std::max(0.0F, normal_[vertex].y));
      return cover == Cover::upper ? mix(least, cut.trunk_mm, hanging) : least + 1;
    }
    case Part::arm:
      // Short sleeves stand off at their ends, long ones close.
      return mix(least, cut.arm_mm, smooth((place.along + 0.1F) / 0.35F)) *
             mix(1, cut.sleeve_end < 1 ? 1.7F : 0.8F, smooth(1 - (cut.sleeve_end - place.along) / 0.4F));
    case Part::leg:
      return cover == Cover::upper ? cut.trunk_mm : cut.leg_mm;
    default:
      return least;
  }
}

// What the cloth's tube would have to be wide to hang straight: of a limb from its middle joint down, of the trunk
// from the chest.
void Tailor::hang(const Cut& cut, const Outfit& out) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  if (cut.clothing == Clothing::tight) return;
  TrunkHang trunk;
  float knee_sum = 0, elbow_sum = 0, knees = 0, elbows = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Place& p = place_[i];
    if (p.part == Part::trunk || p.part == Part::leg) trunk.add(p.up, p.angle, p.out_mm);
    const bool middle = p.along > 0.85F && p.along < 1.1F;
    if (p.part == Part::leg && middle) knee_sum += p.radius_mm, knees += 1;
    if (p.part == Part::arm && middle) elbow_sum += p.radius_mm, elbows += 1;
  }
  trunk.hang(0.75F, cut.slack_mm);
  const float knee = knees > 0 ? knee_sum / knees : 0, elbow = elbows > 0 ? elbow_sum / elbows : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Place& p = place_[i];
    if (out.cover[i] == Cover::bare) continue;
    float wide = 0;
    if (p.part != Part::arm && out.cover[i] == Cover::upper) {
      // Only what faces outwards hangs away; the radial gap counts as far as the normal points along it.
      const float facing = std::sin(p.angle) * normal_[i].x + std::cos(p.angle) * normal_[i].z;
      wide = std::max(0.0F, facing) * std::max(0.0F, trunk.at(p.up, p.angle) - p.out_mm);
    } else if (p.part == Part::leg && p.along > 0.9F) {
      wide = std::max(0.0F, knee * mix(1, cut.flare, p.along - 1) - p.radius_mm) * smooth((p.along - 0.9F) / 0.2F);
    } else if (p.part == Part::arm && p.along > 0.9F) {
      wide = std::max(0.0F, elbow * 0.95F - p.radius_mm) * smooth((p.along - 0.9F) / 0.2F);
    }
    ease_[i] += wide;
  }
}

void Tailor::clothe(std::span<const Vec3f> rest, const Cut& cut, Rng& rng, Outfit& out) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  // Upright folds on the trunk, rings on the limbs.
  const Folds trunk(rng, 90, 260, {0, 1, 0}, 5), arm(rng, 45, 130, normalized({0.5F, 0.7F, 0}), 0.5F),
      leg(rng, 60, 190, {0, 1, 0}, 0.7F), where(rng, 200, 500, {0, 1, 0}, 1);
  ease_.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const Cover cover = cover_of(place_[i], cut);
    out.cover[i] = cover;
    if (cover == Cover::bare) continue;
    ease_[i] = ease_of(i, cut, cover);
  }
  hang(cut, out);
  for (std::size_t i = 0; i < count; ++i) {
    const EaseRange range = range_of(i, cut);
    if (out.cover[i] != Cover::bare) ease_[i] = std::clamp(ease_[i], range.least_mm, range.most_mm);
  }
  // Tension: the cloth evens out smaller shapes than itself; it touches where the body stands out and spans hollows.
  spare_.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count; ++i) spare_[i] = rest[i] + normal_[i] * ease_[i];
  base_ = ease_;
  for (int pass = 0; pass < kDrapePasses; ++pass) {
    next_.assign(ease_.begin(), ease_.end());
    for (std::size_t i = 0; i < count; ++i) {
      if (out.cover[i] == Cover::bare) continue;
      Vec3f sum = spare_[i];
      float shares = 1;
      for (auto j = neighbour_first_[i]; j < neighbour_first_[i + 1]; ++j) {
        const auto other = static_cast<std::size_t>(neighbour_[static_cast<std::size_t>(j)]);
        if (out.cover[other] != out.cover[i]) continue;
        sum = sum + spare_[other];
        shares += 1;
      }
      const EaseRange range = range_of(i, cut);
      const float even = dot(sum * (1 / shares) - rest[i], normal_[i]);
      const float wanted = mix(even, base_[i], kStiffness);
      next_[i] = std::clamp(wanted, range.least_mm, range.most_mm);
    }
    ease_.swap(next_);
    for (std::size_t i = 0; i < count; ++i) spare_[i] = rest[i] + normal_[i] * ease_[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (out.cover[i] == Cover::bare) continue;
    const Part part = place_[i].part;
    const EaseRange range = range_of(i, cut);
    const Folds& folds = part == Part::arm ? arm : part == Part::leg ? leg : trunk;
    // Cloth that lies on the shoulders does not fold.
    const float hanging = part == Part::trunk ? 1 - std::max(0.0F, normal_[i].y) : 1;
    const float height = cut.fold_mm * hanging * (0.7F + 0.5F * where.at(rest[i])) * folds.at(rest[i]);
    out.rest[i] = rest[i] + normal_[i] * std::clamp(ease_[i] + height, range.least_mm, range.most_mm);
  }
}

// MakeHuman's skirt, cut off at its hem and waving more the lower it hangs.
void Tailor::hang_skirt(std::span<const Vec3f> rest, const Cut& cut, Rng& rng, Outfit& out) const {
  float top = -1e9F, bottom = 1e9F;
  for (const auto& quad : model_.data().skirt_quads) {
    for (const std::int32_t v : quad) {
      top = std::max(top, rest[static_cast<std::size_t>(v)].y);
      bottom = std::min(bottom, rest[static_cast<std::size_t>(v)].y);
    }
  }
  const float hem = mix(hips_y_, bottom, cut.skirt_end);
  const int pleats = 5 + rng.index(7);
  const float phase = draw(rng, 0, 6.28), deep = cut.fold_mm * draw(rng, 2, 4), wide = cut.trunk_mm;
  const auto hang = [&](std::int32_t v) {
    const auto at = static_cast<std::size_t>(v);
    Vec3f p = rest[at];
    const float down = std::clamp((top - p.y) / (top - hem), 0.0F, 1.0F);
    const float angle = std::atan2(p.x, p.z);
    const float push = wide + down * deep * std::sin(static_cast<float>(pleats) * angle + phase);
    p = p + normalized({p.x, 0, p.z}) * push;
    p.y = std::max(p.y, hem);
    out.rest[at] = p;
  };
  for (const auto& quad : model_.data().skirt_quads) {
    const bool hangs = std::any_of(quad.begin(), quad.end(),
                                   [&](std::int32_t v) { return rest[static_cast<std::size_t>(v)].y > hem; });
    if (!hangs) continue;
    for (const std::int32_t v : quad) hang(v);
    out.skirt.push_back({quad[0], quad[1], quad[2]});
    out.skirt.push_back({quad[0], quad[2], quad[3]});
  }
}

void Tailor::dress(std::span<const Vec3f> rest, const body::Skeleton& skeleton, bool woman, Clothing clothing,
                   bool hair, Rng& rng, Outfit& out) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  out.rest.assign(rest.begin(), rest.end());
  out.cover.assign(count, Cover::bare);
  out.skirt.clear();
  out.hanging.reset();
  out.shoe.clear();
  out.shoe_body.clear();
  out.sole_mm = 0;
  locate(rest, skeleton);
  if (clothing != Clothing::none) {
    if (clothing != Clothing::garments) {
      find_normals(rest);
      const Cut cut = draw_cut(clothing, woman, rng);
      clothe(rest, cut, rng, out);
      if (cut.skirt) hang_skirt(rest, cut, rng, out);
      out.hanging = cut.hanging;
    }
    const bool shod = rng.uniform() >= kBarefootShare;
    out.sole_mm = draw(rng, kSoleLeastMm, kSoleMostMm);
    make_shoes(model_, rest, skeleton, draw(rng, 4, 8), out.sole_mm, out.shoe, out.shoe_body);
    if (!shod) {
      out.sole_mm = 0;
      out.shoe.clear();
      out.shoe_body.clear();
    }
  }
  if (hair) grow_hair(rest, skeleton, woman, rng, out);
  float crown = -1e9F;
  for (std::size_t i = 0; i < count; ++i) crown = std::max(crown, rest[i].y);
  out.hair.clear();
  for (const Triangle& t : model_.body_triangles()) {
    Vec3f centre;
    bool all = true;
    for (const std::int32_t v : t) {
      centre = centre + rest[static_cast<std::size_t>(v)];
      all = all && out.cover[static_cast<std::size_t>(v)] == Cover::hair;
    }
    out.hair.push_back(all || in_hair_region(skeleton, crown, centre * (1.0F / 3)) ? 1 : 0);
  }
}

}  // namespace im2fit::lab
