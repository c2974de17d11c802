// SPDX-License-Identifier: Apache-2.0
#include "train/population/proportions.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "body/measure.h"
#include "body/model_data.h"
#include "body/section.h"
#include "body/skeleton.h"

namespace im2fit::body {
namespace {

struct Regression {
  // At 1700 mm, 75 kg, 30 years; by log stature, log weight and ten years.
  std::array<std::array<double, 4>, kDimensionCount> slopes;
  std::array<double, kDimensionCount*(kDimensionCount + 1) / 2> factor;
};
constexpr std::array<Regression, 2> kRegressions = {{
#include "train/population/proportions_regression.inc"
}};

constexpr double kAgeMost = 60;  // years: ANSUR II has no older people

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
float limited(float v, float low, float high) {
  return v > low ? (v < high ? v : high) : low;
}

// ANSUR II measures flexed arms. Relaxed ones, of which no survey says as much, are taken to be this much of them.
constexpr double kRelaxedBiceps = 0.93, kRelaxedForearm = 0.96;

// Where limbs are measured.
constexpr float kThighBelowCrotchMm = 20;  // the gluteal furrow is not on meshes
constexpr float kCalfShare = 0.33F;        // of the way from the knee to the ankle
constexpr float kBicepsShare = 0.5F;       // of the upper arm
constexpr float kForearmShare = 0.25F;
constexpr float kSkullShare = 0.034F;   // above the skull's base, of the stature: over the ears
constexpr float kDeltoidShare = 0.25F;  // the broadest of the shoulders lies above this share of the upper arm

struct Extents {
  float low_x = 1e9F, high_x = -1e9F, low_z = 1e9F, high_z = -1e9F;
  explicit Extents(std::span<const Vec3f> points) {
    for (const Vec3f& p : points) {
      low_x = std::min(low_x, p.x);
      high_x = std::max(high_x, p.x);
      low_z = std::min(low_z, p.z);
      high_z = std::max(high_z, p.z);
    }
  }
  double breadth() const { return high_x > low_x ? static_cast<double>(high_x) - low_x : 0; }
  double depth() const { return high_z > low_z ? static_cast<double>(high_z) - low_z : 0; }
};

using Hull = std::vector<Vec3f>;

// Level sections of a mesh: the trunk's at three heights, and the legs'.
struct LevelSections {
  Hull hip, waist, chest, thigh, calf;

  LevelSections(const BodyModel& model, std::span<const Vec3f> mesh, const WarpLandmarks& marks, float calf_y) {
    std::vector<float> heights;
    heights_along(mesh.first(static_cast<std::size_t>(model.body_vertex_count())), {0, 1, 0}, heights);
    std::array<Level, 5> levels;
    const float y[] = {marks.buttock, marks.navel, marks.nipple, marks.crotch - kThighBelowCrotchMm, calf_y};
    for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = {y[i], true, {}};
    section_levels(model.body_quads(), model.data().triangle_is_arm, mesh, heights, levels);
    for (const std::size_t leg : {std::size_t{3}, std::size_t{4}})
      std::erase_if(levels[leg].points, [](Vec3f p) { return p.x <= 0; });
    Hull* const out[] = {&hip, &waist, &chest, &thigh, &calf};
    for (std::size_t i = 0; i < levels.size(); ++i) *out[i] = convex_hull(levels[i].points, level_plane(y[i]));
  }
};

// Round a limb at a share of a bone, square to it.
double limb_girth_mm(const BodyModel& model, std::span<const Vec3f> mesh, const Skeleton& bones, Segment segment,
                     float share) {
  const Vec3f from = bones.head[at(segment)], bone = bones.tail[at(segment)] - from;
  const Vec3f middle = from + bone * share, normal = normalized(bone);
  std::vector<float> heights;
  heights_along(mesh.first(static_cast<std::size_t>(model.body_vertex_count())), normal, heights);
  TriangleStack limb;
  const BodyModel::Data& d = model.data();
  for (const auto& t : d.triangles)
    if (d.skin[static_cast<std::size_t>(t[0])].segment[0] == static_cast<std::uint8_t>(segment)) limb.add(t, heights);
  std::vector<Vec3f> points;
  limb.cut(mesh, heights, dot(middle, normal), points);
  return perimeter_mm(convex_hull(points, plane_through(middle, normal)));
}

float calf_height(const Skeleton& bones) {
  const float knee = bones.head[at(Segment::left_lower_leg)].y, ankle = bones.tail[at(Segment::left_lower_leg)].y;
  return knee + kCalfShare * (ankle - knee);
}

double breadth_of_shoulders(const BodyModel& model, std::span<const Vec3f> relaxed, const PosedSkeleton& bones) {
  const float top = bones.head[at(Segment::left_upper_arm)].y, elbow = bones.tail[at(Segment::left_upper_arm)].y;
  const float low = top + kDeltoidShare * (elbow - top);
  float left = 0, right = 0;
  for (const Vec3f& p : relaxed.first(static_cast<std::size_t>(model.body_vertex_count()))) {
    if (p.y < low) continue;
    left = std::max(left, p.x);
    right = std::min(right, p.x);
  }
  return static_cast<double>(left) - right;
}

// Factors of breadth and depth until the hull of the section has the girth, and a ratio or a depth.
struct SectionGoal {
  double girth = 0;
  double breadth_to_depth = 0;  // 0: `depth` counts
  double depth = 0;
};
constexpr float kFactorMax = 0.4F;
constexpr int kSectionSteps = 8;

SectionWarp reach(const Hull& hull, const SectionFrame& frame, const SectionGoal& goal,
                  const SectionVariety& variety) {
  SectionWarp warp;
  if (hull.size() < 3) return warp;
  warp.square = variety.square;
  float breadth = 1, depth = 1;
  Hull moved(hull.size());
  for (int step = 0; step < kSectionSteps; ++step) {
    warp.breadth = limited(breadth - 1, -kFactorMax, kFactorMax);
    warp.front = limited(depth - 1 + variety.front_more, -kFactorMax, kFactorMax);
    warp.back = limited(depth - 1 - variety.front_more, -kFactorMax, kFactorMax);
    for (std::size_t i = 0; i < hull.size(); ++i) moved[i] = hull[i] + section_move(warp, frame, hull[i]);
    // Corners that move may leave the hull: its girth is that of the remaining hull.
    const Hull around = convex_hull(moved, level_plane(hull[0].y));
    const Extents now(around);
    const auto girth = static_cast<float>(goal.girth / std::max(perimeter_mm(around), 1.0));
    if (goal.breadth_to_depth > 0) {
      const auto ratio =
          static_cast<float>(goal.breadth_to_depth * std::max(now.depth(), 1.0) / std::max(now.breadth(), 1.0));
      const float half = 0.5F * (ratio - 1);
      breadth *= girth * (1 + half);
      depth *= girth * (1 - half);
    } else {
      depth *= static_cast<float>(goal.depth / std::max(now.depth(), 1.0));
      breadth *= 1 + (girth - 1) * 1.4F;  // a little over half of the girth goes with the breadth
    }
    breadth = limited(breadth, 1 - kFactorMax, 1 + kFactorMax);
    depth = limited(depth, 1 - kFactorMax, 1 + kFactorMax);
  }
  return warp;
}

constexpr float kLimbFactorMax = 0.35F, kDeltoidFactorMax = 0.5F, kLengthFactorMax = 0.25F, kRiseMax = 0.05F;
constexpr float kGapLeast = 0.4F;  // of the distance between two landmarks

// New heights of the landmarks. Each keeps at least a share of its distance to the landmark below.
void set_rises(const WarpLandmarks& marks, const Dimensions& wanted, float head_rise, Warp& warp) {
  const float tall = marks.crown - marks.floor;
  // Not the buttocks': where they are fullest is ill defined on people and on meshes.
  const float own[] = {marks.knee, marks.crotch, marks.navel, marks.nipple, marks.shoulder, marks.neck};
  const Dimension to[] = {Dimension::knee_height,  Dimension::crotch_height,   Dimension::waist_height,
                          Dimension::chest_height, Dimension::acromial_height, Dimension::cervicale_height};
  float below_own = marks.floor, below_new = marks.floor;
  for (std::size_t i = 0; i < std::size(own); ++i) {
    const float rise =
        limited(static_cast<float>(wanted[to[i]]) + marks.floor - own[i], -kRiseMax * tall, kRiseMax * tall);
    const float placed = std::max(own[i] + rise, below_new + kGapLeast * (own[i] - below_own));
    warp.values[static_cast<std::size_t>(WarpValue::knee_rise) + i] = (placed - own[i]) / tall;
    below_own = own[i];
    below_new = placed;
  }
  warp[WarpValue::head_rise] = 0.6F * warp[WarpValue::neck_rise] + head_rise;
}

void set_section(Warp& warp, WarpValue first, const SectionWarp& section) {
  const float values[] = {section.breadth, section.front, section.back, section.square};
  std::copy(std::begin(values), std::end(values), warp.values.begin() + static_cast<std::ptrdiff_t>(first));
}

// Coarse, so that a last bit of a logarithm changes nothing.
float gridded(float v) {
  return std::round(v * 65536) / 65536;
}

std::vector<Vec3f> relax(const BodyModel& model, std::span<const Vec3f> rest, const Skeleton& bones,
                         PosedSkeleton& posed_bones) {
  const Pose pose = relaxed_pose(bones, relaxed_spread_deg(model, rest));
  posed_bones = pose_skeleton(bones, pose);
  std::vector<Vec3f> posed(rest.size());
  skin(model, rest, bones, pose, posed);
  return posed;
}

}  // namespace

Dimensions likely_dimensions(bool woman, double stature_mm, double weight_kg, double age_years,
                             const std::array<double, kDimensionCount>& z) {
  const Regression& regression = kRegressions[woman ? 0 : 1];
  const double given[] = {1, std::log(stature_mm / 1700), std::log(weight_kg / 75),
                          (std::min(age_years, kAgeMost) - 30) / 10};
  Dimensions out;
  std::size_t next = 0;
  for (std::size_t d = 0; d < kDimensionCount; ++d) {
    double logarithm = 0;
    for (std::size_t i = 0; i < 4; ++i) logarithm += regression.slopes[d][i] * given[i];
    for (std::size_t i = 0; i <= d; ++i) logarithm += regression.factor[next++] * z[i];
    out.mm[d] = std::exp(logarithm);
  }
  return out;
}

// Of squareness. In ANSUR II a tape is 1.057 (waist) and 1.093 (hips) times the ellipse of the calliper's breadth and
// depth; on meshes made from scans of people, which nothing presses, about 1.01, on MakeHuman's 1.02 and 1.03. Scans
// are believed: callipers press. These make it 1.014 and 1.020 (150 people). People differ.
constexpr double kHipSquare = -0.02, kWaistSquare = 0, kChestSquare = 0.01, kSquareSd = 0.03;
// No survey measures the place of a section's widest line between front and back: widely varied.
constexpr double kFrontMoreSd = 0.06;

Variety draw_variety(Rng& rng) {
  const auto normal = [&](double mean, double sd) {
    return static_cast<float>(mean + sd * std::clamp(rng.normal(), -2.5, 2.5));
  };
  Variety v;
  for (const auto& [section, square] :
       {std::pair{&v.hip, kHipSquare}, std::pair{&v.waist, kWaistSquare}, std::pair{&v.chest, kChestSquare}}) {
    section->square = normal(square, kSquareSd);
    section->front_more = normal(0, kFrontMoreSd);
  }
  v.head_rise = normal(0, 0.004);
  return v;
}

namespace {

// A rest mesh without a warp, and all that is measured on it once.
class Fitting {
 public:
  Fitting(const BodyModel& model, std::span<const Vec3f> rest)
      : model_(model),
        rest_(rest),
        marks_(warp_landmarks(model, rest)),
        bones_(rest_skeleton(model, rest)),
        own_(dimensions_of(model, rest)),
        sections_(model, rest, marks_, calf_height(bones_)) {}

  Warp warp(const Dimensions& wanted, const Variety& variety) const {
    Warp warp;
    set_rises(marks_, wanted, variety.head_rise, warp);
    const auto ratio = [&](Dimension breadth, Dimension depth) { return wanted[breadth] / wanted[depth]; };
    const auto section = [&](WarpValue first, const Hull& hull, float y, const SectionGoal& goal,
                             const SectionVariety& v) {
      set_section(warp, first, reach(hull, section_frame(model_, rest_, y), goal, v));
    };
    section(WarpValue::hip_breadth, sections_.hip, marks_.buttock,
            {wanted[Dimension::buttock_girth], ratio(Dimension::hip_breadth, Dimension::buttock_depth), 0},
            variety.hip);
    section(WarpValue::waist_breadth, sections_.waist, marks_.navel,
            {wanted[Dimension::waist_girth], ratio(Dimension::waist_breadth, Dimension::waist_depth), 0},
            variety.waist);
    section(WarpValue::chest_breadth, sections_.chest, marks_.nipple,
            {wanted[Dimension::chest_girth], 0, wanted[Dimension::chest_depth]}, variety.chest);
    for (const Scaled& s : kScaled) factor(warp, s.value, wanted[s.dimension], own_[s.dimension], s.most);
    set_shoulders(warp, wanted);
    for (float& value : warp.values) value = gridded(value);
    return warp;
  }

 private:
  struct Scaled {
    WarpValue value;
    Dimension dimension;
    float most;
  };
  static constexpr Scaled kScaled[] = {
      {WarpValue::neck_girth, Dimension::neck_girth, kLimbFactorMax},
      {WarpValue::head_breadth, Dimension::head_breadth, kLengthFactorMax},
      {WarpValue::head_length, Dimension::head_length, kLengthFactorMax},
      {WarpValue::thigh_girth, Dimension::thigh_girth, kLimbFactorMax},
      {WarpValue::calf_girth, Dimension::calf_girth, kLimbFactorMax},
      {WarpValue::upper_arm_girth, Dimension::biceps_girth_flexed, kLimbFactorMax},
      {WarpValue::forearm_girth, Dimension::forearm_girth_flexed, kLimbFactorMax},
      {WarpValue::upper_arm_length, Dimension::upper_arm_length, kLengthFactorMax},
      {WarpValue::forearm_length, Dimension::forearm_length, kLengthFactorMax},
  };
  // The acromion's skin follows the shoulder joints in part, and in part the muscle over them: both breadths at once.
  void set_shoulders(Warp& warp, const Dimensions& wanted) const {
    const auto vertex = static_cast<std::size_t>(model_.data().landmark(Landmark::left_acromion));
    const SkinRecord& skin = model_.data().skin[vertex];
    double arm = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (skin.segment[i] == static_cast<std::uint8_t>(Segment::left_upper_arm))
        arm += static_cast<double>(skin.weight[i]);
    const Vec3f joint = bones_.head[at(Segment::left_upper_arm)],
                bone = bones_.tail[at(Segment::left_upper_arm)] - joint;
    const Vec3f skin_at = rest_[vertex];
    const Vec3f aside = skin_at - joint - bone * (dot(skin_at - joint, bone) / dot(bone, bone));
    const auto x = [](Vec3f p) { return static_cast<double>(p.x); };
    const double half = 0.5 * own_[Dimension::bideltoid_breadth];
    // Of the joints' factor and the muscle's: how far the acromion goes, and the broadest of the shoulder.
    const double acromion[] = {(1 - arm) * x(skin_at) + arm * x(joint), arm * x(aside)};
    const double broadest[] = {x(joint), half - x(joint)};
    const double acromion_by =
        x(skin_at) * (wanted[Dimension::biacromial_breadth] / std::max(own_[Dimension::biacromial_breadth], 1.0) - 1);
    const double broadest_by = 0.5 * wanted[Dimension::bideltoid_breadth] - half;
    const double determinant = acromion[0] * broadest[1] - acromion[1] * broadest[0];
    if (!(std::fabs(determinant) > 1)) return;
    const double by_joints = (acromion_by * broadest[1] - acromion[1] * broadest_by) / determinant;
    const double by_muscle = (acromion[0] * broadest_by - acromion_by * broadest[0]) / determinant;
    warp[WarpValue::shoulder_breadth] = limited(static_cast<float>(by_joints), -kLimbFactorMax, kLimbFactorMax);
    warp[WarpValue::deltoid_girth] = limited(static_cast<float>(by_muscle), -kDeltoidFactorMax, kDeltoidFactorMax);
  }
  static void factor(Warp& warp, WarpValue value, double to, double from, float most) {
    warp[value] = from > 0 ? limited(static_cast<float>(to / from - 1), -most, most) : 0;
  }

  const BodyModel& model_;
  std::span<const Vec3f> rest_;
  WarpLandmarks marks_;
  Skeleton bones_;
  Dimensions own_;
  LevelSections sections_;
};

}  // namespace

Warp warp_to(const BodyModel& model, std::span<const Vec3f> rest, const Dimensions& wanted, const Variety& variety) {
  const Fitting fitting(model, rest);
  const Warp first = fitting.warp(wanted, variety);
  // Levels, limbs and shoulders move one another a little: the next target includes the first warp's error.
  std::vector<Vec3f> warped(rest.begin(), rest.end());
  apply_warp(model, first, warped);
  const Dimensions got = dimensions_of(model, warped);
  Dimensions beyond = wanted;
  for (std::size_t d = 0; d < kDimensionCount; ++d)
    if (got.mm[d] > 0) beyond.mm[d] *= std::clamp(wanted.mm[d] / got.mm[d], 0.9, 1.1);
  for (const auto& [breadth, depth] : {std::pair{Dimension::hip_breadth, Dimension::buttock_depth},
                                       std::pair{Dimension::waist_breadth, Dimension::waist_depth}})
    beyond[breadth] = wanted[breadth], beyond[depth] = wanted[depth];  // of these the ratio alone counts
  return fitting.warp(beyond, variety);
}

Dimensions dimensions_of(const BodyModel& model, std::span<const Vec3f> rest) {
  const Skeleton bones = rest_skeleton(model, rest);
  PosedSkeleton posed_bones;
  const std::vector<Vec3f> mesh = relax(model, rest, bones, posed_bones);
  const WarpLandmarks marks = warp_landmarks(model, mesh);
  const LevelSections sections(model, mesh, marks, calf_height(bones));
  const auto landmark = [&](Landmark l) { return mesh[static_cast<std::size_t>(model.data().landmark(l))]; };
  const auto length = [](Vec3f a, Vec3f b) { return static_cast<double>(norm(a - b)); };
  const auto height = [&](float y) { return static_cast<double>(y) - marks.floor; };
  Dimensions out;
  out[Dimension::cervicale_height] = height(marks.neck);
  out[Dimension::acromial_height] = height(marks.shoulder);
  out[Dimension::chest_height] = height(marks.nipple);
  out[Dimension::waist_height] = height(marks.navel);
  out[Dimension::buttock_height] = height(marks.buttock);
  out[Dimension::crotch_height] = height(marks.crotch);
  out[Dimension::knee_height] = height(marks.knee);
  out[Dimension::biacromial_breadth] = length(landmark(Landmark::left_acromion), landmark(Landmark::right_acromion));
  out[Dimension::bideltoid_breadth] = breadth_of_shoulders(model, mesh, posed_bones);
  out[Dimension::chest_depth] = Extents(sections.chest).depth();
  out[Dimension::chest_girth] = perimeter_mm(sections.chest);
  out[Dimension::waist_breadth] = Extents(sections.waist).breadth();
  out[Dimension::waist_depth] = Extents(sections.waist).depth();
  out[Dimension::waist_girth] = perimeter_mm(sections.waist);
  out[Dimension::hip_breadth] = Extents(sections.hip).breadth();
  out[Dimension::buttock_depth] = Extents(sections.hip).depth();
  out[Dimension::buttock_girth] = perimeter_mm(sections.hip);
  out[Dimension::neck_girth] = neck_girth_mm(model, mesh);
  out[Dimension::thigh_girth] = perimeter_mm(sections.thigh);
  out[Dimension::calf_girth] = perimeter_mm(sections.calf);
  out[Dimension::biceps_girth_flexed] =
      limb_girth_mm(model, rest, bones, Segment::left_upper_arm, kBicepsShare) / kRelaxedBiceps;
  out[Dimension::forearm_girth_flexed] =
      limb_girth_mm(model, rest, bones, Segment::left_lower_arm, kForearmShare) / kRelaxedForearm;
  out[Dimension::upper_arm_length] =
      length(landmark(Landmark::left_acromion), posed_bones.head[at(Segment::left_lower_arm)]);
  out[Dimension::forearm_length] =
      length(posed_bones.head[at(Segment::left_lower_arm)], posed_bones.head[at(Segment::left_hand)]);
  Extents head({});
  const float skull = marks.head + kSkullShare * (marks.crown - marks.floor);
  std::vector<Vec3f> skin_of_head;
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v)
    if (mesh[v].y > skull && model.data().skin[v].segment[0] == static_cast<std::uint8_t>(Segment::head))
      skin_of_head.push_back(mesh[v]);
  head = Extents(skin_of_head);
  out[Dimension::head_breadth] = head.breadth();
  out[Dimension::head_length] = head.depth();
  return out;
}

}  // namespace im2fit::body
