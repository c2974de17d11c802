// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_means.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "body/model_data.h"
#include "body/skeleton.h"
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

}  // namespace

BuiltMean make_mean(const body::BodyModel& model, const MeanBuild& build, std::uint64_t number) {
  BuiltMean built;
  Mean& mean = built.mean;
  body::Params& p = built.params;
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

  complete_mean(mean, surface_of(model), graph, number);
  return built;
}

}  // namespace im2fit::lab
