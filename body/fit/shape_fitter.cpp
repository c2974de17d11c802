// SPDX-License-Identifier: Apache-2.0
#include "body/fit/shape_fitter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "body/skeleton.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kSegments = static_cast<std::size_t>(kSegmentCount);

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Segments that turn by themselves; head and hands follow.
constexpr std::array<Segment, 16> kTurning = {
    Segment::pelvis,          Segment::abdomen,         Segment::chest,           Segment::neck,
    Segment::left_shoulder,   Segment::left_upper_arm,  Segment::left_lower_arm,  Segment::right_shoulder,
    Segment::right_upper_arm, Segment::right_lower_arm, Segment::left_upper_leg,  Segment::left_lower_leg,
    Segment::left_foot,       Segment::right_upper_leg, Segment::right_lower_leg, Segment::right_foot};
constexpr std::size_t kPoseValues = 3 + 3 * kTurning.size();
constexpr std::size_t kUnknownMax = kShapeMax + kFitViewMax * kPoseValues;

constexpr int kIterations = 8;
constexpr int kJointIterations = 2;  // the first ones look at joints alone
constexpr float kJointSdMm = 25;
constexpr float kTurnSd = 0.2F;  // radians, from where the joints put a segment
constexpr float kShiftSdMm = 300;
constexpr float kSurfaceSdMm = 6;  // at kSurfaceAtMm, growing with the square of the distance
constexpr float kSurfaceAtMm = 2400;
constexpr float kRimSdMm = 4;
constexpr float kSoleSdMm = 6;
constexpr float kCorrelated = 6;  // neighbouring distances err together: each counts for so much less
constexpr float kFacingMin = 0.35F;
constexpr float kRimFacingMax = 0.25F;

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

Vec3f half_turn(Vec3f v) {
  return {v.x, -v.y, -v.z};
}

// The rotation by about |w| about w, for small w: a normalised quaternion.
Mat3f small_rotation(Vec3f w) {
  const float s = 1 / std::sqrt(1 + 0.25F * dot(w, w));
  const float q = s, x = 0.5F * s * w.x, y = 0.5F * s * w.y, z = 0.5F * s * w.z;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - q * z), 2 * (x * z + q * y), 2 * (x * y + q * z),
           1 - 2 * (x * x + z * z), 2 * (y * z - q * x), 2 * (x * z - q * y), 2 * (y * z + q * x),
           1 - 2 * (x * x + y * y)}};
}

Vec3f transposed_times(const Mat3f& a, Vec3f v) {
  return {a.m[0] * v.x + a.m[3] * v.y + a.m[6] * v.z, a.m[1] * v.x + a.m[4] * v.y + a.m[7] * v.z,
          a.m[2] * v.x + a.m[5] * v.y + a.m[8] * v.z};
}

Vec3f at3(const std::vector<float>& values, std::size_t i) {
  return {values[i], values[i + 1], values[i + 2]};
}

// Where the camera stands in the levelled frame of the person: y up from the floor, z towards the camera.
struct Placement {
  Mat3f level;
  Vec3f shift;
  Vec3f to_world(Vec3f camera) const { return level * half_turn(camera) + shift; }
  Vec3f to_camera(Vec3f world) const { return half_turn(transposed_times(level, world - shift)); }
  Vec3f direction_to_world(Vec3f camera) const { return level * half_turn(camera); }
};

// Lower triangle of the normal equations.
struct Normal {
  std::vector<double> a, b;
  std::size_t n = 0;
  void clear(std::size_t size) {
    n = size;
    std::fill_n(a.begin(), n * n, 0.0);
    std::fill_n(b.begin(), n, 0.0);
  }
};

// One equation: which unknowns it knows, and how they move it.
struct Row {
  std::array<std::uint16_t, kUnknownMax> index{};
  std::array<float, kUnknownMax> slope{};
  std::size_t count = 0;
};

}  // namespace

class ShapeFitter::Work {
 public:
  explicit Work(const ShapeSpace& space)
      : space_(space),
        values_(space.point_count * kPointValues),
        bones_(kBoneValues),
        bone_moves_(kFitViewMax * kSegments * 3 * space.shape_count),
        head_moves_(kSegments * 3 * space.shape_count) {
    normal_.a.resize(kUnknownMax * kUnknownMax);
    normal_.b.resize(kUnknownMax);
    for (std::size_t s = 0; s < kSegments; ++s)
      for (std::size_t d = s;; d = static_cast<std::size_t>(kSegmentParent[d])) {
        under_[d] |= 1U << s;
        if (kSegmentParent[d] < 0) break;
      }
  }
  ShapeFit result;
  void run(std::span<const FitView> views);

 private:
  struct View {
    const FitView* seen = nullptr;
    Placement place;
    JointSet joints;  // levelled
    Pose pose;
    std::array<float, kPoseValues> moved{};  // from the start
    PosedSkeleton posed;
    std::array<Vec3f, kSegments> offset;  // of a segment: where it takes the origin
  };

  void start(const FitView& seen, View& view);
  void shape_values();
  Skeleton skeleton() const;
  void pose_view(View& view);
  void bone_derivatives(const View& view, std::size_t v);
  void add_prior();
  void add_joints(const View& view, std::size_t v);
  void add_points(const View& view, std::size_t v, int iteration);
  void add_row(const Row& row, float residual, float weight);
  void attached_row(const View& view, std::size_t v, std::size_t bone, Vec3f p, std::size_t value, Vec3f along,
                    Row& row) const;
  void point_row(const View& view, std::size_t v, std::size_t point, const Mat3f& turn, Vec3f along, Row& row) const;
  void turn_slopes(const View& view, std::size_t v, std::uint32_t segments, const auto& part, Vec3f along,
                   Row& row) const;
  bool solve();
  void move(std::size_t view_count);
  float rim_distance(const View& view, Vec3f camera, Vec3f normal_camera, float reach_mm, bool& found) const;

  const ShapeSpace& space_;
  std::array<std::uint32_t, kSegments> under_{};  // bit s: segment s hangs on this one (itself included)
  std::vector<float> values_;                     // points of the present shape
  std::vector<float> bones_;
  std::array<View, kFitViewMax> views_;
  std::size_t view_count_ = 0;
  std::vector<float> bone_moves_;  // view x segment x 3 x shape: of a segment's offset
  std::vector<float> head_moves_;
  Normal normal_;
  std::array<double, kUnknownMax> step_{};
  double surface_sum_ = 0, rim_sum_ = 0;
};

void ShapeFitter::Work::shape_values() {
  const std::size_t k = space_.shape_count;
  const auto apply = [&](const std::vector<float>& mean, const std::vector<float>& basis, std::vector<float>& out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const float* row = basis.data() + i * k;
      std::array<float, 4> sum = {mean[i], 0, 0, 0};
      std::size_t j = 0;
      for (; j + 4 <= k; j += 4)
        for (std::size_t l = 0; l < 4; ++l) sum[l] += row[j + l] * result.shape[j + l];
      for (; j < k; ++j) sum[0] += row[j] * result.shape[j];
      out[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
  };
  apply(space_.point_mean, space_.point_basis, values_);
  apply(space_.bone_mean, space_.bone_basis, bones_);
}

Skeleton ShapeFitter::Work::skeleton() const {
  Skeleton s;
  for (std::size_t i = 0; i < kSegments; ++i) {
    s.head[i] = at3(bones_, 3 * i);
    s.tail[i] = at3(bones_, 3 * (kSegments + i));
  }
  return s;
}

void ShapeFitter::Work::start(const FitView& seen, View& view) {
  view.seen = &seen;
  view.place = {};
  if (seen.floor.known) view.place.level = rotation_between(half_turn(seen.floor.up), {0, 1, 0});
  JointSet joints = seen.joints;
  for (Vec3f& p : joints.position_mm) p = view.place.level * half_turn(p);
  view.place.shift = (joints[Joint::LH] + joints[Joint::RH]) * -0.5F;
  if (seen.floor.known) view.place.shift.y = seen.floor.camera_height_mm;
  for (Vec3f& p : joints.position_mm) p = p + view.place.shift;
  view.joints = joints;
  view.pose = pose_from_joints(skeleton(), joints);
  view.moved = {};
}

void ShapeFitter::Work::pose_view(View& view) {
  const Skeleton rest = skeleton();
  view.posed = pose_skeleton(rest, view.pose);
  for (std::size_t s = 0; s < kSegments; ++s)
    view.offset[s] = view.posed.head[s] - view.pose.rotation[s] * rest.head[s];
}

// How a segment's offset moves with each coefficient: the movement of its posed head less its turned rest head's.
void ShapeFitter::Work::bone_derivatives(const View& view, std::size_t v) {
  const std::size_t k = space_.shape_count;
  const auto rest = [&](std::size_t s, std::size_t axis) { return space_.bone_basis.data() + (3 * s + axis) * k; };
  for (std::size_t s = 0; s < kSegments; ++s) {
    const int parent = kSegmentParent[s];
    float* head = head_moves_.data() + s * 3 * k;
    float* move = bone_moves_.data() + ((v * kSegments + s) * 3) * k;
    const auto& own = view.pose.rotation[s].m;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t j = 0; j < k; ++j) {
        float h = rest(s, axis)[j];
        if (parent >= 0) {
          const auto p = static_cast<std::size_t>(parent);
          const auto& m = view.pose.rotation[p].m;
          h = head_moves_[(p * 3 + axis) * k + j];
          for (std::size_t a = 0; a < 3; ++a) h += m[3 * axis + a] * (rest(s, a)[j] - rest(p, a)[j]);
        }
        head[axis * k + j] = h;
        move[axis * k + j] = h - (own[3 * axis] * rest(s, 0)[j] + own[3 * axis + 1] * rest(s, 1)[j] +
                                  own[3 * axis + 2] * rest(s, 2)[j]);
      }
  }
}

void ShapeFitter::Work::add_row(const Row& row, float residual, float weight) {
  const double w = static_cast<double>(weight);
  const std::size_t n = normal_.n;
  for (std::size_t i = 0; i < row.count; ++i) {
    const double wi = w * static_cast<double>(row.slope[i]);
    double* a = normal_.a.data() + row.index[i] * n;
    for (std::size_t j = 0; j <= i; ++j) a[row.index[j]] += wi * static_cast<double>(row.slope[j]);
    normal_.b[row.index[i]] += wi * static_cast<double>(residual);
  }
}

void ShapeFitter::Work::add_prior() {
  const std::size_t n = normal_.n, k = space_.shape_count;
  for (std::size_t j = 0; j < k; ++j) {
    normal_.a[j * n + j] += 1;
    normal_.b[j] -= static_cast<double>(result.shape[j]);
  }
  for (std::size_t v = 0; v < view_count_; ++v)
    for (std::size_t i = 0; i < kPoseValues; ++i) {
      const std::size_t at = k + v * kPoseValues + i;
      const double sd = static_cast<double>(i < 3 ? kShiftSdMm : kTurnSd);
      normal_.a[at * n + at] += 1 / (sd * sd);
      normal_.b[at] -= static_cast<double>(views_[v].moved[i]) / (sd * sd);
    }
}

// Slopes of shift and turns: `part(mask)` gives the weight of and the weighted position on the segments of `mask`.
void ShapeFitter::Work::turn_slopes(const View& view, std::size_t v, std::uint32_t segments, const auto& part,
                                    Vec3f along, Row& row) const {
  auto index = static_cast<std::uint16_t>(space_.shape_count + v * kPoseValues);
  const auto put = [&](float slope) {
    row.index[row.count] = index++;
    row.slope[row.count++] = slope;
  };
  put(along.x);
  put(along.y);
  put(along.z);
  for (const Segment turning : kTurning) {
    const std::uint32_t moved = under_[at(turning)] & segments;
    if (moved == 0) {
      index = static_cast<std::uint16_t>(index + 3);
      continue;
    }
    const auto [weight, position] = part(moved);
    const Vec3f turn = cross(position - view.posed.head[at(turning)] * weight, along);
    put(turn.x);
    put(turn.y);
    put(turn.z);
  }
}

void ShapeFitter::Work::point_row(const View& view, std::size_t v, std::size_t point, const Mat3f& turn, Vec3f along,
                                  Row& row) const {
  const std::size_t k = space_.shape_count;
  const SkinRecord& skin = space_.skin[point];
  const Vec3f m = transposed_times(turn, along);
  const float* basis = space_.point_basis.data() + point * kPointValues * k;
  for (std::size_t j = 0; j < k; ++j) {
    row.index[j] = static_cast<std::uint16_t>(j);
    row.slope[j] = m.x * basis[j] + m.y * basis[k + j] + m.z * basis[2 * k + j];
  }
  std::uint32_t segments = 0;
  for (std::size_t i = 0; i < 4 && skin.weight[i] > 0; ++i) {
    const float* move = bone_moves_.data() + (v * kSegments + skin.segment[i]) * 3 * k;
    const Vec3f n = along * skin.weight[i];
    for (std::size_t j = 0; j < k; ++j) row.slope[j] += n.x * move[j] + n.y * move[k + j] + n.z * move[2 * k + j];
    segments |= 1U << skin.segment[i];
  }
  row.count = k;
  const Vec3f rest = at3(values_, point * kPointValues);
  turn_slopes(
      view, v, segments,
      [&](std::uint32_t moved) {
        float weight = 0;
        Vec3f position;
        for (std::size_t i = 0; i < 4 && skin.weight[i] > 0; ++i) {
          const std::size_t s = skin.segment[i];
          if ((moved >> s & 1U) == 0) continue;
          weight += skin.weight[i];
          position = position + (view.pose.rotation[s] * rest + view.offset[s]) * skin.weight[i];
        }
        return std::pair(weight, position);
      },
      along, row);
}

// A point fixed to a bone: `value` is its place among the bones' values.
void ShapeFitter::Work::attached_row(const View& view, std::size_t v, std::size_t bone, Vec3f p, std::size_t value,
                                     Vec3f along, Row& row) const {
  const std::size_t k = space_.shape_count;
  const Vec3f m = transposed_times(view.pose.rotation[bone], along);
  const float* basis = space_.bone_basis.data() + value * k;
  const float* move = bone_moves_.data() + (v * kSegments + bone) * 3 * k;
  for (std::size_t j = 0; j < k; ++j) {
    row.index[j] = static_cast<std::uint16_t>(j);
    row.slope[j] = m.x * basis[j] + m.y * basis[k + j] + m.z * basis[2 * k + j] + along.x * move[j] +
                   along.y * move[k + j] + along.z * move[2 * k + j];
  }
  row.count = k;
  turn_slopes(
      view, v, 1U << bone, [&](std::uint32_t) { return std::pair(1.0F, p); }, along, row);
}

void ShapeFitter::Work::add_joints(const View& view, std::size_t v) {
  Row row;
  const float weight = 1 / (kJointSdMm * kJointSdMm);
  for (const Attached& j : kJoints) {
    const std::size_t bone = at(j.segment);
    const Vec3f p = j.tail ? view.posed.tail[bone] : view.posed.head[bone];
    const std::size_t value = 3 * (bone + (j.tail ? kSegments : 0));
    const Vec3f off = view.joints[j.joint] - p;
    attached_row(view, v, bone, p, value, {1, 0, 0}, row);
    add_row(row, off.x, weight);
    attached_row(view, v, bone, p, value, {0, 1, 0}, row);
    add_row(row, off.y, weight);
    attached_row(view, v, bone, p, value, {0, 0, 1}, row);
    add_row(row, off.z, weight);
  }
}

// Walks from the point along its normal's picture to where the mask ends. Positive: the edge lies outwards.
float ShapeFitter::Work::rim_distance(const View& view, Vec3f camera, Vec3f normal, float reach_mm,
                                      bool& found) const {
  found = false;
  const FitView& seen = *view.seen;
  const Intrinsics& k = seen.intrinsics;
  const float u = k.fx * camera.x / camera.z + k.cx, w = k.fy * camera.y / camera.z + k.cy;
  const float length = std::sqrt(normal.x * normal.x + normal.y * normal.y);
  if (!(length > 0.5F)) return 0;
  const float du = normal.x / length, dv = normal.y / length;
  const float mm_per_px = camera.z / k.fx;
  const int steps = static_cast<int>(reach_mm / mm_per_px * 2) + 1;  // of half a pixel
  const auto inside = [&](float t) {
    const int iu = static_cast<int>(u + du * t + 0.5F), iv = static_cast<int>(w + dv * t + 0.5F);
    return iu >= 0 && iv >= 0 && iu < seen.mask.width && iv < seen.mask.height && seen.mask.at(iu, iv) != 0;
  };
  const bool from_inside = inside(0);
  for (int i = 1; i <= steps; ++i) {
    const float t = 0.5F * static_cast<float>(from_inside ? i : -i);
    if (inside(t) == from_inside) continue;
    const float edge = from_inside ? t - 0.25F : t + 0.25F;
    // The surface inside the edge must be the point's own, not another limb's.
    const float back = edge - 1.0F;
    const int iu = static_cast<int>(u + du * back + 0.5F), iv = static_cast<int>(w + dv * back + 0.5F);
    if (iu < 0 || iv < 0 || iu >= seen.mask.width || iv >= seen.mask.height) return 0;
    const float z = static_cast<float>(seen.depth_q4.at(iu, iv)) * (1.0F / 16);
    if (!(z > 0) || std::abs(z - camera.z) > 120) return 0;
    found = true;
    return edge * mm_per_px;
  }
  return 0;
}

void ShapeFitter::Work::add_points(const View& view, std::size_t v, int iteration) {
  const FitView& seen = *view.seen;
  const Intrinsics& k = seen.intrinsics;
  Row row;
  const bool early = iteration < kJointIterations + 2;
  const float gate_mm = early ? 150.0F : 80.0F;
  const float rim_reach_mm = early ? 90.0F : 45.0F;
  for (std::size_t i = 0; i < space_.point_count; ++i) {
    const SkinRecord& skin = space_.skin[i];
    const Vec3f rest = at3(values_, i * kPointValues);
    Mat3f turn;
    turn.m = {};
    Vec3f p;
    for (std::size_t b = 0; b < 4 && skin.weight[b] > 0; ++b) {
      const auto& r = view.pose.rotation[skin.segment[b]].m;
      for (std::size_t c = 0; c < 9; ++c) turn.m[c] += skin.weight[b] * r[c];
      p = p + view.offset[skin.segment[b]] * skin.weight[b];
    }
    p = p + turn * rest;
    const Vec3f normal =
        normalized(turn * cross(at3(values_, i * kPointValues + 3), at3(values_, i * kPointValues + 6)));
    const Vec3f to_camera = normalized(view.place.shift - p);
    const float facing = dot(normal, to_camera);
    // Soles stand on the floor.
    if (seen.floor.known && normal.y < -0.8F && p.y < 60 &&
        (skin.segment[0] == at(Segment::left_foot) || skin.segment[0] == at(Segment::right_foot))) {
      point_row(view, v, i, turn, {0, 1, 0}, row);
      add_row(row, -p.y, 1 / (kSoleSdMm * kSoleSdMm * kCorrelated));
      continue;
    }
    if (facing < -kRimFacingMax) continue;
    const Vec3f camera = view.place.to_camera(p);
    if (!(camera.z > 200)) continue;
    if (facing > kFacingMin) {
      const float u = k.fx * camera.x / camera.z + k.cx + 0.5F, w = k.fy * camera.y / camera.z + k.cy + 0.5F;
      if (!(u >= 2 && w >= 2)) continue;
      const int iu = static_cast<int>(u), iv = static_cast<int>(w);
      if (iu >= k.width - 2 || iv >= k.height - 2) continue;
      if (seen.mask.at(iu, iv) == 0 || seen.mask.at(iu - 2, iv) == 0 || seen.mask.at(iu + 2, iv) == 0 ||
          seen.mask.at(iu, iv - 2) == 0 || seen.mask.at(iu, iv + 2) == 0)
        continue;
      const float z = static_cast<float>(seen.depth_q4.at(iu, iv)) * (1.0F / 16);
      if (!(z > 0) || std::abs(z - camera.z) > gate_mm) continue;
      const Vec3f q = view.place.to_world(unproject(k, static_cast<float>(iu), static_cast<float>(iv), z));
      const float r = dot(normal, q - p);
      const float far = z / kSurfaceAtMm;
      const float sd = kSurfaceSdMm * far * far;
      const float out = r / (3 * sd);
      point_row(view, v, i, turn, normal, row);
      add_row(row, r, 1 / (sd * sd * kCorrelated * std::sqrt(1 + out * out)));
      ++result.surface_rows;
      surface_sum_ += static_cast<double>(std::abs(r));
    } else if (std::abs(facing) < kRimFacingMax) {
      const Vec3f normal_camera = half_turn(transposed_times(view.place.level, normal));
      bool found = false;
      const float r = rim_distance(view, camera, normal_camera, rim_reach_mm, found);
      if (!found) continue;
      const float length = std::sqrt(normal_camera.x * normal_camera.x + normal_camera.y * normal_camera.y);
      const Vec3f along = view.place.direction_to_world({normal_camera.x / length, normal_camera.y / length, 0});
      const float out = r / 12;
      point_row(view, v, i, turn, along, row);
      add_row(row, r, 1 / (kRimSdMm * kRimSdMm * kCorrelated * std::sqrt(1 + out * out)));
      ++result.rim_rows;
      rim_sum_ += static_cast<double>(std::abs(r));
    }
  }
}

// Cholesky of the lower triangle in place, then two substitutions.
bool ShapeFitter::Work::solve() {
  const std::size_t n = normal_.n;
  double* a = normal_.a.data();
  for (std::size_t j = 0; j < n; ++j) {
    double d = a[j * n + j];
    for (std::size_t c = 0; c < j; ++c) d -= a[j * n + c] * a[j * n + c];
    if (!(d > 0)) return false;
    const double root = std::sqrt(d);
    a[j * n + j] = root;
    for (std::size_t i = j + 1; i < n; ++i) {
      double s = a[i * n + j];
      for (std::size_t c = 0; c < j; ++c) s -= a[i * n + c] * a[j * n + c];
      a[i * n + j] = s / root;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double s = normal_.b[i];
    for (std::size_t c = 0; c < i; ++c) s -= a[i * n + c] * step_[c];
    step_[i] = s / a[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    double s = step_[i];
    for (std::size_t c = i + 1; c < n; ++c) s -= a[c * n + i] * step_[c];
    step_[i] = s / a[i * n + i];
  }
  return true;
}

void ShapeFitter::Work::move(std::size_t v) {
  View& view = views_[v];
  const double* step = step_.data() + space_.shape_count + v * kPoseValues;
  const auto value = [&](std::size_t i) {
    return static_cast<float>(std::clamp(step[i], i < 3 ? -200.0 : -0.35, i < 3 ? 200.0 : 0.35));
  };
  for (std::size_t i = 0; i < kPoseValues; ++i) view.moved[i] += value(i);
  view.pose.translation_mm = view.pose.translation_mm + Vec3f{value(0), value(1), value(2)};
  std::array<Mat3f, kSegments> turned;
  for (std::size_t s = 0; s < kSegments; ++s)
    turned[s] = kSegmentParent[s] < 0 ? Mat3f{} : turned[static_cast<std::size_t>(kSegmentParent[s])];
  // Parents come first: what a segment's own turn adds, all that hangs on it inherits.
  std::array<int, kSegments> own;
  own.fill(-1);
  for (std::size_t t = 0; t < kTurning.size(); ++t) own[at(kTurning[t])] = static_cast<int>(t);
  for (std::size_t s = 0; s < kSegments; ++s) {
    turned[s] = kSegmentParent[s] < 0 ? Mat3f{} : turned[static_cast<std::size_t>(kSegmentParent[s])];
    if (own[s] >= 0) {
      const auto i = 3 + 3 * static_cast<std::size_t>(own[s]);
      turned[s] = turned[s] * small_rotation({value(i), value(i + 1), value(i + 2)});
    }
  }
  for (std::size_t s = 0; s < kSegments; ++s) view.pose.rotation[s] = turned[s] * view.pose.rotation[s];
}

void ShapeFitter::Work::run(std::span<const FitView> views) {
  result = {};
  view_count_ = std::min(views.size(), kFitViewMax);
  shape_values();
  for (std::size_t v = 0; v < view_count_; ++v) start(views[v], views_[v]);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    normal_.clear(space_.shape_count + view_count_ * kPoseValues);
    result.surface_rows = result.rim_rows = 0;
    surface_sum_ = rim_sum_ = 0;
    add_prior();
    for (std::size_t v = 0; v < view_count_; ++v) {
      pose_view(views_[v]);
      bone_derivatives(views_[v], v);
      add_joints(views_[v], v);
      if (iteration >= kJointIterations) add_points(views_[v], v, iteration);
    }
    if (!solve()) return;
    for (std::size_t j = 0; j < space_.shape_count; ++j)
      result.shape[j] = std::clamp(result.shape[j] + static_cast<float>(step_[j]), -5.0F, 5.0F);
    for (std::size_t v = 0; v < view_count_; ++v) move(v);
    shape_values();
  }
  result.surface_mm = static_cast<float>(surface_sum_ / std::max(result.surface_rows, 1));
  result.rim_mm = static_cast<float>(rim_sum_ / std::max(result.rim_rows, 1));
  result.valid = result.surface_rows >= 100 && std::isfinite(result.shape[0]);
}

std::span<const float> fit_values(const ShapeFit& fit, const ShapeSpace& space, std::span<float> out) {
  if (!fit.valid) return {};
  std::copy_n(fit.shape.begin(), space.shape_count, out.begin());
  out[space.shape_count] = fit.surface_mm;
  out[space.shape_count + 1] = fit.rim_mm;
  return out.first(space.shape_count + 2);
}

ShapeFitter::ShapeFitter(const ShapeSpace& space) : work_(std::make_unique<Work>(space)) {}
ShapeFitter::~ShapeFitter() = default;

const ShapeFit& ShapeFitter::run(std::span<const FitView> views) {
  work_->run(views);
  return work_->result;
}

}  // namespace im2fit::body
