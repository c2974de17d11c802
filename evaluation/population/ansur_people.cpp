// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_people.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "body/measure.h"
#include "core/rng.h"
#include "evaluation/population/ansur_means.h"
#include "evaluation/population/dimension_solver.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPersonStream = 0xA2501, kRowStream = 0xA2502, kShapeStream = 0xA2503;

constexpr double kIndexSpread = 1.2;  // of the border between builds, so that no border shows

constexpr SolverSteps kSteps = {12, 6, 4};

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
