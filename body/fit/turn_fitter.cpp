// SPDX-License-Identifier: Apache-2.0
#include "body/fit/turn_fitter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "body/fit/normal_equations.h"
#include "body/fit/posed_shape.h"
#include "body/fit/skin_bumps.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kSegments = static_cast<std::size_t>(kSegmentCount);
constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Standard deviations, and the gates below: of the prototype (docs/fit.md).
constexpr float kSurfaceSdMm = 7;  // at kSurfaceAtMm, growing with the square of the distance
constexpr float kSurfaceAtMm = 2400;
constexpr float kSurfaceOutlierMm = 18;
constexpr float kRimSdMm = 9;
constexpr float kRimOutlierMm = 10;
constexpr float kCorrelated = 4;  // neighbouring distances err together: each counts for so much less
constexpr float kSoleSdMm = 8;
constexpr float kSoleCount = 3;  // a foot's sole counts as so many equations
constexpr float kUprightSd = 0.07F;
constexpr float kFollowedSd = 0.08F;  // of a turn, from the picture before
constexpr float kOwnShare = 0.5F;     // of the pose before the fit in the mean of poses
constexpr double kHeldPrior = 1e8;    // of an unknown that a step leaves alone
constexpr double kLeastPrior = 1e-6;

// Cosine between a point's normal and the direction to the camera.
constexpr float kFacingMin = 0.45F;
constexpr float kRimFacingMax = 0.22F;
constexpr float kFieldFacingMin = 0.5F;
constexpr float kSoleDown = -0.8F;
constexpr float kSoleHeightMaxMm = 60;

constexpr float kShapeLimit = 5;
constexpr float kShiftStepMaxMm = 200;
constexpr float kTurnStepMax = 0.3F;
constexpr int kRowsMin = 40;            // of each view
constexpr std::size_t kFollowEach = 2;  // every second point is enough for a pose

// Gates of the steps, mm: how far a surface may lie from the point it belongs to.
constexpr std::array<float, 3> kFollowGatesMm = {100, 60, 45};
constexpr std::array<float, 9> kJointGatesMm = {90, 90, 60, 60, 60, 40, 40, 40, 40};
constexpr std::size_t kStepsWithoutBumps = 3;
constexpr std::array<float, 2> kAgainGatesMm = {30, 30};
constexpr float kFieldGateMm = 30;
constexpr float kReachOfGate = 0.7F;  // how far an outline is looked for, of the gate for surfaces
constexpr float kTurnOnShare = 0.7F, kShiftOnShare = 0.5F;  // of the last step, carried on

constexpr float kFieldOutlierMm = 8;
constexpr float kFieldSaturation = 0.05F;
constexpr float kFieldSmooth = 100;  // mm^2, times 1 / length^2 of an edge
constexpr float kFieldLeast = 0.02F;
constexpr int kFieldSweeps = 40;
constexpr float kFieldLimitMm = 60;

// Of a segment's turn against its parent, from the mean of all views, radians.
constexpr float pose_sd(Segment s) {
  switch (s) {
    case Segment::abdomen:
    case Segment::chest:
      return 0.04F;
    case Segment::left_shoulder:
    case Segment::right_shoulder:
      return 0.06F;
    case Segment::left_upper_arm:
    case Segment::right_upper_arm:
    case Segment::left_upper_leg:
    case Segment::right_upper_leg:
      return 0.2F;
    default:
      return 0.12F;
  }
}

bool is_foot(const SkinRecord& skin, Segment foot) {
  return static_cast<Segment>(skin.segment[0]) == foot;
}

Mat3f local_of(const Pose& pose, std::size_t s) {
  const int parent = kSegmentParent[s];
  return parent < 0 ? pose.rotation[s]
                    : transpose(pose.rotation[static_cast<std::size_t>(parent)]) * pose.rotation[s];
}

// The axis of a small rotation, times the sine of its angle.
Vec3f turn_of(const Mat3f& r) {
  return {0.5F * (r.m[7] - r.m[5]), 0.5F * (r.m[2] - r.m[6]), 0.5F * (r.m[3] - r.m[1])};
}

// The rotation nearest to a sum of alike rotations: the Newton-Schulz iteration for the polar decomposition, which
// converges for all that are not near a half turn apart.
Mat3f nearest_rotation(Mat3f a, float count) {
  for (float& v : a.m) v /= count;
  for (int i = 0; i < 12; ++i) {
    const Mat3f square = transpose(a) * a;
    Mat3f step = square;
    for (float& v : step.m) v *= -0.5F;
    for (const std::size_t d : {0U, 4U, 8U}) step.m[d] += 1.5F;
    a = a * step;
  }
  return a;
}

// asin(x) for |x| <= 1 in degrees, to 0.01 in the range of a step (its series).
float arc_deg(float x) {
  const float x2 = x * x;
  return x * (1 + x2 * (1.0F / 6 + x2 * (3.0F / 40 + x2 * (15.0F / 336)))) * 57.29578F;
}

// From one direction on the floor to another, both unit: + from z to x. A wide turn, as of a camera whose pictures
// could not be followed for a while, is a multiple of the turn to a direction between.
float turn_deg(Vec3f from, Vec3f to) {
  float parts = 1;
  while (dot(from, to) < 0.8F && parts < 4) {
    const Vec3f middle = from + to;
    to = dot(middle, middle) > 1e-6F ? normalized(middle) : Vec3f{from.z, 0, -from.x};
    parts *= 2;
  }
  return parts * arc_deg(std::clamp(from.z * to.x - from.x * to.z, -1.0F, 1.0F));
}

Vec3f vec3(Four v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

class TurnFitter::Work {
 public:
  explicit Work(const ShapeSpace& space);
  void begin(std::span<const float> shape, const Pose& pose, const PersonAxes& axes, bool floor);
  bool follow(const TurnPicture& picture);
  void run(std::span<const TurnView> views);

  TurnFit result;
  Pose pose;
  float turned_deg = 0;

 private:
  struct View {
    const TurnPicture* picture = nullptr;
    Pose pose;
  };
  struct Look {
    float gate_mm = 0;
    std::size_t each = 1;  // of the points
    bool bumps = false;    // else they stay
    bool shape = false;    // else the pose alone
  };

  void restore();
  void set_shape();
  const PersonAxes& axes_of(const TurnPicture& picture) const { return picture.axes ? *picture.axes : axes_; }
  void see(const View& view) { points_.see(view.pose, view.picture->intrinsics, axes_of(*view.picture)); }
  void add_view(std::size_t v, const Look& look, NormalEquations& equations);
  void add_points(std::size_t v, const Look& look, NormalEquations& equations);
  void add_soles(std::size_t v, const Look& look, NormalEquations& equations);
  void put_row(std::size_t i, Vec3f along, const RowColumns& columns, bool with_shape, std::span<float> row);
  void add_pose_prior(std::size_t v, const Pose& to, NormalEquations& equations, float sd);
  void add_upright_prior(std::size_t v, NormalEquations& equations);
  bool step(const Look& look, const Pose* before);
  void take_step(View& view, std::span<const double> moved);
  Pose mean_pose() const;
  void add_field();
  bool fit();
  void finish();

  const ShapeSpace& space_;
  SkinBumps bumps_;
  SkinGraph graph_;
  RestShape rest_;
  NormalEquations joint_, pose_only_;
  std::vector<PointGroup> groups_;
  std::array<View, kTurnViewMax> views_;
  std::size_t view_count_ = 0;
  PersonAxes axes_;
  bool floor_ = false;
  Pose reference_, before_;
  Vec3f camera_;                          // the direction to it at the picture followed last, on the floor
  std::array<float, kShapeMax> begun_{};  // the shape that begin() was given
  std::vector<float> bump_, field_mm_, move_mm_;

  TurnPoints points_;  // of the view seen last
  int surface_rows_ = 0;

  // Of the field.
  struct Seen {
    float off = 0, weight = 0;
  };
  std::vector<std::array<Seen, kTurnViewMax>> seen_;
  std::vector<std::uint8_t> seen_count_;
  std::vector<float> pull_, want_, field_step_;
};

TurnFitter::Work::Work(const ShapeSpace& space)
    : space_(space),
      bumps_(space),
      graph_(space, bumps_.normal),
      rest_(space),
      joint_(kPoseValues, kTurnViewMax, space.shape_count + bumps_.count),
      pose_only_(kPoseValues, 1, 0),
      groups_(point_groups(space)),
      bump_(bumps_.count),
      field_mm_(space.point_count),
      move_mm_(space.point_count),
      points_(space, rest_, graph_),
      seen_(space.point_count),
      seen_count_(space.point_count),
      pull_(space.point_count),
      want_(space.point_count),
      field_step_(space.point_count) {
  result.points.resize(space.point_count);
}

void TurnFitter::Work::begin(std::span<const float> shape, const Pose& start, const PersonAxes& axes, bool floor) {
  result.valid = false;
  begun_ = {};
  std::copy_n(shape.begin(), std::min(shape.size(), space_.shape_count), begun_.begin());
  pose = before_ = reference_ = start;
  axes_ = axes;
  floor_ = floor;
  turned_deg = 0;
  camera_ = normalized(Vec3f{axes.camera().x, 0, axes.camera().z});
  restore();
}

// What follow() goes on from.
void TurnFitter::Work::restore() {
  result.shape = begun_;
  std::fill(bump_.begin(), bump_.end(), 0.0F);
  std::fill(field_mm_.begin(), field_mm_.end(), 0.0F);
  set_shape();
}

void TurnFitter::Work::set_shape() {
  const std::span<const float> shape(result.shape.data(), space_.shape_count);
  rest_.set_bones(shape);
  rest_.set_points(shape);
  for (std::size_t i = 0; i < space_.point_count; ++i) {
    float mm = field_mm_[i];
    const float* move = bumps_.move.data() + i * bumps_.count;
    for (std::size_t k = 0; k < bumps_.count; ++k) mm += move[k] * bump_[k];
    move_mm_[i] = mm;
  }
  rest_.move_points(move_mm_, bumps_.normal);
}

void TurnFitter::Work::put_row(std::size_t i, Vec3f along, const RowColumns& columns, bool with_shape,
                               std::span<float> row) {
  const PosedShape::Point& point = points_.at(i);
  if (!with_shape) {
    points_.posed().pose_row(point, along, columns, row);
    return;
  }
  points_.posed().point_row(point, along, columns, row);
  float* bump = row.data() + 3 * columns.triple_count + space_.shape_count;
  const Vec3f back{dot(vec3(point.turn[0]), along), dot(vec3(point.turn[1]), along), dot(vec3(point.turn[2]), along)};
  const float slope = dot(back, bumps_.normal[i]);
  const float* move = bumps_.move.data() + i * bumps_.count;
  for (std::size_t k = 0; k < bumps_.count; ++k) bump[k] = slope * move[k];
}

void TurnFitter::Work::add_points(std::size_t v, const Look& look, NormalEquations& equations) {
  const TurnSight sight(*views_[v].picture);
  const PersonAxes& axes = axes_of(*views_[v].picture);
  for (const PointGroup& group : groups_) {
    equations.begin_rows(v, group.columns);
    for (const std::uint32_t i : group.points) {
      if (i % look.each != 0) continue;
      const Vec3f c = points_.in_camera(i), n = axes.direction_to_camera(points_.at(i).normal);
      float off = 0, weight = 0;
      Vec3f along = points_.at(i).normal;
      if (points_.facing(i) > kFacingMin) {
        if (points_.hidden(i) || !sight.surface_over(c, n, look.gate_mm, off)) continue;
        const float far = c.z / kSurfaceAtMm, sd = kSurfaceSdMm * far * far;
        weight = robust_weight(1 / (sd * sd * kCorrelated), off, kSurfaceOutlierMm);
        ++surface_rows_;
      } else if (std::fabs(points_.facing(i)) < kRimFacingMax) {
        Vec3f direction;
        if (points_.hidden(i) || !sight.outline_beside(c, n, look.gate_mm * kReachOfGate, off, direction)) continue;
        off -= points_.beyond_mm(i);
        along = axes.direction_to_mesh(direction);
        weight = robust_weight(1 / (kRimSdMm * kRimSdMm * kCorrelated), off, kRimOutlierMm);
      } else {
        continue;
      }
      put_row(i, along, group.columns, look.shape, equations.next_row());
      equations.add_row(off, weight);
    }
    equations.end_rows();
  }
}

// The lower foot stands on the floor; the other may be lifted.
void TurnFitter::Work::add_soles(std::size_t v, const Look& look, NormalEquations& equations) {
  if (!floor_) return;
  std::array<float, 2> height{};
  std::array<int, 2> count{};
  const auto sole = [&](std::size_t i) {
    return points_.at(i).normal.y < kSoleDown && points_.at(i).position.y < kSoleHeightMaxMm;
  };
  const auto foot = [](std::size_t side) { return side == 0 ? Segment::left_foot : Segment::right_foot; };
  for (std::size_t i = 0; i < space_.point_count; ++i)
    for (std::size_t side = 0; side < 2; ++side)
      if (is_foot(space_.skin[i], foot(side)) && sole(i)) {
        height[side] += points_.at(i).position.y;
        ++count[side];
      }
  if (count[0] + count[1] == 0) return;
  const auto mean = [&](std::size_t side) { return height[side] / static_cast<float>(count[side]); };
  const std::size_t low = count[0] == 0 || (count[1] > 0 && mean(1) < mean(0)) ? 1 : 0;
  const float weight = kSoleCount / (kSoleSdMm * kSoleSdMm * static_cast<float>(count[low]));
  for (const PointGroup& group : groups_) {
    equations.begin_rows(v, group.columns);
    for (const std::uint32_t i : group.points) {
      if (!is_foot(space_.skin[i], foot(low)) || !sole(i)) continue;
      put_row(i, {0, 1, 0}, group.columns, look.shape, equations.next_row());
      equations.add_row(-points_.at(i).position.y, weight);
    }
    equations.end_rows();
  }
}

// `sd` 0: each segment's own.
void TurnFitter::Work::add_pose_prior(std::size_t v, const Pose& to, NormalEquations& equations, float sd) {
  const Pose& own = views_[v].pose;
  const std::size_t block = equations.block_at(v);
  for (std::size_t t = 1; t < kTurning.size(); ++t) {
    const std::size_t s = at(kTurning[t]);
    const auto parent = static_cast<std::size_t>(kSegmentParent[s]);
    const Vec3f off = own.rotation[parent] * turn_of(local_of(own, s) * transpose(local_of(to, s)));
    const float spread = sd > 0 ? sd : pose_sd(kTurning[t]);
    const auto weight = static_cast<double>(1 / (spread * spread));
    equations.add_prior(block + 3 + 3 * t, weight, -static_cast<double>(off.x));
    equations.add_prior(block + 4 + 3 * t, weight, -static_cast<double>(off.y));
    equations.add_prior(block + 5 + 3 * t, weight, -static_cast<double>(off.z));
  }
}

void TurnFitter::Work::add_upright_prior(std::size_t v, NormalEquations& equations) {
  const std::size_t block = equations.block_at(v);
  const Mat3f& pelvis = views_[v].pose.rotation[at(Segment::pelvis)];
  const Vec3f off = cross(Vec3f{0, 1, 0}, Vec3f{pelvis.m[1], pelvis.m[4], pelvis.m[7]});
  constexpr auto kWeight = static_cast<double>(1 / (kUprightSd * kUprightSd));
  equations.add_prior(block + 3, kWeight, -static_cast<double>(off.x));
  equations.add_prior(block + 5, kWeight, -static_cast<double>(off.z));
  for (std::size_t i = 0; i < kPoseValues; ++i) equations.add_prior(block + i, kLeastPrior, 0);
}

// Of each segment against its parent, the pelvis aside.
Pose TurnFitter::Work::mean_pose() const {
  std::array<Mat3f, kSegments> mean;
  for (std::size_t s = 0; s < kSegments; ++s) {
    Mat3f sum = local_of(reference_, s);
    for (float& m : sum.m) m *= kOwnShare;
    for (std::size_t v = 0; v < view_count_; ++v) {
      const Mat3f own = local_of(views_[v].pose, s);
      for (std::size_t i = 0; i < sum.m.size(); ++i) sum.m[i] += own.m[i];
    }
    mean[s] = s == at(Segment::pelvis) ? reference_.rotation[s]
                                       : nearest_rotation(sum, static_cast<float>(view_count_) + kOwnShare);
  }
  return pose_from_local(mean);
}

void TurnFitter::Work::add_view(std::size_t v, const Look& look, NormalEquations& equations) {
  see(views_[v]);
  add_points(v, look, equations);
  add_soles(v, look, equations);
  add_upright_prior(v, equations);
}

void TurnFitter::Work::take_step(View& view, std::span<const double> moved) {
  std::array<float, kPoseValues> step{};
  for (std::size_t i = 0; i < 3; ++i)
    step[i] = static_cast<float>(std::clamp<double>(moved[i], -kShiftStepMaxMm, kShiftStepMaxMm));
  for (std::size_t t = 0; t < kTurning.size(); ++t) {
    Vec3f w{static_cast<float>(moved[3 + 3 * t]), static_cast<float>(moved[4 + 3 * t]),
            static_cast<float>(moved[5 + 3 * t])};
    const float length = norm(w);
    if (length > kTurnStepMax) w = w * (kTurnStepMax / length);
    step[3 + 3 * t] = w.x;
    step[4 + 3 * t] = w.y;
    step[5 + 3 * t] = w.z;
  }
  move_pose(view.pose, step);
}

// One Gauss-Newton step of all views; with `before` of the pose of the only view, near that one.
bool TurnFitter::Work::step(const Look& look, const Pose* before) {
  NormalEquations& equations = look.shape ? joint_ : pose_only_;
  equations.clear(view_count_);
  surface_rows_ = 0;
  const Pose mean = before != nullptr ? reference_ : mean_pose();
  for (std::size_t v = 0; v < view_count_; ++v) {
    const int rows_before = surface_rows_;
    add_view(v, look, equations);
    if (surface_rows_ - rows_before < kRowsMin) return false;
    add_pose_prior(v, mean, equations, 0);
    if (before != nullptr) add_pose_prior(v, *before, equations, kFollowedSd);
  }
  const std::size_t shared = equations.shared_at();
  if (look.shape) {
    for (std::size_t k = 0; k < space_.shape_count; ++k)
      equations.add_prior(shared + k, 1, -static_cast<double>(result.shape[k]));
    for (std::size_t k = 0; k < bumps_.count; ++k) {
      equations.add_prior(shared + space_.shape_count + k, 1, -static_cast<double>(bump_[k]));
      if (!look.bumps) equations.add_prior(shared + space_.shape_count + k, kHeldPrior, 0);
    }
  }
  if (!equations.solve()) return false;
  const auto moved = equations.step();
  if (look.shape) {
    const auto move = [&](float& value, double by) {
      value = static_cast<float>(std::clamp<double>(static_cast<double>(value) + by, -kShapeLimit, kShapeLimit));
    };
    for (std::size_t k = 0; k < space_.shape_count; ++k) move(result.shape[k], moved[shared + k]);
    for (std::size_t k = 0; k < bumps_.count; ++k) move(bump_[k], moved[shared + space_.shape_count + k]);
  }
  for (std::size_t v = 0; v < view_count_; ++v)
    take_step(views_[v], moved.subspan(equations.block_at(v), kPoseValues));
  if (look.shape) set_shape();
  return true;
}

bool TurnFitter::Work::follow(const TurnPicture& picture) {
  if (!usable(picture)) return false;
  const Mat3f turned = pose.rotation[0] * transpose(before_.rotation[0]);
  Vec3f on = turn_of(turned) * kTurnOnShare;
  const Vec3f shift = (pose.translation_mm - before_.translation_mm) * kShiftOnShare;
  View& view = views_[0];
  view_count_ = 1;
  view.picture = &picture;
  view.pose = pose;
  const std::array<double, 6> start = {static_cast<double>(shift.x), static_cast<double>(shift.y),
                                       static_cast<double>(shift.z), static_cast<double>(on.x),
                                       static_cast<double>(on.y),    static_cast<double>(on.z)};
  std::array<double, kPoseValues> moved{};
  std::copy(start.begin(), start.end(), moved.begin());
  take_step(view, moved);
  const Pose guess = view.pose;
  for (const float gate : kFollowGatesMm)
    if (!step({gate, kFollowEach, false, false}, &guess)) return false;
  before_ = pose;
  pose = view.pose;
  // The pelvis' front, before and after, on the floor.
  const auto front = [](const Pose& p) { return normalized(Vec3f{p.rotation[0].m[2], 0, p.rotation[0].m[8]}); };
  const Vec3f a = front(before_), b = front(pose);
  // A camera that goes round to the person's left sees them turn to the right.
  const Vec3f place = axes_of(picture).camera(), beside = normalized(Vec3f{place.x, 0, place.z});
  turned_deg += turn_deg(a, b) - turn_deg(camera_, beside);
  camera_ = beside;
  return true;
}

// What the pictures show beyond the fitted skin: of each point the robust mean of the views that see it, smoothed
// over its neighbours.
void TurnFitter::Work::add_field() {
  std::fill(seen_count_.begin(), seen_count_.end(), std::uint8_t{0});
  for (std::size_t v = 0; v < view_count_; ++v) {
    see(views_[v]);
    const TurnSight sight(*views_[v].picture);
    for (std::size_t i = 0; i < space_.point_count; ++i) {
      float off = 0;
      if (!(points_.facing(i) > kFieldFacingMin) || points_.hidden(i) ||
          !sight.surface_over(points_.in_camera(i),
                              axes_of(*views_[v].picture).direction_to_camera(points_.at(i).normal), kFieldGateMm,
                              off))
        continue;
      seen_[i][seen_count_[i]++] = {off, points_.facing(i) * points_.facing(i)};
    }
  }
  for (std::size_t i = 0; i < space_.point_count; ++i) {
    const std::span<Seen> seen(seen_[i].data(), seen_count_[i]);
    pull_[i] = want_[i] = field_step_[i] = 0;
    if (seen.empty()) continue;
    std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.off < b.off; });
    const float median = seen[seen.size() / 2].off;
    float weight = 0, sum = 0;
    for (const Seen& s : seen) {
      const float out = (s.off - median) / kFieldOutlierMm, w = s.weight / (1 + out * out);
      weight += w;
      sum += w * s.off;
    }
    pull_[i] = weight / (1 + kFieldSaturation * weight);
    want_[i] = sum / weight;
  }
  for (int sweep = 0; sweep < kFieldSweeps; ++sweep)
    for (std::size_t i = 0; i < space_.point_count; ++i) {
      float sum = pull_[i] * want_[i], weight = pull_[i] + kFieldLeast;
      for (std::size_t k = 0; k < kSkinNeighbours; ++k) {
        const SkinNeighbour& n = graph_.neighbours[i * kSkinNeighbours + k];
        if (!(n.distance_mm > 0)) break;
        const float w = kFieldSmooth / (n.distance_mm * n.distance_mm);
        sum += w * field_step_[n.point];
        weight += w;
      }
      field_step_[i] = sum / weight;
    }
  for (std::size_t i = 0; i < space_.point_count; ++i)
    field_mm_[i] = std::clamp(field_mm_[i] + field_step_[i], -kFieldLimitMm, kFieldLimitMm);
  set_shape();
}

void TurnFitter::Work::finish() {
  for (std::size_t i = 0; i < space_.point_count; ++i) result.points[i] = rest_.middle(i);
  result.bones = rest_.skeleton();
  rest_.set_points(std::span(result.shape).first(space_.shape_count));
  result.beyond_mm = {};
  for (std::size_t i = 0, kept = 0; i < space_.point_count && kept < kSeenPointMax; i += kSeenEach, ++kept)
    result.beyond_mm[kept] = dot(normalized(rest_.normal(i)), result.points[i] - rest_.middle(i));
  set_shape();
  for (std::size_t v = 0; v < view_count_; ++v) {
    result.poses[v] = views_[v].pose;
    see(views_[v]);
    const TurnSight sight(*views_[v].picture);
    double sum = 0;
    int rows = 0;
    for (std::size_t i = 0; i < space_.point_count; ++i) {
      float off = 0;
      if (!(points_.facing(i) > kFacingMin) || points_.hidden(i) ||
          !sight.surface_over(points_.in_camera(i),
                              axes_of(*views_[v].picture).direction_to_camera(points_.at(i).normal), kFieldGateMm,
                              off))
        continue;
      sum += static_cast<double>(std::fabs(off));
      ++rows;
    }
    result.surface_mm[v] = static_cast<float>(sum / std::max(rows, 1));
  }
  result.valid = true;
}

bool TurnFitter::Work::fit() {
  for (std::size_t i = 0; i < kJointGatesMm.size(); ++i)
    if (!step({kJointGatesMm[i], 1, i >= kStepsWithoutBumps, true}, nullptr)) return false;
  add_field();
  for (const float gate : kAgainGatesMm)
    if (!step({gate, 1, true, true}, nullptr)) return false;
  return true;
}

void TurnFitter::Work::run(std::span<const TurnView> views) {
  result.valid = false;
  view_count_ = 0;
  for (const TurnView& view : views.first(std::min(views.size(), kTurnViewMax))) {
    if (!usable(view.picture)) return;
    views_[view_count_++] = {&view.picture, view.pose};
  }
  if (view_count_ == 0) return;
  restore();
  std::array<float, kShapeMax> found = begun_;
  if (fit()) {
    finish();
    found = result.shape;
  }
  restore();
  result.shape = found;
}

SeenBody seen_body(const TurnFit& fit) {
  return {fit.valid, true, true, fit.shape, fit.poses[0], fit.beyond_mm};
}

TurnFitter::TurnFitter(const ShapeSpace& space) : work_(std::make_unique<Work>(space)) {}
TurnFitter::~TurnFitter() = default;

void TurnFitter::begin(std::span<const float> shape, const Pose& pose, const PersonAxes& axes, bool floor) {
  work_->begin(shape, pose, axes, floor);
}
bool TurnFitter::follow(const TurnPicture& picture) {
  return work_->follow(picture);
}
const Pose& TurnFitter::pose() const {
  return work_->pose;
}
float TurnFitter::turned_deg() const {
  return work_->turned_deg;
}
const TurnFit& TurnFitter::run(std::span<const TurnView> views) {
  work_->run(views);
  return work_->result;
}

}  // namespace im2fit::body
