// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/deformable_mean.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/rng.h"

namespace im2fit::lab {
namespace {

using body::Segment;

constexpr std::uint64_t kMeanStream = 0xA2504;
constexpr double kPairMm = 5, kSingleMm = 2;  // of kPairs and kSingles
// How far the back lies behind the sides, as a share of the depth: SD about the mean mesh'. The survey is silent.
constexpr double kBackShareSd = 0.05;
constexpr double kPostureSd = 0.8;  // of kPostureMm: what people vary by

bool is_of(Segment s, Segment left, Segment right) {
  return s == left || s == right;
}

std::vector<Vec3f> normals_of(const DimensionSurface& surface, std::span<const Vec3f> rest) {
  std::vector<Vec3f> normal(static_cast<std::size_t>(surface.vertex_count));
  for (const auto& t : surface.triangles) {
    const auto i = [&](std::size_t c) { return static_cast<std::size_t>(t[c]); };
    const Vec3f n = cross(rest[i(1)] - rest[i(0)], rest[i(2)] - rest[i(0)]);
    for (std::size_t c = 0; c < 3; ++c) normal[i(c)] = normal[i(c)] + n;
  }
  for (Vec3f& n : normal) n = normalized(n);
  return normal;
}

// A joint that stays where the mean mesh has it, nearly: posture is not the survey's business, and a few millimetres
// of dimension must not be met by leaning.
struct Stay {
  PullRow row;
  double tolerance_mm;
};
std::vector<Stay> stays_of(const DimensionSurface& surface) {
  std::vector<Stay> stays;
  using List = std::vector<std::int32_t>;
  const auto stay = [&](const List& of, double aside_mm, double forwards_mm) {
    for (const auto& [axis, mm] : {std::pair{Vec3f{1, 0, 0}, aside_mm}, std::pair{Vec3f{0, 0, 1}, forwards_mm}}) {
      Stay& s = stays.emplace_back(Stay{{}, mm});
      for (const std::int32_t v : of) s.row.push_back({v, axis * (1.0F / static_cast<float>(of.size()))});
    }
  };
  const auto head = [&](Segment s) -> const List& { return surface.head[static_cast<std::size_t>(s)]; };
  const auto tail = [&](Segment s) -> const List& { return surface.tail[static_cast<std::size_t>(s)]; };
  for (const Segment s : {Segment::pelvis, Segment::abdomen, Segment::chest, Segment::neck, Segment::head})
    stay(head(s), 1.5, kPostureMm);
  stay(tail(Segment::head), 1.5, kPostureMm);
  for (const Segment s : {Segment::left_upper_leg, Segment::right_upper_leg, Segment::left_lower_leg,
                          Segment::right_lower_leg, Segment::left_foot, Segment::right_foot})
    stay(head(s), 8, kPostureMm);
  // How much higher one list lies than the other stays as it is.
  const auto stay_apart = [&](const List& upper, const List& lower) {
    Stay& apart = stays.emplace_back(Stay{{}, 1});
    for (const auto& [list, sign] : {std::pair{&upper, 1.0F}, std::pair{&lower, -1.0F}})
      for (const std::int32_t v : *list) apart.row.push_back({v, {0, sign / static_cast<float>(list->size()), 0}});
    stays.emplace_back(Stay{{}, 1});  // pairs: aside or apart first, then forwards
  };
  // Level: the left one is no higher than the right one.
  for (const auto& [left, right] : {std::pair{Segment::left_foot, Segment::right_foot},
                                    std::pair{Segment::left_lower_leg, Segment::right_lower_leg},
                                    std::pair{Segment::left_upper_leg, Segment::right_upper_leg},
                                    std::pair{Segment::left_upper_arm, Segment::right_upper_arm}})
    stay_apart(head(left), head(right));
  // Who stands bears on heel and ball: a foot keeps its pitch. Left free, heights and girths of the shank are met by
  // feet whose toes hang in the air, 16 mm in the mean.
  for (const Segment s : {Segment::left_foot, Segment::right_foot}) stay_apart(tail(s), head(s));
  return stays;
}

std::vector<PullRow> free_rows(const DimensionSurface& surface, std::span<const Vec3f> rest, Rng& rng) {
  const auto normal = normals_of(surface, rest);
  std::vector<PullRow> rows;
  while (rows.size() < kPairs + kSingles) {
    const int v = rng.index(surface.vertex_count);
    const auto at = static_cast<std::size_t>(v);
    const Segment s = surface.segment[at];
    if (s == Segment::head || is_of(s, Segment::left_hand, Segment::right_hand) ||
        is_of(s, Segment::left_foot, Segment::right_foot))
      continue;
    PullRow row = {{v, normal[at]}};
    if (rows.size() < kPairs) {
      const Vec3f mirrored = {-rest[at].x, rest[at].y, rest[at].z};
      std::int32_t other = v;
      for (std::int32_t o = 0; o < surface.vertex_count; ++o)
        if (norm(rest[static_cast<std::size_t>(o)] - mirrored) <
            norm(rest[static_cast<std::size_t>(other)] - mirrored))
          other = o;
      row.push_back({other, normal[static_cast<std::size_t>(other)]});
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Eigen::RowVectorXd along_basis(const Basis& basis, const PullRow& row) {
  Eigen::RowVectorXf sum = Eigen::RowVectorXf::Zero(basis.cols());
  for (const Pull& pull : row) {
    const auto at = static_cast<Eigen::Index>(3 * pull.vertex);
    sum +=
        pull.gradient.x * basis.row(at) + pull.gradient.y * basis.row(at + 1) + pull.gradient.z * basis.row(at + 2);
  }
  return sum.cast<double>();
}

void complete_mean(Mean& mean, DimensionSurface surface, DeformationGraph& graph, std::uint64_t number) {
  mean.dimensions = std::make_unique<BodyDimensions>(std::move(surface), mean.rest);
  const DimensionSurface& own = mean.dimensions->surface();
  std::vector<PullRow> rows;
  mean.own = mean.dimensions->measure(mean.rest, &rows);
  for (PullRow& row : mean.dimensions->squaring_rows(mean.rest)) rows.push_back(std::move(row));
  const std::vector<Stay> stays = stays_of(own);
  for (const Stay& s : stays) rows.push_back(s.row);
  mean.free_first = static_cast<int>(rows.size());
  Rng rng = Rng::for_item(kMeanStream, kMeanStream, number);
  for (PullRow& row : free_rows(own, mean.rest, rng)) rows.push_back(std::move(row));

  const auto columns = static_cast<Eigen::Index>(rows.size());
  mean.basis.resize(static_cast<Eigen::Index>(3 * mean.rest.size()), columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    const PullRow& row = rows[static_cast<std::size_t>(c)];
    const std::vector<Vec3f> response = graph.response(row);
    for (std::size_t v = 0; v < response.size(); ++v) {
      const auto at = static_cast<Eigen::Index>(3 * v);
      mean.basis(at, c) = response[v].x, mean.basis(at + 1, c) = response[v].y, mean.basis(at + 2, c) = response[v].z;
    }
    if (c < mean.free_first) continue;
    double own_mm = 0;
    for (const Pull& pull : row)
      own_mm += static_cast<double>(dot(pull.gradient, response[static_cast<std::size_t>(pull.vertex)])) /
                static_cast<double>(row.size());
    mean.free_mm.push_back(own_mm);
  }
  mean.products.resize(columns, columns);
  for (Eigen::Index i = 0; i < columns; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      mean.products(i, j) = graph.product(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  mean.stay.resize(static_cast<Eigen::Index>(stays.size()), columns);
  for (std::size_t s = 0; s < stays.size(); ++s)
    mean.stay.row(static_cast<Eigen::Index>(s)) = along_basis(mean.basis, stays[s].row) / stays[s].tolerance_mm;
}

void draw_backs(const Mean& mean, Rng& rng, DimensionValues& wanted) {
  for (const auto& [back, depth] : {std::pair{SurveyDimension::chest_back, SurveyDimension::chest_depth},
                                    std::pair{SurveyDimension::waist_back, SurveyDimension::waist_depth},
                                    std::pair{SurveyDimension::hip_back, SurveyDimension::hip_depth}}) {
    const double share = mean.own[dimension_index(back)] / mean.own[dimension_index(depth)];
    wanted[dimension_index(back)] =
        (share + std::clamp(rng.normal(), -2.5, 2.5) * kBackShareSd) * wanted[dimension_index(depth)];
  }
}

Eigen::VectorXd draw_free_shape(const Mean& mean, Rng& rng) {
  Eigen::VectorXd start = Eigen::VectorXd::Zero(mean.products.rows());
  for (std::size_t f = 0; f < mean.free_mm.size(); ++f) {
    const double mm = std::clamp(rng.normal(), -2.5, 2.5) * (f < kPairs ? kPairMm : kSingleMm);
    start[mean.free_first + static_cast<Eigen::Index>(f)] = mm / mean.free_mm[f];
  }
  return start;
}

Eigen::VectorXd draw_posture(const Mean& mean, Rng& rng) {
  Eigen::VectorXd posture = Eigen::VectorXd::Zero(mean.stay.rows());
  for (Eigen::Index s = 1; s < posture.size(); s += 2) posture[s] = kPostureSd * std::clamp(rng.normal(), -2.5, 2.5);
  return posture;
}

void deform(const Mean& mean, const Eigen::VectorXd& c, std::span<Vec3f> rest) {
  const Eigen::VectorXf moved = mean.basis * c.cast<float>();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const auto at = static_cast<Eigen::Index>(3 * v);
    rest[v] = mean.rest[v] + Vec3f{moved[at], moved[at + 1], moved[at + 2]};
  }
}

}  // namespace im2fit::lab
