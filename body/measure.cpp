// SPDX-License-Identifier: Apache-2.0
#include "body/measure.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "body/model_data.h"
#include "body/section.h"
#include "body/skeleton.h"

namespace im2fit::body {
namespace {

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Where ANSUR II puts the waist (midway between lowest rib and iliac crest) between navel and nipples.
constexpr float kWaistShareMan = 0.145F;
constexpr float kWaistShareWoman = 0.239F;
constexpr float kShoulderGirthShare = 0.2F;  // of the upper arm, below the shoulder joint
constexpr float kNeckRadiusMaxMm = 150;      // triangles farther from the neck axis are shoulders

std::span<const Vec3f> body_of(const BodyModel& model, std::span<const Vec3f> vertices) {
  return vertices.first(static_cast<std::size_t>(model.body_vertex_count()));
}

struct Extent {
  float low, high;
};
Extent extent_y(std::span<const Vec3f> vertices) {
  Extent e = {vertices[0].y, vertices[0].y};
  for (const Vec3f& v : vertices) {
    e.low = v.y < e.low ? v.y : e.low;
    e.high = v.y > e.high ? v.y : e.high;
  }
  return e;
}

// A relaxed, standing mesh and the levels its girths are taken at.
class Standing {
 public:
  Standing(const BodyModel& model, std::span<const Vec3f> vertices, float gender)
      : model_(model), d_(model.data()), v_(vertices), gender_(gender) {
    assert(vertices.size() == static_cast<std::size_t>(model.vertex_count()));
    heights_along(body_of(model, vertices), {0, 1, 0}, heights_);
    levels_[kChest] = {nipple_y(), true, {}};
    levels_[kWaist] = {waist_y(), true, {}};
    levels_[kHip] = {rearmost_buttock_y(), true, {}};
    levels_[kShoulder] = {shoulder_y(), false, {}};
    section_levels(d_.quads, d_.triangle_is_arm, v_, heights_, levels_);
  }

  enum Girth { kChest, kWaist, kHip, kShoulder, kGirths };
  std::vector<Vec3f> girth(Girth girth) {
    const Level& level = levels_[girth];
    return convex_hull(level.points, level_plane(level.height));
  }

  // The smallest section perpendicular to the line from the neck's root to the skull's: a coarse walk along it, then
  // a fine one about the best.
  std::vector<Vec3f> neck() {
    const Vec3f root = mean_of_list(d_, kHeadLists + at(Segment::neck), v_);
    const Vec3f axis = mean_of_list(d_, kHeadLists + at(Segment::head), v_) - root;
    collect_neck(root, axis);
    std::vector<Vec3f> best;
    float best_share = 0.5F;
    double best_mm = 1e9;
    const auto try_share = [&](float share) {
      const SectionPlane plane = plane_through(root + axis * share, axis);
      points_.clear();
      neck_.cut(v_, neck_heights_, dot(plane.origin, plane.normal), points_);
      auto hull = convex_hull(points_, plane);
      if (hull.size() < 3) return;
      if (const double mm = perimeter_mm(hull); mm < best_mm) {
        best_mm = mm;
        best_share = share;
        best = std::move(hull);
      }
    };
    for (int i = 0; i <= 10; ++i) try_share(0.1F * static_cast<float>(i));
    const float coarse = best_share;
    for (const int i : {-2, -1, 1, 2}) try_share(coarse + static_cast<float>(i) / 30);
    return best;
  }

  Vec3f landmark(Landmark l) const { return v_[static_cast<std::size_t>(d_.landmark(l))]; }

 private:
  float nipple_y() const { return 0.5F * (landmark(Landmark::left_nipple).y + landmark(Landmark::right_nipple).y); }

  float waist_y() const {
    const float woman = 1 - (gender_ > 0 ? (gender_ < 1 ? gender_ : 1) : 0);
    const float share = kWaistShareMan + (kWaistShareWoman - kWaistShareMan) * woman;
    const float navel = landmark(Landmark::navel).y;
    return navel + share * (nipple_y() - navel);
  }

  float shoulder_y() const {
    float y = 0;
    for (const Segment s : {Segment::left_upper_arm, Segment::right_upper_arm}) {
      const float top = mean_of_list(d_, kHeadLists + at(s), v_).y;
      const float elbow = mean_of_list(d_, kTailLists + at(s), v_).y;
      y += 0.5F * (top + kShoulderGirthShare * (elbow - top));
    }
    return y;
  }

  float rearmost_buttock_y() const {
    const float low = landmark(Landmark::crotch).y - 60;
    const float high = landmark(Landmark::navel).y;
    Vec3f rearmost = {0, 0.5F * (low + high), 1e9F};
    for (std::size_t i = 0; i < static_cast<std::size_t>(kBodyVertexCount); ++i) {
      if (v_[i].z >= rearmost.z || v_[i].y < low || v_[i].y > high) continue;
      const auto s = static_cast<Segment>(d_.skin[i].segment[0]);
      if (s == Segment::pelvis || s == Segment::left_upper_leg || s == Segment::right_upper_leg) rearmost = v_[i];
    }
    return rearmost.y;
  }

  void collect_neck(Vec3f root, Vec3f axis) {
    neck_.clear();
    const Vec3f n = normalized(axis);
    heights_along(body_of(model_, v_), n, neck_heights_);
    const float low = dot(root, n) - 30;
    const float high = dot(root + axis, n) + 60;
    for (std::size_t t = 0; t < d_.triangles.size(); ++t) {
      const auto first = static_cast<std::size_t>(d_.triangles[t][0]);
      const float height = neck_heights_[first];
      if (height < low || height > high || d_.triangle_is_arm[t] != 0) continue;
      const Vec3f p = v_[first] - root;
      const float along = dot(p, n);
      if (dot(p, p) - along * along < kNeckRadiusMaxMm * kNeckRadiusMaxMm) neck_.add(d_.triangles[t], neck_heights_);
    }
  }

  const BodyModel& model_;
  const BodyModel::Data& d_;
  std::span<const Vec3f> v_;
  float gender_;
  std::vector<float> heights_;
  std::array<Level, kGirths> levels_;
  std::vector<Vec3f> points_;
  TriangleStack neck_;
  std::vector<float> neck_heights_;
};

float chain_length(std::initializer_list<Vec3f> points) {
  float sum = 0;
  for (const Vec3f* p = points.begin(); p + 1 != points.end(); ++p) sum += norm(p[1] - p[0]);
  return sum;
}

}  // namespace

double volume_litres(const BodyModel& model, std::span<const Vec3f> vertices) {
  double six_volumes = 0;
  for (const auto& t : model.body_triangles())
    six_volumes += static_cast<double>(
        dot(vertices[static_cast<std::size_t>(t[0])],
            cross(vertices[static_cast<std::size_t>(t[1])], vertices[static_cast<std::size_t>(t[2])])));
  return six_volumes / 6e6;
}

double density_kg_m3(double stature_mm, double volume_l) {
  const double litres_per_m2 = volume_l / (stature_mm * stature_mm * 1e-6);  // body mass index, nearly
  const double share = (litres_per_m2 - kLeanIndex) / (kObeseIndex - kLeanIndex);
  return kLeanDensityKgM3 + (kObeseDensityKgM3 - kLeanDensityKgM3) * (share > 0 ? (share < 1 ? share : 1) : 0);
}

double stature_mm(const BodyModel& model, std::span<const Vec3f> vertices) {
  const Extent e = extent_y(body_of(model, vertices));
  return static_cast<double>(e.high) - e.low;
}

namespace {

float spread_deg(double tall_mm, double litres) {
  const double stature_m = tall_mm * 1e-3;
  const double index = litres / (stature_m * stature_m);
  // 10 degrees for the slim (20 l/m^2), 14 at 30, 21 at 42: what keeps arms out of the flanks.
  const double spread = index < 30 ? 10 + (index - 20) * 0.4 : 14 + (index - 30) * (7.0 / 12);
  return static_cast<float>(spread > 10 ? (spread < 22 ? spread : 22) : 10);
}

}  // namespace

float relaxed_spread_deg(const BodyModel& model, std::span<const Vec3f> rest_vertices) {
  return spread_deg(stature_mm(model, rest_vertices), volume_litres(model, rest_vertices));
}

double neck_girth_mm(const BodyModel& model, std::span<const Vec3f> posed_vertices) {
  return perimeter_mm(Standing(model, posed_vertices, 0.5F).neck());
}

MeasurementValues measure_rest_mesh(const BodyModel& model, std::span<const Vec3f> rest_vertices, float gender) {
  MeasurementValues out{};
  const auto set = [&](Measurement m, double value) { out[measurement_index(m)] = static_cast<float>(value); };
  const double litres = volume_litres(model, rest_vertices);
  const double tall_mm = stature_mm(model, rest_vertices);
  set(Measurement::stature, tall_mm);
  set(Measurement::weight, litres * 1e-3 * density_kg_m3(tall_mm, litres));

  const Skeleton rest = rest_skeleton(model, rest_vertices);
  const Pose pose = relaxed_pose(rest, spread_deg(tall_mm, litres));
  std::vector<Vec3f> posed(rest_vertices.size());
  skin(model, rest_vertices, rest, pose, posed);
  Standing standing(model, posed, gender);
  set(Measurement::chest_girth, perimeter_mm(standing.girth(Standing::kChest)));
  set(Measurement::waist_girth, perimeter_mm(standing.girth(Standing::kWaist)));
  set(Measurement::hip_girth, perimeter_mm(standing.girth(Standing::kHip)));
  set(Measurement::shoulder_girth, perimeter_mm(standing.girth(Standing::kShoulder)));
  set(Measurement::neck_girth, perimeter_mm(standing.neck()));
  set(Measurement::inside_leg, standing.landmark(Landmark::crotch).y - extent_y(body_of(model, posed)).low);

  const Vec3f left = standing.landmark(Landmark::left_acromion);
  const Vec3f right = standing.landmark(Landmark::right_acromion);
  set(Measurement::shoulder_breadth, norm(left - right));
  const PosedSkeleton bones = pose_skeleton(rest, pose);
  const auto head = [&](Segment s) { return bones.head[at(s)]; };
  set(Measurement::sleeve_length,
      0.5F * (chain_length({left, head(Segment::left_lower_arm), head(Segment::left_hand)}) +
              chain_length({right, head(Segment::right_lower_arm), head(Segment::right_hand)})));
  set(Measurement::leg_length,
      0.5F * (chain_length({head(Segment::left_upper_leg), head(Segment::left_lower_leg), head(Segment::left_foot)}) +
              chain_length(
                  {head(Segment::right_upper_leg), head(Segment::right_lower_leg), head(Segment::right_foot)})));
  return out;
}

MeasurementValues measure_person(const BodyModel& model, const Params& params) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, rest);
  return measure_rest_mesh(model, rest, params.gender);
}

std::vector<Section> girth_sections(const BodyModel& model, std::span<const Vec3f> relaxed_vertices, float gender) {
  Standing standing(model, relaxed_vertices, gender);
  std::vector<Section> sections;
  sections.push_back({Measurement::neck_girth, standing.neck()});
  sections.push_back({Measurement::shoulder_girth, standing.girth(Standing::kShoulder)});
  sections.push_back({Measurement::chest_girth, standing.girth(Standing::kChest)});
  sections.push_back({Measurement::waist_girth, standing.girth(Standing::kWaist)});
  sections.push_back({Measurement::hip_girth, standing.girth(Standing::kHip)});
  return sections;
}

}  // namespace im2fit::body
