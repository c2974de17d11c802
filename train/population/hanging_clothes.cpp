// SPDX-License-Identifier: Apache-2.0
#include "train/population/hanging_clothes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "body/model_data.h"
#include "train/common/draw.h"

namespace im2fit::lab {
namespace {

using body::Segment;

constexpr int kSectors = 40;
constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr float kShirtTop = 0.15F;  // above, a shirt lies as clothing.h has it (Place::up)
constexpr float kSeatTop = 0.1F;    // that of trousers at the band
constexpr float kLegTop = 0.2F, kSleeveTop = 0.15F;
// Half the width of the fork of trousers, as the sine of the direction: beside it are the legs.
constexpr float kFork = 0.5F;
constexpr float kUnderShirtMm = 4;  // trousers under the shirt
constexpr float kRestMost = 0.9F;   // of its room, that cloth lies to one side

float smooth(float x) {
  const float t = std::clamp(x, 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}
Vec3f head(const body::PosedSkeleton& bones, Segment s) {
  return bones.head[static_cast<std::size_t>(s)];
}

struct Fallen {
  float radius_mm = 0, below_mm = 0;
};

// Rings one below the other.
class Tube {
 public:
  Tube(DrapedCloth& out, float lowest) : out_(out), lowest_(lowest) {}
  // `place(angle)`: 0 in front, left positive. `up`: along the tube.
  template <class Place>
  void ring(Vec3f centre, Vec3f up, const Place& place) {
    const Vec3f side = normalized(cross(up, {0, 0, 1})), front = cross(side, up);
    const auto first = static_cast<std::int32_t>(out_.vertices.size());
    for (int s = 0; s < kSectors; ++s) {
      const float angle = kTurn * static_cast<float>(s) / kSectors;
      const Fallen at = place(angle);
      Vec3f p = centre + side * (at.radius_mm * std::sin(angle)) + front * (at.radius_mm * std::cos(angle)) -
                up * at.below_mm;
      p.y = std::max(p.y, lowest_);
      out_.vertices.push_back(p);
      if (!begun_) continue;
      const std::int32_t a = first + s - kSectors, b = first + (s + 1) % kSectors - kSectors, c = a + kSectors,
                         d = b + kSectors;
      out_.triangles.push_back({a, c, d});
      out_.triangles.push_back({a, d, b});
    }
    begun_ = true;
  }

 private:
  DrapedCloth& out_;
  float lowest_;
  bool begun_ = false;
};

// A limb as worn, by middle and mean radius at three places, straight between them: cloth does not follow the rest.
class Limb {
 public:
  struct Range {
    float from = 0, to = 0;
  };
  using Ranges = std::array<Range, 3>;  // along: 0 at the root, 1 at the middle joint, 2 at the end
  Limb(const body::BodyModel& model, std::span<const Vec3f> worn, const std::array<Vec3f, 3>& joints, Segment upper,
       Segment lower, const Ranges& ranges) {
    const auto skin = model.data().skin;
    const auto each_within = [&](Range range, const auto& use) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i) {
        const auto segment = static_cast<Segment>(skin[i].segment[0]);
        if (segment != upper && segment != lower) continue;
        const std::size_t half = segment == upper ? 0 : 1;
        const Vec3f bone = joints[half + 1] - joints[half];
        const float along = dot(worn[i] - joints[half], bone) / dot(bone, bone) + static_cast<float>(half);
        if (along >= range.from && along < range.to) use(worn[i], along, normalized(bone));
      }
    };
    for (std::size_t k = 0; k < places_.size(); ++k) {
      Place& place = places_[k];
      float count = 0, along_sum = 0;
      Vec3f sum;
      each_within(ranges[k], [&](Vec3f p, float along, Vec3f) { sum = sum + p, along_sum += along, count += 1; });
      if (count <= 0) continue;
      place.middle = sum * (1 / count);
      place.along = along_sum / count;
      each_within(ranges[k], [&](Vec3f p, float, Vec3f bone) {
        const Vec3f out = p - place.middle;
        place.radius_mm += norm(out - bone * dot(out, bone)) / count;
      });
    }
  }
  Vec3f at(float along) const {
    const auto [k, share] = between(along);
    return places_[k].middle + (places_[k + 1].middle - places_[k].middle) * share;
  }
  float radius(float along) const {
    const auto [k, share] = between(along);
    const float t = std::clamp(share, 0.0F, 1.0F);
    return places_[k].radius_mm * (1 - t) + places_[k + 1].radius_mm * t;
  }
  const auto& places() const { return places_; }
  Vec3f up() const { return normalized(places_.front().middle - places_.back().middle); }

 private:
  struct Place {
    Vec3f middle;
    float along = 0, radius_mm = 0;
  };
  std::pair<std::size_t, float> between(float along) const {
    const std::size_t k = along < places_[1].along ? 0 : 1;
    const float length = std::max(places_[k + 1].along - places_[k].along, 0.01F);
    return {k, (along - places_[k].along) / length};
  }
  std::array<Place, 3> places_{};
};

// A limb's round tube. Cloth with room about the limb lies on it at one side.
void ring_about(Tube& tube, const Limb& limb, float along, float radius, HangingCut::Rest rest, float left) {
  const float room = std::max(0.0F, radius - limb.radius(along)) * kRestMost;
  const Vec3f off{left * rest.outwards * room, 0, rest.forwards * room};
  tube.ring(limb.at(along) + off, limb.up(), [&](float) { return Fallen{radius, 0}; });
}

void hang_leg(const HangingCut::Trousers& cut, const Limb& leg, float left, Tube tube) {
  constexpr int kRings = 24;
  const float thigh = leg.places()[0].radius_mm;
  const float hem = cut.hem * (cut.end > 1.2F ? leg.places()[1].radius_mm : thigh);
  for (int i = 0; i <= kRings; ++i) {
    const float share = static_cast<float>(i) / kRings, along = kLegTop + (cut.end - kLegTop) * share;
    const float top = thigh + cut.thigh_mm * smooth(share / 0.2F);
    ring_about(tube, leg, along, hem + (top - hem) * std::pow(1 - share, cut.narrowing), cut.rest, left);
  }
}

void hang_sleeve(const HangingCut::Sleeve& cut, const Limb& arm, float left, Tube tube) {
  constexpr int kRings = 12;
  for (int i = 0; i <= kRings; ++i) {
    const float share = static_cast<float>(i) / kRings, along = kSleeveTop + (cut.end - kSleeveTop) * share;
    // A short one stands off at its end; a long one hangs below the upper arm and meets the cuff's half closely.
    const float room = cut.is_short ? smooth(share + 0.1F) : 4 * share * (1 - share);
    ring_about(tube, arm, along, arm.places()[1].radius_mm + cut.room_mm * room, cut.rest, left);
  }
}

// What goes round the trunk and both thighs.
class Trunk {
 public:
  Trunk(const body::BodyModel& model, std::span<const Vec3f> worn, const body::PosedSkeleton& bones) {
    const Vec3f hips = (head(bones, Segment::left_upper_leg) + head(bones, Segment::right_upper_leg)) * 0.5F;
    const Vec3f shoulders = (head(bones, Segment::left_upper_arm) + head(bones, Segment::right_upper_arm)) * 0.5F;
    axis_ = (hips + shoulders) * 0.5F;
    hips_y_ = hips.y;
    height_ = shoulders.y - hips.y;
    crotch_y_ = hips.y;
    const auto skin = model.data().skin;
    for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i) {
      const auto segment = static_cast<Segment>(skin[i].segment[0]);
      const bool trunk = segment == Segment::pelvis || segment == Segment::abdomen || segment == Segment::chest;
      if (!trunk && segment != Segment::left_upper_leg && segment != Segment::right_upper_leg) continue;
      const Vec3f out = worn[i] - axis_;
      shape_.add((worn[i].y - hips_y_) / height_, std::atan2(out.x, out.z), std::hypot(out.x, out.z));
      if (segment == Segment::pelvis) crotch_y_ = std::min(crotch_y_, worn[i].y);
    }
  }
  float crotch() const { return (crotch_y_ - hips_y_) / height_; }
  float share_of(float mm) const { return mm / height_; }
  // From `top` down to `end`, `reach(angle)` of the way; `more(share, angle)` farther out than straight.
  template <class Reach, class More>
  void hang(float top, float end, float slack_mm, const Reach& reach, const More& more, Tube tube) const {
    TrunkHang cloth = shape_;
    cloth.hang(top, slack_mm);
    const int rings = std::max(2, static_cast<int>((top - end) / 0.03F));
    for (int i = 0; i <= rings; ++i) {
      const float share = static_cast<float>(i) / static_cast<float>(rings), down = (end - top) * share;
      tube.ring({axis_.x, hips_y_ + top * height_, axis_.z}, {0, 1, 0}, [&](float angle) {
        const float fallen = down * reach(angle);
        return Fallen{cloth.at(top + fallen, angle > kTurn / 2 ? angle - kTurn : angle) + more(share, angle),
                      -fallen * height_};
      });
    }
  }

 private:
  TrunkHang shape_;
  Vec3f axis_;
  float hips_y_ = 0, height_ = 1, crotch_y_ = 0;
};

}  // namespace

HangingCut draw_hanging_cut(Rng& rng, float sleeve_end, float leg_end, bool skirt) {
  const auto rest = [&] { return HangingCut::Rest{draw(rng, -1, 1), draw(rng, -1, 1)}; };
  HangingCut cut;
  cut.shirt.end = draw(rng, -0.35, 0.05);  // from the band of trousers to below the crotch
  cut.shirt.flare_mm = draw(rng, 0, 15);
  cut.shirt.slack_mm = draw(rng, 0, 3);
  cut.shirt.fold_mm = draw(rng, 0, 9);
  cut.shirt.folds = 3 + rng.index(8);
  cut.shirt.phase = draw(rng, 0, 6.28);
  if (!skirt) {
    HangingCut::Trousers& t = cut.trousers.emplace(HangingCut::Trousers{});
    // Crotches of fitted trousers lie 10 to 30 mm below the body's, of wide ones and jogging trousers 100: judgement.
    t.drop_mm = draw(rng, 5, 100);
    const bool shorts = leg_end < 1.2F;
    t.end = leg_end + (shorts ? 0 : draw(rng, -0.05, 0.12));
    t.thigh_mm = draw(rng, 0, 8);
    // Shops sell legs 12 to 22 inches round the hem, 300 to 560 mm; calves are about 370 mm.
    t.hem = shorts ? draw(rng, 0.85, 1.25) : draw(rng, 0.75, 1.4);
    t.narrowing = draw(rng, 1.2, 4);
    t.rest = rest();
  }
  if (sleeve_end > 0.3F) {
    HangingCut::Sleeve& s = cut.sleeve.emplace(HangingCut::Sleeve{});
    s.is_short = sleeve_end < 1;
    s.end = std::min(sleeve_end, 1.0F);
    // 30 to 250 mm of girth, as T-shirts are sold from fitted to oversized; judgement.
    s.room_mm = s.is_short ? draw(rng, 5, 40) : draw(rng, 0, 16);
    s.rest = rest();
  }
  return cut;
}

DrapedCloth hang_clothes(const body::BodyModel& model, const HangingCut& cut, std::span<const Vec3f> worn,
                         const body::PosedSkeleton& bones) {
  float lowest = 1e9F;
  for (const Vec3f& p : worn) lowest = std::min(lowest, p.y);
  using S = Segment;
  constexpr Limb::Ranges kLeg{{{0.25F, 0.6F}, {1.2F, 1.45F}, {1.7F, 1.9F}}};
  constexpr Limb::Ranges kArm{{{0.2F, 0.4F}, {0.4F, 0.65F}, {0.65F, 0.9F}}};
  const auto limb = [&](S upper, S lower, S end, const Limb::Ranges& ranges) {
    return Limb(model, worn, {head(bones, upper), head(bones, lower), head(bones, end)}, upper, lower, ranges);
  };
  DrapedCloth out;
  const Trunk trunk(model, worn, bones);
  trunk.hang(
      kShirtTop, cut.shirt.end, cut.shirt.slack_mm, [](float) { return 1.0F; },
      [&](float share, float angle) {
        const float wave = std::sin(static_cast<float>(cut.shirt.folds) * angle + cut.shirt.phase);
        return smooth(share) * (cut.shirt.flare_mm + cut.shirt.fold_mm * wave);
      },
      Tube(out, lowest));
  if (cut.trousers) {
    const float end = trunk.crotch() - trunk.share_of(cut.trousers->drop_mm);
    trunk.hang(
        kSeatTop, end, 1, [](float angle) { return smooth((kFork - std::abs(std::sin(angle))) / kFork + 0.5F); },
        [&](float, float) { return -kUnderShirtMm; }, Tube(out, lowest));
    hang_leg(*cut.trousers, limb(S::left_upper_leg, S::left_lower_leg, S::left_foot, kLeg), 1, Tube(out, lowest));
    hang_leg(*cut.trousers, limb(S::right_upper_leg, S::right_lower_leg, S::right_foot, kLeg), -1, Tube(out, lowest));
  }
  if (cut.sleeve) {
    hang_sleeve(*cut.sleeve, limb(S::left_upper_arm, S::left_lower_arm, S::left_hand, kArm), 1, Tube(out, lowest));
    hang_sleeve(*cut.sleeve, limb(S::right_upper_arm, S::right_lower_arm, S::right_hand, kArm), -1,
                Tube(out, lowest));
  }
  return out;
}

}  // namespace im2fit::lab
