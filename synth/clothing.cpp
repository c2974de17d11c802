// SPDX-License-Identifier: Apache-2.0
#include "synth/clothing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "body/model_data.h"
#include "synth/shoes.h"

namespace im2fit::synth {
namespace {

using body::Segment;

constexpr float kLimbMostMm = 20;  // of loose clothes, off the trunk
constexpr int kNormalPasses = 2;
constexpr int kDrapePasses = 14;
constexpr float kStiffness = 0.06F;  // how much of its own ease the cloth keeps in a pass
constexpr int kHairPasses = 4;
constexpr double kSkirtShare = 0.3;  // of women not in tight clothes
constexpr double kLongHairShareWomen = 0.55;
constexpr double kLongHairShareMen = 0.08;

float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}
float smooth(float x) {  // 0..1, level at both ends
  const float t = std::clamp(x, 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}
float mix(float a, float b, float t) {
  return a + (b - a) * t;
}
float along_bone(Vec3f p, Vec3f head, Vec3f tail) {
  const Vec3f bone = tail - head;
  return dot(p - head, bone) / dot(bone, bone);
}

// Sum of plane waves: folds that run across their wave vectors.
class Folds {
 public:
  // Wavelengths in mm. `stretch`: how much longer they are along `grain` (folds run along it).
  Folds(Rng& rng, double shortest, double longest, Vec3f grain, float stretch) {
    for (Wave& w : waves_) {
      Vec3f k{static_cast<float>(rng.normal()), static_cast<float>(rng.normal()), static_cast<float>(rng.normal())};
      k = k - grain * (dot(k, grain) * (1 - 1 / stretch));
      const auto length = static_cast<float>(rng.uniform(shortest, longest));
      w.k = normalized(k) * (2 * std::numbers::pi_v<float> / length);
      w.phase = draw(rng, 0, 2 * std::numbers::pi);
    }
  }
  // About -1..1.
  float at(Vec3f p) const {
    float sum = 0;
    for (const Wave& w : waves_) sum += std::sin(dot(w.k, p) + w.phase);
    return sum / std::sqrt(static_cast<float>(waves_.size()));
  }

 private:
  struct Wave {
    Vec3f k;
    float phase = 0;
  };
  std::array<Wave, 4> waves_;
};

}  // namespace

EaseRange ease_range(Clothing clothing, bool trunk) {
  switch (clothing) {
    case Clothing::tight:
      return {3, 8};
    case Clothing::normal:
      return {4, 20};
    case Clothing::loose:
      return {6, trunk ? 28.0F : kLimbMostMm};
    default:
      return {};
  }
}

bool in_hair_region(const body::Skeleton& skeleton, float crown_y_mm, Vec3f p) {
  const Vec3f low = skeleton.head[static_cast<std::size_t>(Segment::head)];
  const float height = crown_y_mm - low.y;
  const float up = (p.y - low.y) / height;
  const float back = (low.z - p.z) / height;
  return up > 0.78F || (up > 0.25F && back > -0.12F && up - 0.5F * (0.3F - back) > 0.1F);
}

// What one person wears. Limb ends as Place::along.
struct Tailor::Cut {
  Clothing clothing = Clothing::none;
  float trunk_mm = 0, arm_mm = 0, leg_mm = 0, fold_mm = 0;
  float sleeve_end = 0, leg_end = 0, collar = 0;
  float hem = 0, waist = 0.35F;  // of upper and lower garment, on the trunk
  float flare = 1;               // of the trouser leg at its end
  bool skirt = false;
  float skirt_end = 1;  // share of the way from hips to ankles
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
      cut.fold_mm = draw(rng, 1.8, 3.6);
      break;
    default:
      cut.trunk_mm = draw(rng, 14, 24);
      cut.arm_mm = draw(rng, 10, 16);
      cut.leg_mm = draw(rng, 10, 16);
      cut.fold_mm = draw(rng, 3.5, 6.5);
  }
  const double sleeve = rng.uniform();
  cut.sleeve_end = sleeve < 0.08 ? 0.05F : sleeve < 0.45 ? draw(rng, 0.4, 0.95) : draw(rng, 1.7, 1.98);
  cut.leg_end = rng.uniform() < 0.2 ? draw(rng, 0.5, 1.15) : draw(rng, 1.85, 1.98);
  cut.collar = rng.uniform() < 0.1 ? draw(rng, 0.6, 0.9) : draw(rng, -0.2, 0.3);
  cut.hem = rng.uniform() < 0.3 ? 0.3F : draw(rng, -0.25, 0.15);  // tucked in, or over the trousers
  cut.flare = draw(rng, 0.7, 1.4);
  cut.skirt = woman && clothing != Clothing::tight && rng.uniform() < kSkirtShare;
  cut.skirt_end = rng.uniform() < 0.3 ? draw(rng, 0.85, 0.97) : draw(rng, 0.4, 0.75);
  return cut;
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
  place_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto segment = static_cast<Segment>(skin[i].segment[0]);
    const auto at = static_cast<std::size_t>(segment);
    const float t = along_bone(rest[i], skeleton.head[at], skeleton.tail[at]);
    switch (segment) {
      case Segment::neck:
        place_[i] = {Part::neck, t};
        break;
      case Segment::head:
        place_[i] = {Part::head, t};
        break;
      case Segment::left_upper_arm:
      case Segment::right_upper_arm:
        place_[i] = {Part::arm, std::min(t, 1.0F)};
        break;
      case Segment::left_lower_arm:
      case Segment::right_lower_arm:
        place_[i] = {Part::arm, 1 + std::max(t, 0.0F)};
        break;
      case Segment::left_hand:
      case Segment::right_hand:
        place_[i] = {Part::hand, t};
        break;
      case Segment::left_upper_leg:
      case Segment::right_upper_leg:
        place_[i] = {Part::leg, std::min(t, 1.0F)};
        break;
      case Segment::left_lower_leg:
      case Segment::right_lower_leg:
        place_[i] = {Part::leg, 1 + std::max(t, 0.0F)};
        break;
      case Segment::left_foot:
      case Segment::right_foot:
        place_[i] = {Part::foot, t};
        break;
      default:
        place_[i] = {Part::trunk, (rest[i].y - hips_y_) / (shoulders_y_ - hips_y_)};
    }
  }
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
      // Cloth lies on the shoulders and hangs from the chest; what is under a shirt lies closer.
      const float hanging = smooth((0.95F - place.along) / 0.45F) * (1 - 0.7F * std::max(0.0F, normal_[vertex].y));
      return cover == Cover::upper ? mix(least, cut.trunk_mm, hanging) : least + 1;
    }
    case Part::arm:
      // Short sleeves stand off at their ends, long ones close.
      return mix(least, cut.arm_mm, smooth((place.along + 0.1F) / 0.35F)) *
             mix(1, cut.sleeve_end < 1 ? 1.7F : 0.8F, smooth(1 - (cut.sleeve_end - place.along) / 0.4F));
    case Part::leg:
      return cut.leg_mm * mix(1, cut.flare, place.along / 2);
    default:
      return least;
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
    const EaseRange range = ease_range(cut.clothing, place_[i].part == Part::trunk);
    ease_[i] = std::clamp(ease_of(i, cut, cover), range.least_mm, range.most_mm);
  }
  // Tension: the cloth evens out what is smaller than itself; it touches where the body stands out and spans hollows.
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
      const EaseRange range = ease_range(cut.clothing, place_[i].part == Part::trunk);
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
    const EaseRange range = ease_range(cut.clothing, part == Part::trunk);
    const Folds& folds = part == Part::arm ? arm : part == Part::leg ? leg : trunk;
    // Cloth that lies on the shoulders does not fold.
    const float hanging = part == Part::trunk ? 1 - std::max(0.0F, normal_[i].y) : 1;
    const float height = cut.fold_mm * hanging * (0.7F + 0.5F * where.at(rest[i])) * folds.at(rest[i]);
    out.rest[i] = rest[i] + normal_[i] * std::clamp(ease_[i] + height, range.least_mm, range.most_mm);
  }
}

// Volume away from the head's middle, fading at the hairline; long hair also covers the neck's back and sides.
void Tailor::grow_hair(std::span<const Vec3f> rest, const body::Skeleton& skeleton, bool woman, Rng& rng,
                       Outfit& out) {
  const auto count = static_cast<std::size_t>(model_.body_vertex_count());
  const float volume = static_cast<float>(kHairMostMm) * draw(rng, 0, 1) * draw(rng, 0.4, 1);
  const bool long_hair = rng.uniform() < (woman ? kLongHairShareWomen : kLongHairShareMen);
  const Folds curls(rng, 50, 140, {0, 1, 0}, 2);
  const Vec3f low = skeleton.head[static_cast<std::size_t>(Segment::head)];
  float crown = low.y;
  for (std::size_t i = 0; i < count; ++i) crown = std::max(crown, rest[i].y);
  const Vec3f middle{low.x, mix(low.y, crown, 0.55F), low.z};
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
  out.shoe.clear();
  out.shoe_body.clear();
  out.sole_mm = 0;
  locate(rest, skeleton);
  if (clothing != Clothing::none) {
    find_normals(rest);
    const Cut cut = draw_cut(clothing, woman, rng);
    clothe(rest, cut, rng, out);
    if (cut.skirt) hang_skirt(rest, cut, rng, out);
    out.sole_mm = draw(rng, kSoleLeastMm, kSoleMostMm);
    make_shoes(model_, rest, skeleton, draw(rng, 4, 8), out.sole_mm, out.shoe, out.shoe_body);
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

}  // namespace im2fit::synth
