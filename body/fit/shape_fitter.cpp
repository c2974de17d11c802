// SPDX-License-Identifier: Apache-2.0
#include "body/fit/shape_fitter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "body/fit/normal_equations.h"
#include "body/fit/posed_shape.h"
#include "body/fit/sight.h"

namespace im2fit::body {
namespace {

// Steps to the first view alone: some use joints only, then points search their surface further away, then near.
constexpr int kJointSteps = 2, kEarlySteps = 1, kNearSteps = 2;
// Then to both views, from there: what the first one showed of the body puts the second one's pose nearly right.
constexpr int kEarlyStepsTogether = 1, kNearStepsTogether = 1;
constexpr float kGateEarlyMm = 150, kGateMm = 80;
constexpr float kReachEarlyMm = 90, kReachMm = 45;

// Standard deviations: what an equation weighs is 1 / sd^2 (docs/fit.md says where they come from).
constexpr float kJointSdMm = 25;
constexpr float kTurnSd = 0.2F;    // radians, from where the joints put a segment
constexpr float kSpineSd = 0.04F;  // of a trunk that stands: from upright and straight
constexpr float kShiftSdMm = 300;
constexpr float kSurfaceSdMm = 6;  // at kSurfaceAtMm, growing with the square of the distance
constexpr float kSurfaceAtMm = 2400;
constexpr float kRimSdMm = 4;
constexpr float kRimOutlierMm = 12;
constexpr float kSoleSdMm = 6;
constexpr float kCorrelated = 6;  // neighbouring distances err together: each counts for so much less
constexpr float kSurfaceOutlierSds = 3;

// Cosine between a point's normal and the direction to the camera.
constexpr float kFacingMin = 0.35F;     // a surface
constexpr float kRimFacingMax = 0.25F;  // an outline, from either side
constexpr float kSoleDown = -0.8F;      // of a normal's height
constexpr float kSoleHeightMaxMm = 60;

constexpr float kShapeLimit = 5;  // standard deviations
constexpr float kShiftStepMaxMm = 200;
constexpr float kTurnStepMax = 0.35F;
constexpr float kOffLimitMm = 40;     // of a point's part in its patch
constexpr int kSurfaceRowsMin = 100;  // fewer, and the prior speaks rather than the picture

struct Attached {
  Segment segment;
  bool tail;
  Joint joint;
};
constexpr Attached kJoints[] = {
    {Segment::left_upper_arm, false, Joint::LS}, {Segment::right_upper_arm, false, Joint::RS},
    {Segment::left_lower_arm, false, Joint::LE}, {Segment::right_lower_arm, false, Joint::RE},
    {Segment::left_hand, true, Joint::LA},       {Segment::right_hand, true, Joint::RA},
    {Segment::left_upper_leg, false, Joint::LH}, {Segment::right_upper_leg, false, Joint::RH},
    {Segment::left_lower_leg, false, Joint::LK}, {Segment::right_lower_leg, false, Joint::RK},
    {Segment::left_foot, false, Joint::LF},      {Segment::right_foot, false, Joint::RF},
    {Segment::neck, false, Joint::NE},           {Segment::chest, false, Joint::TO}};

// The trunk's segments are the first to turn.
constexpr std::size_t kSpineCount = 3;
static_assert(kTurning[0] == Segment::pelvis && kTurning[1] == Segment::abdomen && kTurning[2] == Segment::chest);

// The spread of a value of a pose's step, from where the pose began. The facing direction comes from the joints.
float pose_sd(std::size_t value, bool straight) {
  constexpr std::size_t kFacing = 3 + 1;  // of the pelvis about the upright axis
  if (value < 3) return kShiftSdMm;
  return straight && value < 3 + 3 * kSpineCount && value != kFacing ? kSpineSd : kTurnSd;
}

// Upright trunk, facing the direction of hips and shoulders. Joints of the trunk err by 15 mm over lengths of 200,
// more than a person standing upright bends, and the lean of a trunk is confounded with its depth. False, and nothing
// done, when the joints give no direction.
bool stand_straight(const JointSet& joints, Pose& pose) {
  Vec3f left = normalized(joints[Joint::LH] - joints[Joint::RH]) + normalized(joints[Joint::LS] - joints[Joint::RS]);
  left.y = 0;
  if (!(norm(left) > 0.1F)) return false;
  left = normalized(left);
  Mat3f facing;
  facing.m = {left.x, 0, -left.z, 0, 1, 0, left.z, 0, left.x};
  for (std::size_t s = 0; s < kSpineCount; ++s) pose.rotation[static_cast<std::size_t>(kTurning[s])] = facing;
  return true;
}

bool is_foot(const SkinRecord& skin) {
  const auto segment = static_cast<Segment>(skin.segment[0]);
  return segment == Segment::left_foot || segment == Segment::right_foot;
}

}  // namespace

class ShapeFitter::Work {
 public:
  explicit Work(const ShapeSpace& space);
  void run(std::span<const FitView> views);
  void points_in_view(std::size_t v, std::span<Vec3f> out);
  PosedSkeleton bones_in_view(std::size_t v);
  ShapeFit first, result;

 private:
  enum class Look { joints, early, near };
  enum class Equation { none, sole, surface, rim };
  struct View {
    Sight sight;
    PosedShape shape;
    Pose pose;
    std::array<float, kPoseValues> moved{};  // from where the pose began
    bool straight = false;                   // it began with a straight trunk
  };
  // An equation to be added: how far the point is to move along `along`. Some wait together while what the slopes are
  // made of comes from memory.
  struct Pending {
    PosedShape::Point point;
    Vec3f along;
    float residual = 0, weight = 0;
  };

  bool see(const FitView& view);
  bool steps(Look look, int count);
  bool step(Look look);
  void look_back();
  void add_prior();
  void add_joints(std::size_t v);
  void add_points(std::size_t v, bool early);
  Equation equation_of(const View& view, bool early, Pending& pending);
  void add_pending(const View& view, const RowColumns& columns);
  void take_step(std::size_t v);
  std::span<const float> shape() const { return {result.shape.data(), space_.shape_count}; }

  const ShapeSpace& space_;
  RestShape rest_;
  NormalEquations equations_;
  std::vector<PointGroup> groups_;
  std::vector<std::uint16_t> patch_;  // of a point
  std::vector<View> views_;
  std::size_t view_count_ = 0;
  std::array<Pending, kRowGroup> pending_;
  std::size_t pending_count_ = 0;
  double surface_sum_ = 0, rim_sum_ = 0;
};

ShapeFitter::Work::Work(const ShapeSpace& space)
    : space_(space),
      rest_(space),
      equations_(kPoseValues, kFitViewMax, space.shape_count),
      groups_(point_groups(space)),
      patch_(skin_patches(space)) {
  for (std::size_t v = 0; v < kFitViewMax; ++v) views_.push_back({{}, PosedShape(space_, rest_), {}, {}, false});
}

// One view more, of the shape as known so far.
bool ShapeFitter::Work::see(const FitView& seen) {
  View& view = views_[view_count_];
  if (!view.sight.look(seen)) return false;
  rest_.set_bones(shape());
  view.pose = pose_from_joints(rest_.skeleton(), view.sight.joints());
  // Without a floor upright is not known.
  view.straight = view.sight.floor_known() && stand_straight(view.sight.joints(), view.pose);
  view.moved = {};
  ++view_count_;
  return true;
}

void ShapeFitter::Work::add_prior() {
  for (std::size_t k = 0; k < space_.shape_count; ++k)
    equations_.add_prior(equations_.shared_at() + k, 1, -static_cast<double>(result.shape[k]));
  for (std::size_t v = 0; v < view_count_; ++v)
    for (std::size_t i = 0; i < kPoseValues; ++i) {
      const auto sd = static_cast<double>(pose_sd(i, views_[v].straight));
      equations_.add_prior(equations_.block_at(v) + i, 1 / (sd * sd), -static_cast<double>(views_[v].moved[i]));
    }
}

void ShapeFitter::Work::add_joints(std::size_t v) {
  const View& view = views_[v];
  constexpr float kWeight = 1 / (kJointSdMm * kJointSdMm);
  for (const Attached& j : kJoints) {
    const RowColumns columns = columns_of(SegmentSet{1} << static_cast<unsigned>(j.segment));
    const Vec3f off =
        view.sight.joints()[j.joint] - (j.tail ? view.shape.tail(j.segment) : view.shape.head(j.segment));
    equations_.begin_rows(v, columns);
    for (const auto& [axis, residual] :
         {std::pair(Vec3f{1, 0, 0}, off.x), {Vec3f{0, 1, 0}, off.y}, {Vec3f{0, 0, 1}, off.z}}) {
      view.shape.bone_row(j.segment, j.tail, axis, columns, equations_.next_row());
      equations_.add_row(residual, kWeight);
    }
    equations_.end_rows();
  }
}

void ShapeFitter::Work::add_points(std::size_t v, bool early) {
  const View& view = views_[v];
  for (const PointGroup& group : groups_) {
    equations_.begin_rows(v, group.columns);
    for (const std::uint32_t i : group.points) {
      Pending& next = pending_[pending_count_];
      view.shape.find(i, next.point);
      if (equation_of(view, early, next) == Equation::none) continue;
      view.shape.prefetch_row(i);
      if (++pending_count_ == pending_.size()) add_pending(view, group.columns);
    }
    add_pending(view, group.columns);
    equations_.end_rows();
  }
}

void ShapeFitter::Work::add_pending(const View& view, const RowColumns& columns) {
  for (const Pending& p : std::span(pending_).first(pending_count_)) {
    view.shape.point_row(p.point, p.along, columns, equations_.next_row());
    equations_.add_row(p.residual, p.weight);
  }
  pending_count_ = 0;
}

// At most one equation a point: a sole stands on the floor, a surface is where it is seen (point to plane, the plane
// being the body's), an outline where the mask ends.
ShapeFitter::Work::Equation ShapeFitter::Work::equation_of(const View& view, bool early, Pending& pending) {
  const Sight& sight = view.sight;
  const Vec3f p = pending.point.position, normal = pending.point.normal;
  if (sight.floor_known() && normal.y < kSoleDown && p.y < kSoleHeightMaxMm &&
      is_foot(space_.skin[pending.point.index])) {
    pending.along = {0, 1, 0};
    pending.residual = -p.y;
    pending.weight = 1 / (kSoleSdMm * kSoleSdMm * kCorrelated);
    return Equation::sole;
  }
  const float facing = dot(normal, normalized(sight.axes().camera() - p));
  if (facing > kFacingMin) {
    const Vec3f camera = sight.axes().to_camera(p);
    Vec3f seen;
    if (!sight.surface_over(camera, early ? kGateEarlyMm : kGateMm, seen)) return Equation::none;
    const float residual = dot(normal, seen - p);
    const float far = camera.z / kSurfaceAtMm;
    const float sd = kSurfaceSdMm * far * far;
    pending.along = normal;
    pending.residual = residual;
    pending.weight = robust_weight(1 / (sd * sd * kCorrelated), residual, kSurfaceOutlierSds * sd);
    ++result.surface_rows;
    surface_sum_ += static_cast<double>(std::fabs(residual));
    return Equation::surface;
  }
  if (!(std::fabs(facing) < kRimFacingMax)) return Equation::none;
  const Vec3f flat = sight.axes().direction_to_camera(normal);
  float residual = 0;
  if (!sight.outline_beside(sight.axes().to_camera(p), flat, early ? kReachEarlyMm : kReachMm, residual))
    return Equation::none;
  const float length = std::sqrt(flat.x * flat.x + flat.y * flat.y);
  pending.along = sight.axes().direction_to_mesh({flat.x / length, flat.y / length, 0});
  pending.residual = residual;
  pending.weight = robust_weight(1 / (kRimSdMm * kRimSdMm * kCorrelated), residual, kRimOutlierMm);
  ++result.rim_rows;
  rim_sum_ += static_cast<double>(std::fabs(residual));
  return Equation::rim;
}

void ShapeFitter::Work::take_step(std::size_t v) {
  View& view = views_[v];
  std::array<float, kPoseValues> step{};
  for (std::size_t i = 0; i < kPoseValues; ++i) {
    const double limit = static_cast<double>(i < 3 ? kShiftStepMaxMm : kTurnStepMax);
    step[i] = static_cast<float>(std::clamp(equations_.step()[equations_.block_at(v) + i], -limit, limit));
    view.moved[i] += step[i];
  }
  move_pose(view.pose, step);
}

bool ShapeFitter::Work::steps(Look look, int count) {
  for (int i = 0; i < count; ++i)
    if (!step(look)) return false;
  return true;
}

// One Gauss-Newton step.
bool ShapeFitter::Work::step(Look look) {
  const bool with_points = look != Look::joints;
  rest_.set_bones(shape());
  if (with_points) rest_.set_points(shape());
  equations_.clear(view_count_);
  result.surface_rows = result.rim_rows = 0;
  surface_sum_ = rim_sum_ = 0;
  add_prior();
  for (std::size_t v = 0; v < view_count_; ++v) {
    views_[v].shape.set(views_[v].pose);
    add_joints(v);
    if (with_points) add_points(v, look == Look::early);
  }
  if (!equations_.solve()) return false;
  for (std::size_t k = 0; k < space_.shape_count; ++k) {
    const double moved = static_cast<double>(result.shape[k]) + equations_.step()[equations_.shared_at() + k];
    result.shape[k] = static_cast<float>(std::clamp<double>(moved, -kShapeLimit, kShapeLimit));
  }
  for (std::size_t v = 0; v < view_count_; ++v) take_step(v);
  return true;
}

// At what the last step made of it.
void ShapeFitter::Work::look_back() {
  rest_.set_bones(shape());
  rest_.set_points(shape());
  result.surface_rows = result.rim_rows = 0;
  surface_sum_ = rim_sum_ = 0;
  for (auto& off : result.off_mm) off.fill(std::numeric_limits<float>::quiet_NaN());
  for (auto& limbs : result.limbs) limbs.fill(std::numeric_limits<float>::quiet_NaN());
  Pending found;
  for (std::size_t v = 0; v < view_count_; ++v) {
    views_[v].shape.set(views_[v].pose);
    result.limbs[v] = limb_axes(views_[v].pose);
    std::array<float, kPatchMax> sum{};
    std::array<int, kPatchMax> count{};
    for (std::size_t i = 0; i < space_.point_count; ++i) {
      views_[v].shape.find(i, found.point);
      if (equation_of(views_[v], false, found) != Equation::surface) continue;
      sum[patch_[i]] += std::clamp(found.residual, -kOffLimitMm, kOffLimitMm);
      ++count[patch_[i]];
    }
    for (std::size_t p = 0; p < kPatchMax; ++p)
      if (count[p] > 0) result.off_mm[v][p] = sum[p] / static_cast<float>(count[p]);
  }
  result.pose = views_[0].pose;
  result.surface_mm = static_cast<float>(surface_sum_ / std::max(result.surface_rows, 1));
  result.rim_mm = static_cast<float>(rim_sum_ / std::max(result.rim_rows, 1));
  result.valid = result.surface_rows >= kSurfaceRowsMin;
}

void ShapeFitter::Work::run(std::span<const FitView> views) {
  first = result = {};
  view_count_ = 0;
  if (views.empty() || !see(views[0]) || !steps(Look::joints, kJointSteps) || !steps(Look::early, kEarlySteps) ||
      !steps(Look::near, kNearSteps)) {
    result = {};
    return;
  }
  look_back();
  first = result;
  if (views.size() == 1) return;
  if (!see(views[1]) || !steps(Look::early, kEarlyStepsTogether) || !steps(Look::near, kNearStepsTogether)) {
    result = {};
    return;
  }
  look_back();
}

void ShapeFitter::Work::points_in_view(std::size_t v, std::span<Vec3f> out) {
  rest_.set_bones(shape());
  rest_.set_points(shape());
  views_[v].shape.set(views_[v].pose);
  PosedShape::Point point;
  for (std::size_t i = 0; i < space_.point_count; ++i) {
    views_[v].shape.find(i, point);
    out[i] = views_[v].sight.axes().to_camera(point.position);
  }
}

PosedSkeleton ShapeFitter::Work::bones_in_view(std::size_t v) {
  rest_.set_bones(shape());
  return pose_skeleton(rest_.skeleton(), views_[v].pose);
}

void fit_values(const ShapeFit& fit, const ShapeSpace& space, std::span<float> out) {
  auto at = std::copy_n(fit.shape.begin(), space.shape_count, out.begin());
  for (const auto& off : fit.off_mm) at = std::copy_n(off.begin(), patch_count(space), at);
  for (const auto& limbs : fit.limbs) at = std::copy(limbs.begin(), limbs.end(), at);
}

ShapeFitter::ShapeFitter(const ShapeSpace& space) : work_(std::make_unique<Work>(space)) {}
ShapeFitter::~ShapeFitter() = default;

const ShapeFit& ShapeFitter::run(std::span<const FitView> views) {
  work_->run(views);
  return work_->result;
}

const ShapeFit& ShapeFitter::first_alone() const {
  return work_->first;
}

PosedSkeleton ShapeFitter::bones_in_view(std::size_t view) {
  return work_->bones_in_view(view);
}

void ShapeFitter::points_in_view(std::size_t view, std::span<Vec3f> out) {
  work_->points_in_view(view, out);
}

}  // namespace im2fit::body
