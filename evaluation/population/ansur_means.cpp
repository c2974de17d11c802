// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_means.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "body/measure.h"
#include "body/model_data.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "train/population/solve.h"

namespace im2fit::lab {

const std::array<MeanBuild, kMeanCount> kMeans = {{
    {false,
     1755,
     63,
     23,
     27,
     0.52F,
     0.5F,
     {0.5F, 0.3F, 0.2F},
     {1.04F, 0.97F, 0.96F},
     {1.05F, 1.04F, 0.97F},
     {1.06F, 1.1F, 1.03F},
     7,
     -4},
    {false,
     1755,
     84,
     30.5,
     33,
     0.55F,
     0.5F,
     {0.2F, 0.2F, 0.6F},
     {0.96F, 1.03F, 1.05F},
     {0.95F, 0.97F, 1.08F},
     {0.95F, 0.92F, 1.05F},
     -5,
     6},
    {false,
     1755,
     113,
     99,
     44,
     0.4F,
     0.5F,
     {0.2F, 0.5F, 0.3F},
     {1.05F, 0.98F, 1.02F},
     {1.08F, 1.02F, 1.06F},
     {1.08F, 1.06F, 0.97F},
     4,
     5},
    {true,
     1630,
     52,
     23,
     25,
     0.45F,
     0.42F,
     {0.2F, 0.6F, 0.2F},
     {1.03F, 0.98F, 0.95F},
     {1.04F, 1.02F, 0.96F},
     {1.05F, 1.08F, 1.04F},
     6,
     -3},
    {true,
     1630,
     68,
     30.5,
     34,
     0.42F,
     0.5F,
     {0.3F, 0.1F, 0.6F},
     {0.97F, 1.02F, 1.04F},
     {0.96F, 0.98F, 1.06F},
     {0.96F, 0.94F, 1.03F},
     -4,
     5},
    {true,
     1630,
     97,
     99,
     45,
     0.35F,
     0.58F,
     {0.6F, 0.2F, 0.2F},
     {1.04F, 1.0F, 1.03F},
     {1.05F, 1.05F, 1.04F},
     {1.07F, 1.05F, 0.98F},
     5,
     6},
}};

namespace {

using body::Segment;

constexpr std::uint64_t kMeanStream = 0xA2504;
constexpr int kSmoothings = 6;
constexpr float kSmoothShare = 0.5F;

bool is_of(Segment s, Segment left, Segment right) {
  return s == left || s == right;
}

void reshape_ends(const body::BodyModel& model, const MeanBuild& build, std::vector<Vec3f>& rest) {
  const body::Skeleton bones = body::rest_skeleton(model, rest);
  const auto skin = model.data().skin;
  float crown = 0;
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v)
    crown = std::max(crown, rest[v].y);
  const Vec3f neck_top = bones.head[static_cast<std::size_t>(Segment::head)];
  for (std::size_t v = 0; v < rest.size(); ++v) {
    Vec3f move;
    for (std::size_t e = 0; e < 4; ++e) {
      const float w = skin[v].weight[e];
      const auto s = static_cast<Segment>(skin[v].segment[e]);
      if (w <= 0) continue;
      const bool head = s == Segment::head;
      const bool hand = is_of(s, Segment::left_hand, Segment::right_hand);
      const bool foot = is_of(s, Segment::left_foot, Segment::right_foot);
      if (!head && !hand && !foot) continue;
      const Vec3f scale = head ? build.head : hand ? build.hand : build.foot;
      const Vec3f d = rest[v] - bones.head[static_cast<std::size_t>(s)];
      move = move + Vec3f{d.x * (scale.x - 1), d.y * (scale.y - 1), d.z * (scale.z - 1)} * w;
      if (!head) continue;
      const float up = std::clamp((rest[v].y - neck_top.y) / (crown - neck_top.y), 0.0F, 1.0F);
      move.y += w * build.crown_mm * up * up * up;
      const float back = std::clamp((neck_top.z - rest[v].z) / 80, 0.0F, 1.0F);
      move.z -= w * build.occiput_mm * back * 4 * up * (1 - up);
    }
    rest[v] = rest[v] + move;
  }
}

// Neighbours' means, except on hands and feet, which would waste away.
void smooth(const body::BodyModel& model, std::vector<Vec3f>& rest) {
  const auto skin = model.data().skin;
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  const auto kept = [&](std::size_t v) {
    const auto s = static_cast<Segment>(skin[v].segment[0]);
    return is_of(s, Segment::left_hand, Segment::right_hand) || is_of(s, Segment::left_foot, Segment::right_foot);
  };
  for (int round = 0; round < kSmoothings; ++round) {
    std::vector<Vec3f> sum(count);
    std::vector<float> neighbours(count, 0.0F);
    for (const auto& quad : model.body_quads())
      for (std::size_t i = 0; i < 4; ++i) {
        const auto a = static_cast<std::size_t>(quad[i]), b = static_cast<std::size_t>(quad[(i + 1) % 4]);
        sum[a] = sum[a] + rest[b], sum[b] = sum[b] + rest[a];
        neighbours[a] += 1, neighbours[b] += 1;
      }
    for (std::size_t v = 0; v < count; ++v)
      if (!kept(v) && neighbours[v] > 0) rest[v] = rest[v] + (sum[v] * (1 / neighbours[v]) - rest[v]) * kSmoothShare;
  }
}

std::vector<Vec3f> normals_of(const body::BodyModel& model, std::span<const Vec3f> rest) {
  std::vector<Vec3f> normal(static_cast<std::size_t>(model.body_vertex_count()));
  for (const auto& t : model.body_triangles()) {
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
std::vector<Stay> stays_of(const body::BodyModel& model) {
  const auto& d = model.data();
  std::vector<Stay> stays;
  const auto stay = [&](std::size_t list, double aside_mm, double forwards_mm) {
    const auto of = d.list_vertices.subspan(d.lists[list].first, d.lists[list].count);
    for (const auto& [axis, mm] : {std::pair{Vec3f{1, 0, 0}, aside_mm}, std::pair{Vec3f{0, 0, 1}, forwards_mm}}) {
      Stay& s = stays.emplace_back(Stay{{}, mm});
      for (const std::int32_t v : of) s.row.push_back({v, axis * (1.0F / static_cast<float>(of.size()))});
    }
  };
  const auto head = [](Segment s) { return body::kHeadLists + static_cast<std::size_t>(s); };
  const auto tail = [](Segment s) { return body::kTailLists + static_cast<std::size_t>(s); };
  for (const Segment s : {Segment::pelvis, Segment::abdomen, Segment::chest, Segment::neck, Segment::head})
    stay(head(s), 1.5, kPostureMm);
  stay(tail(Segment::head), 1.5, kPostureMm);
  for (const Segment s : {Segment::left_upper_leg, Segment::right_upper_leg, Segment::left_lower_leg,
                          Segment::right_lower_leg, Segment::left_foot, Segment::right_foot})
    stay(head(s), 8, kPostureMm);
  // How much higher one list lies than the other stays as it is.
  const auto stay_apart = [&](std::size_t upper, std::size_t lower) {
    Stay& apart = stays.emplace_back(Stay{{}, 1});
    for (const auto& [list, sign] : {std::pair{upper, 1.0F}, std::pair{lower, -1.0F}})
      for (const std::int32_t v : d.list_vertices.subspan(d.lists[list].first, d.lists[list].count))
        apart.row.push_back({v, {0, sign / static_cast<float>(d.lists[list].count), 0}});
    stays.emplace_back(Stay{{}, 1});  // pairs: aside or apart first, then forwards
  };
  // Level: the left one is not higher than the right one.
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

std::vector<PullRow> free_rows(const body::BodyModel& model, std::span<const Vec3f> rest, Rng& rng) {
  const auto normal = normals_of(model, rest);
  const auto skin = model.data().skin;
  std::vector<PullRow> rows;
  while (rows.size() < kPairs + kSingles) {
    const int v = rng.index(model.body_vertex_count());
    const auto at = static_cast<std::size_t>(v);
    const auto s = static_cast<Segment>(skin[at].segment[0]);
    if (s == Segment::head || is_of(s, Segment::left_hand, Segment::right_hand) ||
        is_of(s, Segment::left_foot, Segment::right_foot))
      continue;
    PullRow row = {{v, normal[at]}};
    if (rows.size() < kPairs) {
      const Vec3f mirrored = {-rest[at].x, rest[at].y, rest[at].z};
      std::int32_t other = v;
      for (std::int32_t o = 0; o < model.body_vertex_count(); ++o)
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

Mean make_mean(const body::BodyModel& model, const MeanBuild& build, std::uint64_t number) {
  Mean mean;
  body::Params& p = mean.params;
  p.gender = build.woman ? 0 : 1;
  p.age_years = build.age_years;
  p.muscle = build.muscle;
  p.cup = build.cup;
  p.race = build.race;
  p.modifiers.assign(model.modifier_names().size(), 0.0F);
  body::solve_stature_and_weight(model, p, build.stature_mm, build.weight_kg);
  mean.rest.resize(static_cast<std::size_t>(model.vertex_count()));
  model.morph(p, mean.rest);
  reshape_ends(model, build, mean.rest);
  std::vector<Vec3f> before = mean.rest;
  smooth(model, mean.rest);
  DeformationGraph graph(model, mean.rest);
  std::vector<Vec3f> moved(mean.rest.size());
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = mean.rest[v] - before[v];
  graph.carry_helpers(moved);
  for (std::size_t v = 0; v < moved.size(); ++v) mean.rest[v] = before[v] + moved[v];

  mean.dimensions = std::make_unique<BodyDimensions>(model, mean.rest);
  std::vector<PullRow> rows;
  mean.own = mean.dimensions->measure(mean.rest, &rows);
  for (PullRow& row : mean.dimensions->squaring_rows(mean.rest)) rows.push_back(std::move(row));
  const std::vector<Stay> stays = stays_of(model);
  for (const Stay& s : stays) rows.push_back(s.row);
  mean.free_first = static_cast<int>(rows.size());
  Rng rng = Rng::for_item(kMeanStream, kMeanStream, number);
  for (PullRow& row : free_rows(model, mean.rest, rng)) rows.push_back(std::move(row));

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
    double own = 0;
    for (const Pull& pull : row)
      own += static_cast<double>(dot(pull.gradient, response[static_cast<std::size_t>(pull.vertex)])) /
             static_cast<double>(row.size());
    mean.free_mm.push_back(own);
  }
  mean.products.resize(columns, columns);
  for (Eigen::Index i = 0; i < columns; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      mean.products(i, j) = graph.product(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  mean.stay.resize(static_cast<Eigen::Index>(stays.size()), columns);
  for (std::size_t s = 0; s < stays.size(); ++s)
    mean.stay.row(static_cast<Eigen::Index>(s)) = along_basis(mean.basis, stays[s].row) / stays[s].tolerance_mm;
  return mean;
}

void deform(const Mean& mean, const Eigen::VectorXd& c, std::span<Vec3f> rest) {
  const Eigen::VectorXf moved = mean.basis * c.cast<float>();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const auto at = static_cast<Eigen::Index>(3 * v);
    rest[v] = mean.rest[v] + Vec3f{moved[at], moved[at + 1], moved[at + 2]};
  }
}

}  // namespace im2fit::lab
