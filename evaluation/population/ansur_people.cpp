// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_people.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "body/measure.h"
#include "body/model.h"
#include "body/model_data.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "evaluation/population/deformable_mean.h"
#include "evaluation/population/dimension_solver.h"
#include "train/population/solve.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPersonStream = 0xA2501, kRowStream = 0xA2502, kShapeStream = 0xA2503;

constexpr double kIndexSpread = 1.2;  // of the border between builds, so that no border shows

constexpr SolverSteps kSteps = {12, 6, 4};

// A fixed mean mesh: the build, and the changes to the model's head, hands and feet.
struct MeanBuild {
  bool woman;
  double stature_mm, weight_kg, index_most;  // body mass index up to which it serves
  float age_years, muscle, cup;
  std::array<float, 3> race;
  Vec3f head, hand, foot;  // scales along the mesh' axes
  float crown_mm, occiput_mm;
};
constexpr std::size_t kMeanCount = 6;
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

struct BuiltMean {
  body::Params params;
  Mean mean;
};

// Some 0.8 s and 25 MB. `number`: of kMeans.
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

}  // namespace

struct AnsurPeople::State {
  const body::BodyModel& model;
  AnsurRows rows;
  AnsurSettings settings;
  std::vector<BuiltMean> means;

  const BuiltMean& mean_for(const WantedPerson& person, Rng& rng) const {
    const double metres = person.wanted[dimension_index(SurveyDimension::stature)] / 1000;
    const double index =
        person.wanted[dimension_index(SurveyDimension::weight)] / (metres * metres) + rng.normal(0, kIndexSpread);
    std::size_t m = 0;
    while (kMeans[m].woman != person.woman || index > kMeans[m].index_most) ++m;
    return means[m];
  }
};

AnsurPeople::AnsurPeople(std::unique_ptr<State> state) : state_(std::move(state)) {}
AnsurPeople::AnsurPeople(AnsurPeople&&) noexcept = default;
AnsurPeople::~AnsurPeople() = default;

Result<AnsurPeople> AnsurPeople::load(const body::BodyModel& model, const std::string& folder,
                                      const AnsurSettings& settings) {
  auto rows = AnsurRows::load(folder);
  if (!rows) return rows.error();
  std::unique_ptr<State> state(
      new State{.model = model, .rows = std::move(*rows), .settings = settings, .means = {}});
  for (std::size_t m = 0; m < kMeans.size(); ++m) state->means.push_back(make_mean(model, kMeans[m], m));
  return AnsurPeople(std::move(state));
}

Subject AnsurPeople::draw(std::uint64_t seed, std::uint64_t index, std::vector<Vec3f>& rest) const {
  return make(seed, index, rest).subject;
}

AnsurPeople::Made AnsurPeople::make(std::uint64_t seed, std::uint64_t index, std::vector<Vec3f>& rest) const {
  Made made;
  Subject& subject = made.subject;
  subject.seed = Rng::for_item(seed, kPersonStream, index).next();
  subject.family = Family::held_out;
  subject.woman = index % 2 == 1;
  Rng row_rng = Rng::for_item(subject.seed, kRowStream, 0);
  const WantedPerson person = state_->rows.draw(subject.woman, state_->settings, row_rng);
  Rng rng = Rng::for_item(subject.seed, kShapeStream, 0);
  const BuiltMean& built = state_->mean_for(person, rng);
  const Mean& mean = built.mean;
  made.wanted = person.wanted;
  draw_backs(mean, rng, made.wanted);
  const Eigen::VectorXd start = draw_free_shape(mean, rng);
  const Eigen::VectorXd posture = draw_posture(mean, rng);
  rest.resize(mean.rest.size());
  made.achieved = solve_in_pose(mean, made.wanted, start, posture, kSteps, rest, [&] {
    subject.truth = body::measure_rest_mesh(state_->model, rest, subject.woman ? 0.0F : 1.0F);
    return subject.truth;
  });

  subject.params = built.params;
  subject.params.age_years = static_cast<float>(std::clamp(person.age_years, 18.0, 90.0));
  std::vector<Vec3f> morphed(rest.size());
  state_->model.morph(subject.params, morphed);
  subject.rest_offset_mm.resize(rest.size());
  for (std::size_t v = 0; v < rest.size(); ++v) {
    subject.rest_offset_mm[v] = rest[v] - morphed[v];
    rest[v] = morphed[v] + subject.rest_offset_mm[v];
  }
  return made;
}

std::string default_ansur_folder() {
  const char* shared = std::getenv("IM2FIT_SHARED");
  return (shared != nullptr ? std::string(shared) : std::string("../shared")) + "/data/ansur2";
}

}  // namespace im2fit::lab
