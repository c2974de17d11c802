// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/other_tape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <utility>

#include "body/measure.h"
#include "body/model_data.h"

namespace im2fit::lab {
namespace {

using body::Landmark;
using body::Segment;

constexpr float kWaistShare = 0.145F;   // of the way from the navel to the chest, of men: ANSUR II
constexpr float kShoulderShare = 0.2F;  // of the upper arm, below the shoulder joint
constexpr float kNeckReachMm = 160;     // sections that reach shoulders or chin within it are longer than the neck's
constexpr int kNeckSteps = 30;
// The upper arm is searched in so many steps between these shares of the way from shoulder to elbow, the calf between
// these of the way from knee to ankle; the thigh is taken in the middle. As in data/tape.
constexpr int kLimbSteps = 12;
constexpr float kUpperArmFrom = 0.4F, kUpperArmTo = 0.7F, kCalfFrom = 0.1F, kCalfTo = 0.6F;
constexpr float kNeckFrom = 0.1F, kNeckTo = 0.9F;  // of the way from its root to the skull

struct Flat {
  double x = 0, y = 0;
};

double cross2(Flat o, Flat a, Flat b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Length of the points' convex hull. Sorted along x, its lower and its upper side are walked apart: a point that the
// next one leaves on the wrong side is taken back.
double wrapped_length(std::vector<Flat> points) {
  std::sort(points.begin(), points.end(), [](Flat a, Flat b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  double length = 0;
  for (const double side : {1.0, -1.0}) {
    std::vector<Flat> walk;
    for (const Flat p : points) {
      while (walk.size() >= 2 && side * cross2(walk[walk.size() - 2], walk.back(), p) <= 0) walk.pop_back();
      walk.push_back(p);
    }
    for (std::size_t i = 1; i < walk.size(); ++i)
      length += std::hypot(walk[i].x - walk[i - 1].x, walk[i].y - walk[i - 1].y);
  }
  return length;
}

// An actor who stands to be measured.
class Standing {
 public:
  Standing(const DimensionSurface& parts, std::span<const Vec3f> posed, const body::PosedSkeleton& bones)
      : parts_(parts), posed_(posed), bones_(bones) {
    for (const std::uint8_t arm : parts.triangle_is_arm) trunk_.push_back(arm == 0 ? 1 : 0);
  }

  double stature() const {
    const auto [low, high] =
        std::minmax_element(posed_.begin(), posed_.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; });
    return static_cast<double>(high->y) - static_cast<double>(low->y);
  }

  float chest_y() const { return (landmark(Landmark::left_nipple).y + landmark(Landmark::right_nipple).y) / 2; }
  float waist_y() const {
    const float navel = landmark(Landmark::navel).y;
    return navel + kWaistShare * (chest_y() - navel);
  }
  float hip_y() const {
    const float low = landmark(Landmark::crotch).y, high = landmark(Landmark::navel).y;
    Vec3f rearmost{0, (low + high) / 2, std::numeric_limits<float>::max()};
    for (std::size_t v = 0; v < posed_.size(); ++v) {
      const Segment s = parts_.segment[v];
      const bool seat = s == Segment::pelvis || s == Segment::left_upper_leg || s == Segment::right_upper_leg;
      const Vec3f p = posed_[v];
      if (seat && p.y > low && p.y < high && p.z < rearmost.z) rearmost = p;
    }
    return rearmost.y;
  }
  float shoulder_y() const {
    float y = 0;
    for (const Segment s : {Segment::left_upper_arm, Segment::right_upper_arm})
      y += (head(s).y + kShoulderShare * (tail(s).y - head(s).y)) / 2;
    return y;
  }

  // Without the arms.
  double trunk_round(float y) const { return tape_round(posed_, parts_.triangles, trunk_, {0, y, 0}, {0, 1, 0}); }
  double all_round(float y) const { return tape_round(posed_, parts_.triangles, {}, {0, y, 0}, {0, 1, 0}); }

  double neck_round() const {
    const Vec3f root = head(Segment::neck), axis = head(Segment::head) - root;
    const Vec3f along = normalized(axis);
    std::vector<std::uint8_t> near;
    for (const auto& t : parts_.triangles) {
      const auto reached = [&](std::int32_t v) {
        const Vec3f p = posed_[static_cast<std::size_t>(v)] - root;
        return norm(p - along * dot(p, along)) < kNeckReachMm;
      };
      near.push_back(reached(t[0]) && reached(t[1]) && reached(t[2]) ? 1 : 0);
    }
    double least = std::numeric_limits<double>::max();
    for (int i = 0; i <= kNeckSteps; ++i) {
      const float share = kNeckFrom + (kNeckTo - kNeckFrom) * static_cast<float>(i) / kNeckSteps;
      const double mm = tape_round(posed_, parts_.triangles, near, root + axis * share, axis);
      if (mm > 0) least = std::min(least, mm);
    }
    return least;
  }

  // Round one limb, square to the line between the heads of two bones: the largest between two shares of the way. Of
  // the triangles whose corners are moved most by one of `parts`.
  double limb_round(std::initializer_list<Segment> parts, Segment from, Segment to, float low, float high) const {
    const auto belongs = [&](std::int32_t v) {
      return std::find(parts.begin(), parts.end(), parts_.segment[static_cast<std::size_t>(v)]) != parts.end();
    };
    std::vector<std::uint8_t> used;
    for (const auto& t : parts_.triangles) used.push_back(belongs(t[0]) && belongs(t[1]) && belongs(t[2]) ? 1 : 0);
    const Vec3f root = head(from), axis = head(to) - root;
    double most = 0;
    for (int i = 0; i <= kLimbSteps; ++i) {
      const float share = low + (high - low) * static_cast<float>(i) / kLimbSteps;
      most = std::max(most, tape_round(posed_, parts_.triangles, used, root + axis * share, axis));
    }
    return most > 0 ? most : std::numeric_limits<double>::quiet_NaN();
  }

  double shoulder_breadth() const {
    return static_cast<double>(norm(landmark(Landmark::left_acromion) - landmark(Landmark::right_acromion)));
  }
  // From the acromion over elbow to wrist, mean of both.
  double sleeve() const {
    return (chain(landmark(Landmark::left_acromion), head(Segment::left_lower_arm), head(Segment::left_hand)) +
            chain(landmark(Landmark::right_acromion), head(Segment::right_lower_arm), head(Segment::right_hand))) /
           2;
  }
  // Hip, knee, ankle: the rig's joints.
  double leg() const {
    return (chain(head(Segment::left_upper_leg), head(Segment::left_lower_leg), head(Segment::left_foot)) +
            chain(head(Segment::right_upper_leg), head(Segment::right_lower_leg), head(Segment::right_foot))) /
           2;
  }

 private:
  Vec3f landmark(Landmark l) const {
    return posed_[static_cast<std::size_t>(parts_.landmarks[static_cast<std::size_t>(l)])];
  }
  Vec3f head(Segment s) const { return bones_.head[static_cast<std::size_t>(s)]; }
  Vec3f tail(Segment s) const { return bones_.tail[static_cast<std::size_t>(s)]; }
  static double chain(Vec3f a, Vec3f b, Vec3f c) {
    return static_cast<double>(norm(b - a)) + static_cast<double>(norm(c - b));
  }

  const DimensionSurface& parts_;
  std::span<const Vec3f> posed_;
  const body::PosedSkeleton& bones_;
  std::vector<std::uint8_t> trunk_;
};

}  // namespace

double tape_round(std::span<const Vec3f> vertices, std::span<const std::array<std::int32_t, 3>> triangles,
                  std::span<const std::uint8_t> used, Vec3f origin, Vec3f normal) {
  const Vec3f n = normalized(normal);
  const Vec3f e = normalized(cross(n, std::fabs(n.x) < 0.5F ? Vec3f{1, 0, 0} : Vec3f{0, 0, 1}));
  const Vec3f f = cross(n, e);
  std::vector<Flat> points;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!used.empty() && used[i] == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3f a = vertices[static_cast<std::size_t>(triangles[i][c])] - origin;
      const Vec3f b = vertices[static_cast<std::size_t>(triangles[i][(c + 1) % 3])] - origin;
      const auto above = static_cast<double>(dot(a, n)), beyond = static_cast<double>(dot(b, n));
      if ((above > 0) == (beyond > 0)) continue;
      const double t = above / (above - beyond);
      points.push_back({(1 - t) * static_cast<double>(dot(a, e)) + t * static_cast<double>(dot(b, e)),
                        (1 - t) * static_cast<double>(dot(a, f)) + t * static_cast<double>(dot(b, f))});
    }
  }
  return wrapped_length(std::move(points));
}

double volume_within(std::span<const Vec3f> vertices, std::span<const std::array<std::int32_t, 3>> triangles) {
  double six_mm3 = 0;
  for (const auto& t : triangles) {
    const auto at = [&](std::size_t i) { return vertices[static_cast<std::size_t>(t[i])]; };
    six_mm3 += static_cast<double>(dot(at(0), cross(at(1), at(2))));
  }
  return six_mm3 / 6e6;
}

float measuring_spread_deg(double litres_per_m2) {
  return static_cast<float>(std::clamp(10 + (litres_per_m2 - 20) * (12.0 / 22), 10.0, 22.0));
}

namespace {

struct Stood {
  std::vector<Vec3f> posed;
  body::PosedSkeleton bones;
  double litres = 0;
};
Stood stand(const Actor& actor, const DimensionSurface& parts) {
  Stood out;
  out.litres = volume_within(actor.rest, parts.triangles);
  const auto [low, high] =
      std::minmax_element(actor.rest.begin(), actor.rest.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; });
  const double tall_m = (static_cast<double>(high->y) - static_cast<double>(low->y)) / 1000;
  const body::Pose pose = body::relaxed_pose(actor.skeleton, measuring_spread_deg(out.litres / (tall_m * tall_m)));
  out.posed.resize(actor.rest.size());
  skin(actor, pose, out.posed);
  out.bones = body::pose_skeleton(actor.skeleton, pose);
  return out;
}

}  // namespace

ActorLevels levels_of(const Actor& actor, const DimensionSurface& parts) {
  const Stood stood = stand(actor, parts);
  const Standing standing(parts, stood.posed, stood.bones);
  const auto lowest =
      std::min_element(stood.posed.begin(), stood.posed.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; });
  return {standing.chest_y() - lowest->y, standing.waist_y() - lowest->y, standing.hip_y() - lowest->y};
}

LimbGirths limb_girths_of(const Actor& actor, const DimensionSurface& parts) {
  using S = Segment;
  const Stood stood = stand(actor, parts);
  const Standing standing(parts, stood.posed, stood.bones);
  const auto thigh = [&](S upper, S lower) {
    return standing.limb_round({S::pelvis, upper, lower}, upper, lower, 0.5F, 0.5F);
  };
  const auto calf = [&](S upper, S lower, S foot) {
    return standing.limb_round({upper, lower, foot}, lower, foot, kCalfFrom, kCalfTo);
  };
  const auto arm = [&](S upper, S lower) {
    return standing.limb_round({upper, lower}, upper, lower, kUpperArmFrom, kUpperArmTo);
  };
  return {
      (thigh(S::left_upper_leg, S::left_lower_leg) + thigh(S::right_upper_leg, S::right_lower_leg)) / 2,
      (calf(S::left_upper_leg, S::left_lower_leg, S::left_foot) +
       calf(S::right_upper_leg, S::right_lower_leg, S::right_foot)) /
          2,
      (arm(S::left_upper_arm, S::left_lower_arm) + arm(S::right_upper_arm, S::right_lower_arm)) / 2,
  };
}

MeasurementValues measure_actor(const Actor& actor, const DimensionSurface& parts) {
  MeasurementValues out;
  out.fill(std::numeric_limits<float>::quiet_NaN());
  const auto set = [&](Measurement m, double value) { out[measurement_index(m)] = static_cast<float>(value); };
  const Stood stood = stand(actor, parts);
  const Standing standing(parts, stood.posed, stood.bones);
  set(Measurement::stature, standing.stature());
  set(Measurement::sleeve_length, standing.sleeve());
  set(Measurement::leg_length, standing.leg());
  set(Measurement::shoulder_breadth, standing.shoulder_breadth());
  set(Measurement::neck_girth, standing.neck_round());
  set(Measurement::shoulder_girth, standing.all_round(standing.shoulder_y()));
  set(Measurement::chest_girth, standing.trunk_round(standing.chest_y()));
  set(Measurement::waist_girth, standing.trunk_round(standing.waist_y()));
  set(Measurement::hip_girth, standing.trunk_round(standing.hip_y()));
  set(Measurement::weight, stood.litres * 1e-3 * body::density_kg_m3(standing.stature(), stood.litres));
  return out;
}

}  // namespace im2fit::lab
