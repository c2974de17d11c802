// SPDX-License-Identifier: Apache-2.0
#include "body/fit/posed_shape.h"

#include <algorithm>
#include <cmath>

namespace im2fit::body {
namespace {

constexpr std::size_t kSegments = static_cast<std::size_t>(kSegmentCount);

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// Of each segment: those that hang on it, itself included.
const std::array<SegmentSet, kSegments>& hanging() {
  static const auto sets = [] {
    std::array<SegmentSet, kSegments> out{};
    for (std::size_t s = 0; s < kSegments; ++s)
      for (int d = static_cast<int>(s); d >= 0; d = kSegmentParent[static_cast<std::size_t>(d)])
        out[static_cast<std::size_t>(d)] |= SegmentSet{1} << s;
    return out;
  }();
  return sets;
}

// The rotation by about |w| about w, for small w: a normalised quaternion.
Mat3f small_rotation(Vec3f w) {
  const float q = 1 / std::sqrt(1 + 0.25F * dot(w, w));
  const float x = 0.5F * q * w.x, y = 0.5F * q * w.y, z = 0.5F * q * w.z;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - q * z), 2 * (x * z + q * y), 2 * (x * y + q * z),
           1 - 2 * (x * x + z * z), 2 * (y * z - q * x), 2 * (x * z - q * y), 2 * (y * z + q * x),
           1 - 2 * (x * x + y * y)}};
}

Vec3f vec3(Four v) {
  return {v[0], v[1], v[2]};
}

Vec3f transposed_times(const std::array<Four, 3>& columns, Vec3f v) {
  const auto along = [&](std::size_t c) { return dot(vec3(columns[c]), v); };
  return {along(0), along(1), along(2)};
}

std::array<Four, 3> columns_of_matrix(const Mat3f& a) {
  return {Four{a.m[0], a.m[3], a.m[6], 0}, Four{a.m[1], a.m[4], a.m[7], 0}, Four{a.m[2], a.m[5], a.m[8], 0}};
}

Four times(const std::array<Four, 3>& columns, Vec3f v) {
  return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z;
}

void put(std::span<float> row, std::size_t at, Vec3f v) {
  row[at] = v.x;
  row[at + 1] = v.y;
  row[at + 2] = v.z;
}

void put_part(SlopeParts& parts, const float* rows, Vec3f n) {
  const std::size_t p = parts.parts++;
  parts.rows[p] = rows;
  parts.along[p][0] = n.x;
  parts.along[p][1] = n.y;
  parts.along[p][2] = n.z;
}

}  // namespace

void move_pose(Pose& pose, std::span<const float, kPoseValues> step) {
  std::array<Mat3f, kSegments> own, turned;
  for (std::size_t t = 0; t < kTurning.size(); ++t)
    own[at(kTurning[t])] = small_rotation({step[3 + 3 * t], step[4 + 3 * t], step[5 + 3 * t]});
  for (std::size_t s = 0; s < kSegments; ++s)
    turned[s] = kSegmentParent[s] < 0 ? own[s] : turned[static_cast<std::size_t>(kSegmentParent[s])] * own[s];
  for (std::size_t s = 0; s < kSegments; ++s) pose.rotation[s] = turned[s] * pose.rotation[s];
  pose.translation_mm = pose.translation_mm + Vec3f{step[0], step[1], step[2]};
}

SegmentSet segments_of(const SkinRecord& skin) {
  SegmentSet segments = 0;
  for (std::size_t i = 0; i < 4 && skin.weight[i] > 0; ++i) segments |= SegmentSet{1} << skin.segment[i];
  return segments;
}

RowColumns columns_of(SegmentSet segments) {
  RowColumns columns;
  columns.triple[columns.triple_count++] = 0;
  for (std::size_t t = 0; t < kTurning.size(); ++t)
    if ((hanging()[at(kTurning[t])] & segments) != 0)
      columns.triple[columns.triple_count++] = static_cast<std::uint8_t>(t + 1);
  return columns;
}

std::vector<PointGroup> point_groups(const ShapeSpace& space) {
  std::vector<PointGroup> groups;
  for (std::uint32_t i = 0; i < space.point_count; ++i) {
    const RowColumns columns = columns_of(segments_of(space.skin[i]));
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const PointGroup& g) {
      return g.columns.triple_count == columns.triple_count && g.columns.triple == columns.triple;
    });
    PointGroup& group = same == groups.end() ? groups.emplace_back(PointGroup{columns, {}}) : *same;
    group.points.push_back(i);
  }
  return groups;
}

RestShape::RestShape(const ShapeSpace& space)
    : space_(space), points_(space.point_count * kPointValues), bones_(kBoneValues) {}

void RestShape::set_bones(std::span<const float> coefficients) {
  loops_.add_shapes(
      {space_.bone_mean.data(), space_.bone_basis.data(), coefficients.data(), kBoneValues, coefficients.size()},
      bones_.data());
  const auto bone = [&](std::size_t i) { return Vec3f{bones_[3 * i], bones_[3 * i + 1], bones_[3 * i + 2]}; };
  for (std::size_t s = 0; s < kSegments; ++s) {
    skeleton_.head[s] = bone(s);
    skeleton_.tail[s] = bone(kSegments + s);
  }
}

void RestShape::set_points(std::span<const float> coefficients) {
  loops_.add_shapes(
      {space_.point_mean.data(), space_.point_basis.data(), coefficients.data(), points_.size(), coefficients.size()},
      points_.data());
}

void RestShape::move_points(std::span<const float> mm, std::span<const Vec3f> directions) {
  for (std::size_t i = 0; i < mm.size(); ++i) {
    float* at = points_.data() + i * kPointValues;
    at[0] += mm[i] * directions[i].x;
    at[1] += mm[i] * directions[i].y;
    at[2] += mm[i] * directions[i].z;
  }
}

PosedShape::PosedShape(const ShapeSpace& space, const RestShape& rest)
    : space_(space),
      rest_(rest),
      head_moves_(kSegments * 3 * space.shape_count),
      offset_moves_(kSegments * 3 * space.shape_count) {}

void PosedShape::set(const Pose& pose) {
  pose_ = pose;
  const Skeleton& rest = rest_.skeleton();
  posed_ = pose_skeleton(rest, pose);
  for (std::size_t s = 0; s < kSegments; ++s) {
    const Vec3f offset = posed_.head[s] - pose.rotation[s] * rest.head[s];
    moves_[s] = {columns_of_matrix(pose.rotation[s]), Four{offset.x, offset.y, offset.z, 0}};
  }
  set_offset_moves();
}

// A posed head moves as its parent's and as the difference between the two rest heads, turned with the parent.
void PosedShape::set_offset_moves() {
  const std::size_t count = space_.shape_count;
  const auto rest = [&](std::size_t s, std::size_t axis) {
    return space_.bone_basis.data() + (3 * s + axis) * count;
  };
  for (std::size_t s = 0; s < kSegments; ++s)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float* __restrict head = head_moves_.data() + (3 * s + axis) * count;
      if (kSegmentParent[s] < 0) {
        std::copy_n(rest(s, axis), count, head);
      } else {
        const auto p = static_cast<std::size_t>(kSegmentParent[s]);
        const float* m = pose_.rotation[p].m.data() + 3 * axis;
        const float* parent = head_moves_.data() + (3 * p + axis) * count;
        for (std::size_t k = 0; k < count; ++k)
          head[k] = parent[k] + m[0] * (rest(s, 0)[k] - rest(p, 0)[k]) + m[1] * (rest(s, 1)[k] - rest(p, 1)[k]) +
                    m[2] * (rest(s, 2)[k] - rest(p, 2)[k]);
      }
      const float* m = pose_.rotation[s].m.data() + 3 * axis;
      float* __restrict move = offset_moves_.data() + (3 * s + axis) * count;
      for (std::size_t k = 0; k < count; ++k)
        move[k] = head[k] - (m[0] * rest(s, 0)[k] + m[1] * rest(s, 1)[k] + m[2] * rest(s, 2)[k]);
    }
}

void PosedShape::find(std::size_t index, Point& point) const {
  const SkinRecord& skin = space_.skin[index];
  const Vec3f rest = rest_.middle(index);
  std::array<Four, 3> turn{};
  Four position{};
  for (std::size_t i = 0; i < 4 && skin.weight[i] > 0; ++i) {
    const Move& move = moves_[skin.segment[i]];
    const float w = skin.weight[i];
    for (std::size_t c = 0; c < 3; ++c) turn[c] += w * move.column[c];
    point.part[i] = (times(move.column, rest) + move.offset) * w;
    position += point.part[i];
  }
  point.index = index;
  point.turn = turn;
  point.position = vec3(position);
  point.normal = normalized(vec3(times(turn, rest_.normal(index))));
}

void PosedShape::pose_row(const Point& point, Vec3f n, const RowColumns& columns, std::span<float> row) const {
  const SkinRecord& skin = space_.skin[point.index];
  std::size_t followed = 0;
  while (followed < 4 && skin.weight[followed] > 0) ++followed;
  put(row, 0, n);
  for (std::size_t t = 1; t < columns.triple_count; ++t) {
    const std::size_t turning = at(kTurning[columns.triple[t] - 1U]);
    const SegmentSet moved = hanging()[turning];
    float weight = 0;
    Four part{};
    for (std::size_t i = 0; i < followed; ++i)
      if (followed == 1 || (moved >> skin.segment[i] & 1U) != 0) {  // each of its columns moves the only one
        weight += skin.weight[i];
        part += point.part[i];
      }
    put(row, 3 * t, cross(vec3(part) - posed_.head[turning] * weight, n));
  }
}

void PosedShape::point_row(const Point& point, Vec3f n, const RowColumns& columns, std::span<float> row) const {
  pose_row(point, n, columns, row);
  const SkinRecord& skin = space_.skin[point.index];
  const std::size_t count = space_.shape_count;
  SlopeParts parts{{}, {}, 0, count};
  put_part(parts, space_.point_basis.data() + point.index * kPointValues * count, transposed_times(point.turn, n));
  for (std::size_t i = 0; i < 4 && skin.weight[i] > 0; ++i)
    put_part(parts, moves_of(skin.segment[i]), n * skin.weight[i]);
  loops_.add_slopes(parts, row.data() + 3 * columns.triple_count);
}

void PosedShape::bone_row(Segment segment, bool tail, Vec3f n, const RowColumns& columns,
                          std::span<float> row) const {
  const std::size_t s = at(segment), count = space_.shape_count;
  const Vec3f p = tail ? posed_.tail[s] : posed_.head[s];
  put(row, 0, n);
  for (std::size_t t = 1; t < columns.triple_count; ++t)
    put(row, 3 * t, cross(p - posed_.head[at(kTurning[columns.triple[t] - 1U])], n));
  SlopeParts parts{{}, {}, 0, count};
  put_part(parts, space_.bone_basis.data() + 3 * (s + (tail ? kSegments : 0)) * count,
           transposed_times(moves_[s].column, n));
  put_part(parts, moves_of(s), n);
  loops_.add_slopes(parts, row.data() + 3 * columns.triple_count);
}

}  // namespace im2fit::body
