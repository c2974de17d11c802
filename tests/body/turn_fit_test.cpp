// SPDX-License-Identifier: Apache-2.0
// A person who turns round before a perfect camera. The truth is measured on the mesh that was drawn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "allocations.h"
#include "body/fit/point_mesh.h"
#include "body/fit/shape_fitter.h"
#include "body/fit/turn_fitter.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/section.h"
#include "body_pack.h"
#include "seen_person.h"

namespace im2fit::body {
namespace {

constexpr int kWidth = SeenPerson::kWidth, kHeight = SeenPerson::kHeight;
constexpr float kCameraHeightMm = SeenPerson::kCameraHeightMm, kDistanceMm = 2400;
constexpr Intrinsics kCamera = {kWidth, kHeight, 575.8F, 575.8F, 239.5F, 319.5F};

class Turning {
 public:
  // `belly_mm`: added to the trunk's skin at the height of the navel, along its normals, fading over 120 mm.
  Turning(const BodyModel& model, std::uint64_t index, float belly_mm) : model_(model) {
    const auto subject = lab::draw_subject(model, lab::Family::held_out, 8, index);
    gender_ = subject.params.gender;
    rest_.resize(static_cast<std::size_t>(model.vertex_count()));
    lab::morph_subject(model, subject, rest_);
    add_belly(belly_mm);
    const Skeleton skeleton = rest_skeleton(model, rest_);
    posed_.resize(rest_.size());
    skin(model, rest_, skeleton, relaxed_pose(skeleton, 28), posed_);
    floor_ = posed_[0].y;
    for (const Vec3f p : bodies(posed_)) floor_ = std::min(floor_, p.y);
  }

  MeasurementValues truth() const { return measure_rest_mesh(model_, rest_, gender_); }
  float gender() const { return gender_; }
  std::span<const Vec3f> rest() const { return rest_; }

  struct Picture {
    std::vector<std::uint16_t> depth;
    std::vector<std::uint8_t> mask;
    TurnPicture view() const {
      return {{depth.data(), kWidth, kHeight}, 1.0F / 16, {mask.data(), kWidth, kHeight}, kCamera};
    }
  };
  Picture picture(float yaw_deg) const {
    const Mat3f turn = rotation_about({0, 1, 0}, yaw_deg);
    std::vector<Vec3f> seen;
    for (const Vec3f p : bodies(posed_)) seen.push_back(to_camera(turn * p));
    lab::CleanView clean(kWidth, kHeight);
    const std::uint8_t label = lab::kPerson;
    lab::MeshRaster().draw(seen, model_.body_triangles(), {&label, 1}, true, kCamera, lab::whole(kWidth, kHeight),
                           clean);
    Picture out;
    for (const float inverse : clean.inverse_depth) {
      out.depth.push_back(inverse > 0 ? static_cast<std::uint16_t>(16 / inverse + 0.5F) : std::uint16_t{0});
      out.mask.push_back(inverse > 0 ? 255 : 0);
    }
    return out;
  }
  FitView front(const Picture& picture) const {
    FitView view;
    view.depth_q4 = {picture.depth.data(), kWidth, kHeight};
    view.mask = {picture.mask.data(), kWidth, kHeight};
    view.intrinsics = kCamera;
    view.joints = joints_of(model_, posed_);
    for (Vec3f& p : view.joints.position_mm) p = to_camera(p);
    view.floor = {true, {0, -1, 0}, kCameraHeightMm};
    return view;
  }

 private:
  std::span<const Vec3f> bodies(std::span<const Vec3f> mesh) const {
    return mesh.first(static_cast<std::size_t>(model_.body_vertex_count()));
  }
  Vec3f to_camera(Vec3f p) const { return {p.x, kCameraHeightMm + floor_ - p.y, kDistanceMm - p.z}; }
  void add_belly(float belly_mm) {
    const Vec3f navel = rest_[static_cast<std::size_t>(model_.data().landmark(Landmark::navel))];
    for (std::size_t v = 0; v < static_cast<std::size_t>(model_.body_vertex_count()); ++v) {
      const auto s = static_cast<Segment>(model_.data().skin[v].segment[0]);
      if (s != Segment::pelvis && s != Segment::abdomen && s != Segment::chest) continue;
      const float up = (rest_[v].y - navel.y) / 120;
      const Vec3f out = normalized(Vec3f{rest_[v].x, 0, rest_[v].z});
      rest_[v] = rest_[v] + out * (belly_mm * std::exp(-up * up));
    }
  }

  const BodyModel& model_;
  float gender_ = 0, floor_ = 0;
  std::vector<Vec3f> rest_, posed_;
};

// Round the trunk at a height above the floor, of a body in the pose it is measured in.
double trunk_girth_mm(const BodyModel& model, std::span<const Vec3f> rest, float gender, float height_mm) {
  Measurer measurer(model);
  measurer.measure_rest_mesh(rest, gender);
  const auto posed = measurer.posed();
  std::vector<float> heights;
  float low = posed[0].y;
  for (const Vec3f p : posed.first(static_cast<std::size_t>(model.body_vertex_count()))) {
    heights.push_back(p.y);
    low = std::min(low, p.y);
  }
  std::array<Level, 1> levels;
  levels[0].height = low + height_mm;
  levels[0].heeds_skip = true;
  section_levels(model.data().quads, model.data().triangle_is_arm, posed, heights, levels);
  return perimeter_mm(convex_hull(levels[0].points, level_plane(levels[0].height)));
}
// Where the landmarks put a section.
float level_mm(const BodyModel& model, std::span<const Vec3f> rest, float gender, Measurement id) {
  Measurer measurer(model);
  measurer.measure_rest_mesh(rest, gender);
  float low = measurer.posed()[0].y;
  for (const Vec3f p : measurer.posed().first(static_cast<std::size_t>(model.body_vertex_count())))
    low = std::min(low, p.y);
  for (const Section& section : measurer.sections())
    if (section.id == id) return section.hull.at(0).y - low;
  return 0;
}

// The axes of a camera that was carried round by so much to the person's right: it sees the picture of the person
// turned by so much to the left. Told a little wrong, but for the floor.
PersonAxes carried_by(const PersonAxes& front, float yaw_deg, Vec3f off_mm) {
  const Mat3f turn = rotation_about({0, 1, 0}, yaw_deg);  // about the vertical: the same in both axes
  const Vec3f centre{0, 0, kDistanceMm};
  return front.seen_from(turn, centre - turn * centre + off_mm, {true, {0, -1, 0}, kCameraHeightMm});
}

// Follows a whole turn in steps of 12 degrees, fits eight pictures of it and measures the body found. `carried`: the
// same pictures, as a camera sees them that is carried round a person who stands.
struct Turned {
  float turned_deg = 0, worst_step_deg = 0;
  float least_facing = 1;  // cosine between the pelvis' front and where it was
  int followed = 0, pictures = 0;
  bool valid = false;
  MeasurementValues values{};
  std::vector<Vec3f> mesh;
};
Turned turn(const BodyModel& model, const Turning& person, bool carried = false) {
  Turned out;
  ShapeFitter front(model.shape_space());
  TurnFitter fitter(model.shape_space());
  std::vector<Turning::Picture> kept = {person.picture(0)};
  kept.reserve(kTurnViewMax);
  const FitView view = person.front(kept[0]);
  const ShapeFit& fit = front.run({&view, 1});
  if (!fit.valid) return out;
  const PersonAxes axes(view.joints, view.floor);
  fitter.begin(std::span(fit.shape).first(model.shape_space().shape_count), fit.pose, axes, true);
  std::vector<TurnView> views = {{kept[0].view(), fit.pose}};
  for (int i = 1; i <= 30; ++i) {
    const float yaw = 12.0F * static_cast<float>(i);
    Turning::Picture picture = person.picture(yaw);
    TurnPicture seen = picture.view();
    if (carried) seen.axes = carried_by(axes, yaw, {i % 2 == 0 ? 5.0F : -5.0F, 20, 4});
    ++out.pictures;
    if (fitter.follow(seen)) ++out.followed;
    out.worst_step_deg = std::max(out.worst_step_deg, std::fabs(fitter.turned_deg() - yaw));
    out.least_facing = std::min(out.least_facing, fitter.pose().rotation[0].m[8]);
    if (views.size() < 8 && fitter.turned_deg() >= 45.0F * static_cast<float>(views.size())) {
      kept.push_back(std::move(picture));
      views.push_back({kept.back().view(), fitter.pose()});
      views.back().picture.axes = seen.axes;
    }
  }
  out.turned_deg = fitter.turned_deg();
  const TurnFit& found = fitter.run(views);
  out.valid = found.valid;
  if (!found.valid) return out;
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  model.morph({}, mesh);
  PointMesh(model).run(found.points, found.bones, mesh);
  out.values = measure_rest_mesh(model, mesh, person.gender());
  out.mesh = mesh;
  return out;
}

TEST(TurnFit, APersonIsFollowedAllRound) {
  IM2FIT_NEEDS_SPACE();
  for (const std::uint64_t index : {0U, 1U}) {
    const Turning person(*real_body(), index, 0);
    const Turned turned = turn(*real_body(), person);
    EXPECT_TRUE(turned.valid);
    EXPECT_EQ(turned.followed, turned.pictures);
    EXPECT_NEAR(turned.turned_deg, 360, 4) << index;
    EXPECT_LT(turned.worst_step_deg, 8) << index;
  }
}

// What was seen is measured, whatever people are like: a belly that no training person has.
TEST(TurnFit, AGirthBeyondAllTeachersIsMeasured) {
  IM2FIT_NEEDS_SPACE();
  const BodyModel& model = *real_body();
  const Turning plain(model, 0, 0), person(model, 0, 70);
  const Turned turned = turn(model, person);
  ASSERT_TRUE(turned.valid);
  for (const Measurement id : {Measurement::waist_girth, Measurement::hip_girth}) {
    const float at = level_mm(model, person.rest(), person.gender(), id);
    EXPECT_NEAR(trunk_girth_mm(model, turned.mesh, person.gender(), at),
                trunk_girth_mm(model, person.rest(), person.gender(), at), 8);
  }
  const std::size_t waist = measurement_index(Measurement::waist_girth);
  EXPECT_GT(person.truth()[waist], plain.truth()[waist] + 300);
}

TEST(TurnFit, ACameraCarriedRoundMeasuresAsAPersonWhoTurns) {
  IM2FIT_NEEDS_SPACE();
  const BodyModel& model = *real_body();
  const Turning person(model, 0, 0);
  const Turned turned = turn(model, person), walked = turn(model, person, true);
  ASSERT_TRUE(turned.valid && walked.valid);
  EXPECT_EQ(walked.followed, walked.pictures);
  EXPECT_NEAR(walked.turned_deg, 360, 4);
  EXPECT_LT(walked.worst_step_deg, 8);
  EXPECT_GT(walked.least_facing, 0.97F) << "the person stands still";
  EXPECT_LT(turned.least_facing, -0.97F);
  for (const Measurement id :
       {Measurement::stature, Measurement::chest_girth, Measurement::waist_girth, Measurement::hip_girth})
    EXPECT_NEAR(walked.values[measurement_index(id)], turned.values[measurement_index(id)], 4)
        << static_cast<int>(id);
}

TEST(TurnFit, NothingIsAllocatedAfterConstruction) {
  IM2FIT_NEEDS_SPACE();
  const BodyModel& model = *real_body();
  const Turning person(model, 0, 0);
  ShapeFitter front(model.shape_space());
  TurnFitter fitter(model.shape_space());
  const Turning::Picture first = person.picture(0), second = person.picture(12);
  const FitView view = person.front(first);
  const ShapeFit& fit = front.run({&view, 1});
  const std::array<TurnView, 2> views = {{{first.view(), fit.pose}, {second.view(), fit.pose}}};
  const PersonAxes axes(view.joints, view.floor);
  const std::size_t before = allocations_so_far();
  fitter.begin(std::span(fit.shape).first(model.shape_space().shape_count), fit.pose, axes, true);
  EXPECT_TRUE(fitter.follow(second.view()));
  EXPECT_TRUE(fitter.run(views).valid);
  EXPECT_EQ(allocations_so_far(), before);
}

TEST(TurnFit, APictureWithoutThePersonChangesNothing) {
  IM2FIT_NEEDS_SPACE();
  const BodyModel& model = *real_body();
  const Turning person(model, 0, 0);
  ShapeFitter front(model.shape_space());
  TurnFitter fitter(model.shape_space());
  const Turning::Picture first = person.picture(0);
  const FitView view = person.front(first);
  const ShapeFit& fit = front.run({&view, 1});
  fitter.begin(std::span(fit.shape).first(model.shape_space().shape_count), fit.pose,
               PersonAxes(view.joints, view.floor), true);
  Turning::Picture empty = first;
  std::fill(empty.depth.begin(), empty.depth.end(), std::uint16_t{0});
  std::fill(empty.mask.begin(), empty.mask.end(), std::uint8_t{0});
  EXPECT_FALSE(fitter.follow(empty.view()));
  EXPECT_EQ(fitter.turned_deg(), 0);
  TurnPicture wrong = first.view();
  wrong.mask = {};
  EXPECT_FALSE(fitter.follow(wrong));
  EXPECT_FALSE(fitter.run({}).valid);
  const std::array<TurnView, 2> with_empty = {{{first.view(), fit.pose}, {empty.view(), fit.pose}}};
  EXPECT_FALSE(fitter.run(with_empty).valid);
  TurnPicture endless = first.view();
  endless.intrinsics.fx = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(fitter.follow(endless));
  // A fit depends on the start and the views alone.
  const std::array<TurnView, 1> one = {{{first.view(), fit.pose}}};
  const TurnFit once = fitter.run(one), again = fitter.run(one);
  ASSERT_TRUE(once.valid && again.valid);
  EXPECT_EQ(once.shape, again.shape);
  EXPECT_EQ(once.surface_mm[0], again.surface_mm[0]);
  EXPECT_TRUE(fitter.follow(first.view()));
}

// The mesh through the true points of a body measures what the body does.
TEST(PointMesh, MeasuresWhatTheBodyDoes) {
  IM2FIT_NEEDS_SPACE();
  const BodyModel& model = *real_body();
  PointMesh maker(model);
  ASSERT_TRUE(maker.valid());
  const std::vector<Quad> quads = quads_of_shape_space(model);
  for (const float belly_mm : {0.0F, 70.0F})
    for (const std::uint64_t index : {0U, 1U, 2U, 3U}) {
      const Turning person(model, index, belly_mm);
      std::vector<Vec3f> points;
      for (const Quad& quad : quads) {
        Vec3f sum{};
        for (const std::int32_t v : quad) sum = sum + person.rest()[static_cast<std::size_t>(v)];
        points.push_back(sum * 0.25F);
      }
      std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
      model.morph({}, mesh);
      maker.run(points, rest_skeleton(model, person.rest()), mesh);
      const MeasurementValues truth = person.truth(), found = measure_rest_mesh(model, mesh, person.gender());
      for (const Measurement id : {Measurement::stature, Measurement::neck_girth, Measurement::chest_girth,
                                   Measurement::waist_girth, Measurement::inside_leg})
        EXPECT_NEAR(found[measurement_index(id)], truth[measurement_index(id)], 6) << static_cast<int>(id);
      const auto leg = measurement_index(Measurement::leg_length);
      EXPECT_NEAR(found[leg], truth[leg], 10);
    }
}
}  // namespace
}  // namespace im2fit::body
