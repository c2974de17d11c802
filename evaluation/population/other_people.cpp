// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/other_people.h"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "body/model_data.h"
#include "core/rng.h"
#include "evaluation/population/dimension_solver.h"
#include "evaluation/population/other_tape.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPersonStream = 0x07E201, kRowStream = 0x07E202, kShapeStream = 0x07E203;
constexpr std::uint64_t kMeanNumber = 0x07E2;  // of the mean's places of free shape

constexpr SolverSteps kSteps = {14, 6, 3};

// What the survey takes where this mesh has no such place: a web joins the thighs down to 77 mm below the survey's
// crotch, which is above the level of its thigh girth; hands are fists; there are no ears.
constexpr std::array kLeftFree = {SurveyDimension::crotch_height, SurveyDimension::thigh_girth,
                                  SurveyDimension::hand_length, SurveyDimension::crown_height};

}  // namespace

struct OtherPeople::State {
  AnsurRows rows;
  AnsurSettings settings;
  OtherRig rig;
  Mean mean;
};

OtherPeople::OtherPeople(std::unique_ptr<State> state) : state_(std::move(state)) {}
OtherPeople::OtherPeople(OtherPeople&&) noexcept = default;
OtherPeople::~OtherPeople() = default;

Result<OtherPeople> OtherPeople::load(const std::string& mesh_folder, const std::string& survey_folder,
                                      const AnsurSettings& settings) {
  auto mesh = read_other_mesh(other_mesh_file(mesh_folder));
  if (!mesh) return mesh.error();
  auto rows = AnsurRows::load(survey_folder);
  if (!rows) return rows.error();
  for (const auto& [low, high] : kOtherBands)
    if (rows->count_between(false, low, high) == 0)
      return Error{ErrorCode::corrupt,
                   fmt::format("{}: no man of a body mass index of {} to {}", survey_folder, low, high)};
  std::unique_ptr<State> state(
      new State{.rows = std::move(*rows), .settings = settings, .rig = make_other_rig(*mesh), .mean = {}});
  state->mean.rest = std::move(mesh->vertices);
  const auto navel = static_cast<std::size_t>(body::Landmark::navel);
  DeformationGraph graph(mesh->triangles, state->mean.rest, state->rig.parts.landmarks[navel]);
  complete_mean(state->mean, state->rig.parts, graph, kMeanNumber);
  return OtherPeople(std::move(state));
}

Subject OtherPeople::draw(std::uint64_t seed, std::uint64_t index) const {
  return make(seed, index).subject;
}

OtherPeople::Made OtherPeople::make(std::uint64_t seed, std::uint64_t index) const {
  Made made;
  Subject& subject = made.subject;
  subject.seed = Rng::for_item(seed, kPersonStream, index).next();
  subject.family = Family::held_out;
  subject.woman = false;
  const auto& [low, high] = kOtherBands[index % kOtherBands.size()];
  Rng row_rng = Rng::for_item(subject.seed, kRowStream, 0);
  const WantedPerson person = state_->rows.draw_between(false, low, high, state_->settings, row_rng);
  const Mean& mean = state_->mean;
  made.wanted = person.wanted;
  for (const SurveyDimension d : kLeftFree)
    made.wanted[dimension_index(d)] = std::numeric_limits<double>::quiet_NaN();
  Rng rng = Rng::for_item(subject.seed, kShapeStream, 0);
  draw_backs(mean, rng, made.wanted);
  const Eigen::VectorXd start = draw_free_shape(mean, rng);
  const Eigen::VectorXd posture = draw_posture(mean, rng);

  auto actor = std::make_shared<Actor>();
  actor->surface = state_->rig.surface;
  actor->rest = mean.rest;
  made.achieved = solve_in_pose(mean, made.wanted, start, posture, kSteps, actor->rest, [&] {
    actor->skeleton = bones_of(state_->rig.parts, actor->rest);
    subject.truth = measure_actor(*actor, state_->rig.parts);
    return subject.truth;
  });
  subject.params.gender = 1;
  subject.params.age_years = static_cast<float>(std::clamp(person.age_years, 18.0, 90.0));
  subject.actor = std::move(actor);
  return made;
}

const OtherRig& OtherPeople::rig() const {
  return state_->rig;
}

std::size_t OtherPeople::rows_in_band(std::size_t band) const {
  return state_->rows.count_between(false, kOtherBands[band][0], kOtherBands[band][1]);
}

}  // namespace im2fit::lab
