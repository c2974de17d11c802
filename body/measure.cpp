// SPDX-License-Identifier: Apache-2.0
#include "body/measure.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>

#include "body/model_data.h"
#include "body/section.h"

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

enum Girth { kChest, kWaist, kHip, kShoulder, kGirths };

// A section of a body crosses some hundred edges; of one that crosses more, memory grows.
constexpr std::size_t kSectionPointMax = 4096;

// Memory that is used from one mesh to the next.
struct StandingWork {
  std::vector<float> heights, neck_heights;
  std::vector<std::uint8_t> above;
  std::array<Level, kGirths> levels;
  TriangleStack neck;
  std::vector<Vec3f> points, hull, best;
  HullWork hulls;

  void reserve(const BodyModel& model) {
    const auto count = static_cast<std::size_t>(model.body_vertex_count());
    heights.reserve(count);
    neck_heights.reserve(count);
    above.reserve(count);
    for (Level& level : levels) level.points.reserve(kSectionPointMax);
    neck.reserve(model.body_triangles().size());
    for (std::vector<Vec3f>* list : {&points, &hull, &best}) list->reserve(kSectionPointMax);
    hulls.reserve(kSectionPointMax);
  }
};

// A relaxed, standing mesh and the levels its girths are taken at.
class Standing {
 public:
  // `raised_mm`: chest, waist and hip are taken so much higher than where they are.
  Standing(const BodyModel& model, std::span<const Vec3f> vertices, float gender, StandingWork& work,
           float raised_mm = 0)
      : model_(model), d_(model.data()), v_(vertices), gender_(gender), work_(work) {
    assert(vertices.size() == static_cast<std::size_t>(model.vertex_count()));
    heights_along(body_of(model, vertices), {0, 1, 0}, work_.heights);
    set_level(kChest, nipple_y() + raised_mm, true);
    set_level(kWaist, waist_y() + raised_mm, true);
    set_level(kHip, rearmost_buttock_y() + raised_mm, true);
    set_level(kShoulder, shoulder_y(), false);
    section_levels(d_.quads, d_.triangle_is_arm, v_, work_.heights, work_.above, work_.levels);
  }

  // Until the next call of this or neck().
  std::span<const Vec3f> girth(Girth girth) {
    const Level& level = work_.levels[girth];
    work_.hulls.convex_hull(level.points, level_plane(level.height), work_.hull);
    return work_.hull;
  }

  // The smallest section perpendicular to the line from the neck's root to the skull's: a coarse walk along it, then
  // a fine one about the best.
  std::span<const Vec3f> neck() {
    const Vec3f root = mean_of_list(d_, kHeadLists + at(Segment::neck), v_);
    const Vec3f axis = mean_of_list(d_, kHeadLists + at(Segment::head), v_) - root;
    collect_neck(root, axis);
    work_.best.clear();
    float best_share = 0.5F;
    double best_mm = 1e9;
    const auto try_share = [&](float share) {
      const SectionPlane plane = plane_through(root + axis * share, axis);
      work_.points.clear();
      work_.neck.cut(v_, work_.neck_heights, dot(plane.origin, plane.normal), work_.points);
      work_.hulls.convex_hull(work_.points, plane, work_.hull);
      if (work_.hull.size() < 3) return;
      if (const double mm = perimeter_mm(work_.hull); mm < best_mm) {
        best_mm = mm;
        best_share = share;
        std::swap(work_.best, work_.hull);
      }
    };
    for (int i = 0; i <= 10; ++i) try_share(0.1F * static_cast<float>(i));
    const float coarse = best_share;
    for (const int i : {-2, -1, 1, 2}) try_share(coarse + static_cast<float>(i) / 30);
    return work_.best;
  }

  Vec3f landmark(Landmark l) const { return v_[static_cast<std::size_t>(d_.landmark(l))]; }

 private:
  void set_level(Girth girth, float y, bool heeds_skip) {
    Level& level = work_.levels[girth];
    level.height = y;
    level.heeds_skip = heeds_skip;
    level.points.clear();
  }

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
    work_.neck.clear();
    const Vec3f n = normalized(axis);
    heights_along(body_of(model_, v_), n, work_.neck_heights);
    const float low = dot(root, n) - 30;
    const float high = dot(root + axis, n) + 60;
    for (std::size_t t = 0; t < d_.triangles.size(); ++t) {
      const auto first = static_cast<std::size_t>(d_.triangles[t][0]);
      const float height = work_.neck_heights[first];
      if (height < low || height > high || d_.triangle_is_arm[t] != 0) continue;
      const Vec3f p = v_[first] - root;
      const float along = dot(p, n);
      if (dot(p, p) - along * along < kNeckRadiusMaxMm * kNeckRadiusMaxMm)
        work_.neck.add(d_.triangles[t], work_.neck_heights);
    }
  }

  const BodyModel& model_;
  const BodyModel::Data& d_;
  std::span<const Vec3f> v_;
  float gender_;
  StandingWork& work_;
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

float inside_leg_mm(const BodyModel& model, std::span<const Vec3f> vertices) {
  const auto crotch = static_cast<std::size_t>(model.data().landmark(Landmark::crotch));
  return vertices[crotch].y - extent_y(body_of(model, vertices)).low;
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
  StandingWork work;
  return perimeter_mm(Standing(model, posed_vertices, 0.5F, work).neck());
}

namespace {

constexpr std::array<Measurement, 5> kGirthIds = {Measurement::neck_girth, Measurement::shoulder_girth,
                                                  Measurement::chest_girth, Measurement::waist_girth,
                                                  Measurement::hip_girth};
using Sections = std::array<Section, kGirthIds.size()>;

void take_sections(Standing& standing, Sections& out) {
  const auto take = [&](std::size_t i, std::span<const Vec3f> hull) {
    out[i].id = kGirthIds[i];
    out[i].hull.assign(hull.begin(), hull.end());
  };
  take(0, standing.neck());
  take(1, standing.girth(kShoulder));
  take(2, standing.girth(kChest));
  take(3, standing.girth(kWaist));
  take(4, standing.girth(kHip));
}

}  // namespace

struct Measurer::Work {
  std::vector<Vec3f> rest, posed;
  StandingWork standing;
  MeasurementValues values{};
  Skeleton rest_bones;
  PosedSkeleton bones;
  Sections sections;
  float gender = 0;
};

Measurer::Measurer(const BodyModel& model) : model_(&model), work_(std::make_unique<Work>()) {
  const auto count = static_cast<std::size_t>(model.vertex_count());
  work_->rest.resize(count);
  work_->posed.resize(count);
  work_->standing.reserve(model);
  for (Section& section : work_->sections) section.hull.reserve(kSectionPointMax);
}
Measurer::Measurer(Measurer&&) noexcept = default;
Measurer& Measurer::operator=(Measurer&&) noexcept = default;
Measurer::~Measurer() = default;

MeasurementValues Measurer::measure(const Params& params) {
  model_->morph(params, work_->rest);
  return measure_rest_mesh(work_->rest, params.gender);
}

MeasurementValues measure_rest_mesh(const BodyModel& model, std::span<const Vec3f> rest_vertices, float gender) {
  return Measurer(model).measure_rest_mesh(rest_vertices, gender);
}

MeasurementValues Measurer::measure_rest_mesh(std::span<const Vec3f> rest_vertices, float gender) {
  const BodyModel& model = *model_;
  MeasurementValues& out = work_->values;
  const auto set = [&](Measurement m, double value) { out[measurement_index(m)] = static_cast<float>(value); };
  const double litres = volume_litres(model, rest_vertices);
  const double tall_mm = stature_mm(model, rest_vertices);
  set(Measurement::stature, tall_mm);
  set(Measurement::weight, litres * 1e-3 * density_kg_m3(tall_mm, litres));

  const Skeleton& rest = work_->rest_bones = rest_skeleton(model, rest_vertices);
  const Pose pose = relaxed_pose(rest, spread_deg(tall_mm, litres));
  const std::span<Vec3f> posed = work_->posed;
  skin(model, rest_vertices, rest, pose, posed);
  work_->gender = gender;
  Standing standing(model, posed, gender, work_->standing);
  take_sections(standing, work_->sections);
  for (const Section& section : work_->sections) set(section.id, perimeter_mm(section.hull));
  set(Measurement::inside_leg, inside_leg_mm(model, posed));

  const Vec3f left = standing.landmark(Landmark::left_acromion);
  const Vec3f right = standing.landmark(Landmark::right_acromion);
  set(Measurement::shoulder_breadth, norm(left - right));
  const PosedSkeleton& bones = work_->bones = pose_skeleton(rest, pose);
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

Measurer::Slopes Measurer::girth_slopes() const {
  constexpr float kStepMm = 20;
  const auto girths_at = [&](float raised_mm) {
    Standing standing(*model_, work_->posed, work_->gender, work_->standing, raised_mm);
    return Slopes{perimeter_mm(standing.girth(kChest)), perimeter_mm(standing.girth(kWaist)),
                  perimeter_mm(standing.girth(kHip))};
  };
  const Slopes low = girths_at(-kStepMm), high = girths_at(kStepMm);
  const auto slope = [](double below, double above) { return (above - below) / (2 * static_cast<double>(kStepMm)); };
  return {slope(low.chest, high.chest), slope(low.waist, high.waist), slope(low.hip, high.hip)};
}

double Measurer::chest_girth_mm(std::span<const Vec3f> rest_vertices, float arms_off_deg, float raised_mm) {
  const Skeleton& rest = work_->rest_bones;
  const std::span<Vec3f> posed = work_->posed;
  skin(*model_, rest_vertices, rest, relaxed_pose(rest, arms_off_deg), posed);
  Standing standing(*model_, posed, work_->gender, work_->standing, raised_mm);
  return perimeter_mm(standing.girth(kChest));
}

const MeasurementValues& Measurer::values() const {
  return work_->values;
}
const Skeleton& Measurer::rest_bones() const {
  return work_->rest_bones;
}
std::span<const Vec3f> Measurer::rest() const {
  return work_->rest;
}
std::span<const Vec3f> Measurer::posed() const {
  return work_->posed;
}
const PosedSkeleton& Measurer::bones() const {
  return work_->bones;
}
std::span<const Section> Measurer::sections() const {
  return work_->sections;
}

MeasurementValues measure_person(const BodyModel& model, const Params& params) {
  return Measurer(model).measure(params);
}

std::vector<Section> girth_sections(const BodyModel& model, std::span<const Vec3f> relaxed_vertices, float gender) {
  StandingWork work;
  Standing standing(model, relaxed_vertices, gender, work);
  Sections sections;
  take_sections(standing, sections);
  return {std::make_move_iterator(sections.begin()), std::make_move_iterator(sections.end())};
}

}  // namespace im2fit::body
