// SPDX-License-Identifier: Apache-2.0
#include "body/fit/seen_prior.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "body/fit/measurement_fit.h"
#include "body/fit/posed_shape.h"
#include "body/fit/shape_points.h"
#include "core/cholesky.h"

namespace im2fit::body {
namespace {

// Of a shift of the whole body: any. A rest mesh hangs from joints that no measurement sees.
constexpr double kShiftSdMm = 100;
constexpr float kBackMost = -0.25F;  // of a normal's part to the front: what is behind was not seen from there
constexpr float kSmallStep = 0.02F;  // of a slider
constexpr std::size_t kUnknownCount = kFitParameterCount,
                      kShiftedCount = kUnknownCount + 3;  // and a shift of the whole body
constexpr double kSeenPivotMin = 1e-14;                   // rounding of a matrix of ones and what the skin adds
constexpr std::array<std::size_t, 3> kSliders = {0, 1, kCrotchParameter};

using Row = std::array<double, kShiftedCount>;
using Square = std::array<Row, kShiftedCount>;

enum class Part : std::uint8_t { trunk, limb, left_out };

// Trunk and thighs always count. How arms and shins hang at rest is the pose's rather than the shape's, unless many
// pictures of a turn told them apart. Hair hides a head.
Part part_of(const SkinRecord& skin) {
  switch (static_cast<Segment>(skin.segment[0])) {
    case Segment::head:
    case Segment::neck:
    case Segment::left_hand:
    case Segment::right_hand:
    case Segment::left_foot:
    case Segment::right_foot:
      return Part::left_out;
    case Segment::left_shoulder:
    case Segment::right_shoulder:
    case Segment::left_upper_arm:
    case Segment::right_upper_arm:
    case Segment::left_lower_arm:
    case Segment::right_lower_arm:
    case Segment::left_lower_leg:
    case Segment::right_lower_leg:
      return Part::limb;
    default:
      return Part::trunk;
  }
}

}  // namespace

struct SeenPrior::Work {
  explicit Work(const BodyModel& m) : model(m), shape(m.shape_space()) {
    const std::vector<Quad> all = quads_of_shape_space(m);
    for (const Part part : {Part::trunk, Part::limb}) {
      for (std::size_t i = 0; i < all.size(); i += kSeenEach) {
        if (part_of(m.shape_space().skin[i]) != part) continue;
        points.push_back(i);
        for (const std::int32_t corner : all[i]) quads.push_back(corner);
        corners.push_back(all[i][0]);
      }
      if (part == Part::trunk) trunk_count = points.size();
    }
    slopes.resize(corners.size() * kWarpCount);
    warped.resize(quads.size());
    for (auto* mesh : {&rest, &moves[0], &moves[1], &moves[2]})
      mesh->resize(static_cast<std::size_t>(m.vertex_count()));
    for (Params* p : {&bare, &moved[0], &moved[1], &moved[2]}) p->modifiers.reserve(m.modifier_names().size());
  }

  const BodyModel& model;
  RestShape shape;
  std::vector<std::size_t> points;  // of the space: the trunk's, then those of limbs
  std::size_t trunk_count = 0;
  std::vector<std::int32_t> quads;    // their four vertices each
  std::vector<std::int32_t> corners;  // one of each quad
  std::vector<Vec3f> slopes;
  std::vector<Vec3f> rest;
  std::vector<Vec3f> warped;  // of the quads
  std::array<std::vector<Vec3f>, 3> moves;
  Params bare;
  std::array<Params, 3> moved;

  void set_slopes(const Params& from, std::size_t count);
  std::size_t count_for(const SeenBody& seen) const { return seen.around ? points.size() : trunk_count; }
  Row row_of(std::size_t point, Vec3f normal) const;
  void add_equations(const SeenBody& seen, double sd_mm, Square& sum, Row& right);
};

// Of the first `count` points. Of the unknowns that are sliders, by meshes that are a little off; a warp's are
// linear.
void SeenPrior::Work::set_slopes(const Params& from, std::size_t count) {
  bare = from;
  bare.modifiers.resize(model.modifier_names().size());
  bare.warp = {};
  model.morph(bare, rest);
  warp_slopes(model, rest, std::span(corners).first(count), std::span(slopes).first(count * kWarpCount));
  warp_vertices(model, from.warp, rest, std::span(quads).first(4 * count), std::span(warped).first(4 * count));
  std::array<BodyModel::BodyMove, 3> all;
  const std::array<float, 3> at = {bare.height, bare.weight, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const float step = at[k] > 0.5F ? -kSmallStep : kSmallStep;
    FitParameters change{};
    change[kSliders[k]] = static_cast<double>(step);
    change_body(model, bare, change, moved[k]);
    std::fill(moves[k].begin(), moves[k].end(), Vec3f{});
    all[k] = {&bare, &moved[k], 1 / step, moves[k]};
  }
  model.move_bodies(all);
}

Row SeenPrior::Work::row_of(std::size_t point, Vec3f normal) const {
  Row row{};
  const auto vertex = static_cast<std::size_t>(corners[point]);
  for (std::size_t k = 0; k < 3; ++k) row[kSliders[k]] = static_cast<double>(dot(normal, moves[k][vertex]));
  for (std::size_t i = 0; i < kWarpCount; ++i)
    row[2 + i] = static_cast<double>(dot(normal, slopes[point * kWarpCount + i]));
  row[kUnknownCount] = static_cast<double>(normal.x);
  row[kUnknownCount + 1] = static_cast<double>(normal.y);
  row[kUnknownCount + 2] = static_cast<double>(normal.z);
  return row;
}

void SeenPrior::Work::add_equations(const SeenBody& seen, double sd_mm, Square& sum, Row& right) {
  shape.set_points(std::span(seen.shape).first(model.shape_space().shape_count));
  const double weight = 1 / (sd_mm * sd_mm);
  for (std::size_t p = 0; p < count_for(seen); ++p) {
    const Vec3f normal = normalized(shape.normal(points[p]));
    if (!seen.back && normal.z < kBackMost) continue;
    Vec3f own{};
    for (const Vec3f corner : std::span(warped).subspan(4 * p, 4)) own = own + corner;
    float beyond = 0;
    if (seen.around && points[p] / kSeenEach < kSeenPointMax) beyond = seen.beyond_mm[points[p] / kSeenEach];
    const double off = static_cast<double>(dot(normal, shape.middle(points[p]) - own * 0.25F) + beyond);
    const Row row = row_of(p, normal);
    for (std::size_t i = 0; i < kShiftedCount; ++i) {
      right[i] += weight * row[i] * off;
      for (std::size_t j = 0; j <= i; ++j) sum[i][j] += weight * row[i] * row[j];
    }
  }
}

SeenPrior::SeenPrior(const BodyModel& model) : work_(std::make_unique<Work>(model)) {}
SeenPrior::SeenPrior(SeenPrior&&) noexcept = default;
SeenPrior& SeenPrior::operator=(SeenPrior&&) noexcept = default;
SeenPrior::~SeenPrior() = default;

void SeenPrior::see(const Params& from, const SeenBody& seen, double sd_mm, FitPrior& prior) {
  Work& w = *work_;
  if (!seen.valid || w.points.empty()) return;
  w.set_slopes(from, w.count_for(seen));
  Square sum{};
  Row right{};
  w.add_equations(seen, sd_mm, sum, right);
  for (std::size_t i = 0; i < kShiftedCount; ++i)
    for (std::size_t j = 0; j < i; ++j) sum[j][i] = sum[i][j];

  // Whitened: I + F' sum F, F people's factor and the shift's standard deviation.
  Square factor{};
  for (std::size_t i = 0; i < kUnknownCount; ++i)
    for (std::size_t j = 0; j <= i; ++j) factor[i][j] = prior.factor[i][j];
  for (std::size_t i = kUnknownCount; i < kShiftedCount; ++i) factor[i][i] = kShiftSdMm;
  Square half{}, whole{};
  Row m{};
  for (std::size_t i = 0; i < kShiftedCount; ++i)
    for (std::size_t j = 0; j < kShiftedCount; ++j)
      for (std::size_t k = j; k < kShiftedCount; ++k) half[i][j] += sum[i][k] * factor[k][j];
  for (std::size_t i = 0; i < kShiftedCount; ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      for (std::size_t k = i; k < kShiftedCount; ++k) whole[i][j] += factor[k][i] * half[k][j];
    whole[i][i] += 1;
    for (std::size_t k = i; k < kShiftedCount; ++k) m[i] += factor[k][i] * right[k];
  }
  cholesky_factor(whole, kShiftedCount, kSeenPivotMin);
  cholesky_solve(whole, kShiftedCount, m);
  for (std::size_t i = 0; i < kUnknownCount; ++i)
    for (std::size_t j = 0; j <= i; ++j) prior.centre[i] += factor[i][j] * m[j];

  // Back to the unknowns: F P F', whose factor is the new one.
  Square covariance{};
  for (std::size_t c = 0; c < kUnknownCount; ++c) {
    Row column{};
    for (std::size_t j = 0; j <= c; ++j) column[j] = factor[c][j];
    cholesky_solve(whole, kShiftedCount, column);  // P F' e_c
    for (std::size_t i = c; i < kUnknownCount; ++i)
      for (std::size_t k = 0; k <= i; ++k) covariance[i][c] += factor[i][k] * column[k];
  }
  cholesky_factor(covariance, kUnknownCount, kSeenPivotMin);
  for (std::size_t i = 0; i < kUnknownCount; ++i)
    for (std::size_t j = 0; j <= i; ++j) prior.factor[i][j] = covariance[i][j];
}

}  // namespace im2fit::body
