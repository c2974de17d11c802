// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_people.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "body/measure.h"
#include "core/rng.h"
#include "evaluation/population/ansur_means.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPersonStream = 0xA2501, kRowStream = 0xA2502, kShapeStream = 0xA2503;

// Tolerances: the dimensions a camera sees best must be met; joints inside are not the survey's landmarks.
constexpr std::array<DimensionInfo, kSurveyDimensionCount> kTable = {{
    {"stature", 1},        {"cervicale height", 3}, {"acromial height", 8},   {"chest height", 2},
    {"waist height", 2},   {"buttock height", 3},   {"crotch height", 1.5},   {"trochanter height", 8},
    {"knee height", 5},    {"chest breadth", 4},    {"chest depth", 1},       {"chest girth", 2},
    {"chest back", 3},     {"waist breadth", 1},    {"waist depth", 1},       {"waist girth", 2},
    {"waist back", 3},     {"hip breadth", 1},      {"hip depth", 1},         {"hip girth", 2},
    {"hip back", 3},       {"neck girth", 1.5},     {"thigh girth", 2},       {"lower thigh girth", 2},
    {"calf girth", 1.5},   {"ankle girth", 2},      {"upper arm girth", 1.5}, {"forearm girth", 1.5},
    {"wrist girth", 1.5},  {"acromion breadth", 4}, {"deltoid breadth", 3},   {"upper arm length", 5},
    {"forearm length", 5}, {"hand length", 5},      {"head breadth", 1.5},    {"head length", 2},
    {"crown height", 4},   {"foot length", 3},      {"foot breadth", 3},      {"weight", 1.2},
}};

constexpr double kIndexSpread = 1.2;  // of the border between builds, so that no border shows

constexpr double kPairMm = 5, kSingleMm = 2;  // of kPairs and kSingles
// How far the back lies behind the sides, as a share of the depth: SD about the mean mesh'. The survey is silent.
constexpr double kBackShareSd = 0.05;
// Squared tolerance of the energy against the dimensions': 1 of energy costs as much as 1 / kEnergySd tolerances.
constexpr double kEnergySd = 40;
constexpr int kSteps = 12, kMoreSteps = 6, kRounds = 4;
constexpr double kBreadthOfGirth = 0.4;  // at the chest
constexpr double kPostureSd = 0.8;       // of kPostureMm: what people vary by

// Least energy about `start` plus squared misses of the dimensions and of joints that stay, in tolerances:
// Levenberg and Marquardt, since a hull's points change as it moves.
class Solver {
 public:
  Solver(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
         const Eigen::VectorXd& posture, std::span<Vec3f> rest)
      : mean_(mean),
        wanted_(wanted),
        start_(start),
        posture_(posture),
        rest_(rest),
        energy_(mean.products / (kEnergySd * kEnergySd)) {}

  // From `c` on, which becomes the answer.
  DimensionValues run(int steps, Eigen::VectorXd& c) {
    double damping = 1;
    double cost = measure(c);
    for (int step = 0; step < steps; ++step) {
      Eigen::MatrixXd normal = energy_;
      Eigen::VectorXd right = energy_ * (start_ - c);
      normal.noalias() += mean_.stay.transpose() * mean_.stay;
      right += mean_.stay.transpose() * (posture_ - mean_.stay * c);
      for (std::size_t d = 0; d < kSurveyDimensionCount; ++d) {
        if (!std::isfinite(wanted_[d])) continue;
        const Eigen::RowVectorXd along = along_basis(mean_.basis, rows_[d]) / kTable[d].tolerance;
        normal.noalias() += along.transpose() * along;
        right += along.transpose() * miss(d);
      }
      const DimensionValues before = now_;
      while (true) {
        const Eigen::MatrixXd damped =
            normal + damping * energy_ + 1e-9 * Eigen::MatrixXd::Identity(normal.rows(), normal.cols());
        const Eigen::VectorXd next = c + damped.ldlt().solve(right);
        const double cost_next = measure(next);
        if (cost_next < cost) {
          const bool done = cost_next > 0.995 * cost;
          c = next;
          cost = cost_next;
          damping *= 0.2;
          if (done) step = steps;
          break;
        }
        damping = std::max(damping, 1e-3) * 8;
        if (damping > 1e6) {
          deform(mean_, c, rest_);
          return before;
        }
      }
    }
    return now_;
  }

 private:
  double miss(std::size_t d) const { return (wanted_[d] - now_[d]) / kTable[d].tolerance; }
  double measure(const Eigen::VectorXd& c) {
    deform(mean_, c, rest_);
    now_ = mean_.dimensions->measure(rest_, &rows_);
    const Eigen::VectorXd off = c - start_;
    double cost = off.dot(energy_ * off) + (mean_.stay * c - posture_).squaredNorm();
    for (std::size_t d = 0; d < kSurveyDimensionCount; ++d)
      if (std::isfinite(wanted_[d])) cost += miss(d) * miss(d);
    return cost;
  }

  const Mean& mean_;
  const DimensionValues& wanted_;
  const Eigen::VectorXd& start_;
  const Eigen::VectorXd& posture_;
  std::span<Vec3f> rest_;
  Eigen::MatrixXd energy_;
  DimensionValues now_{};
  std::vector<PullRow> rows_;
};

}  // namespace

struct AnsurPeople::State {
  const body::BodyModel& model;
  AnsurRows rows;
  AnsurSettings settings;
  std::vector<Mean> means;

  const Mean& mean_for(const WantedPerson& person, Rng& rng) const {
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
  const Mean& mean = state_->mean_for(person, rng);
  made.wanted = person.wanted;
  for (const auto& [back, depth] : {std::pair{SurveyDimension::chest_back, SurveyDimension::chest_depth},
                                    std::pair{SurveyDimension::waist_back, SurveyDimension::waist_depth},
                                    std::pair{SurveyDimension::hip_back, SurveyDimension::hip_depth}}) {
    const double share = mean.own[dimension_index(back)] / mean.own[dimension_index(depth)];
    made.wanted[dimension_index(back)] =
        (share + std::clamp(rng.normal(), -2.5, 2.5) * kBackShareSd) * made.wanted[dimension_index(depth)];
  }
  Eigen::VectorXd start = Eigen::VectorXd::Zero(mean.products.rows());
  for (std::size_t f = 0; f < mean.free_mm.size(); ++f) {
    const double mm = std::clamp(rng.normal(), -2.5, 2.5) * (f < kPairs ? kPairMm : kSingleMm);
    start[mean.free_first + static_cast<Eigen::Index>(f)] = mm / mean.free_mm[f];
  }
  Eigen::VectorXd posture = Eigen::VectorXd::Zero(mean.stay.rows());
  for (Eigen::Index s = 1; s < posture.size(); s += 2) posture[s] = kPostureSd * std::clamp(rng.normal(), -2.5, 2.5);
  rest.resize(mean.rest.size());
  // Chest and shoulders change as the arms come down from the rest pose. The wanted dimensions are those of the
  // measured pose.
  DimensionValues goal = made.wanted;
  const auto of = [](DimensionValues& values, SurveyDimension d) -> double& { return values[dimension_index(d)]; };
  Eigen::VectorXd c = start;
  for (int round = 0; round < kRounds; ++round) {
    made.achieved = Solver(mean, goal, start, posture, rest).run(round == 0 ? kSteps : kMoreSteps, c);
    subject.truth = body::measure_rest_mesh(state_->model, rest, subject.woman ? 0.0F : 1.0F);
    const auto more_at_rest = [&](SurveyDimension d, Measurement m) {
      return of(made.achieved, d) - static_cast<double>(subject.truth[measurement_index(m)]);
    };
    const double chest_mm = more_at_rest(SurveyDimension::chest_girth, Measurement::chest_girth);
    of(goal, SurveyDimension::chest_girth) = of(made.wanted, SurveyDimension::chest_girth) + chest_mm;
    of(goal, SurveyDimension::chest_breadth) =
        of(made.wanted, SurveyDimension::chest_breadth) + kBreadthOfGirth * chest_mm;
    of(goal, SurveyDimension::acromion_breadth) =
        of(made.wanted, SurveyDimension::acromion_breadth) +
        more_at_rest(SurveyDimension::acromion_breadth, Measurement::shoulder_breadth);
  }

  subject.params = mean.params;
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

const std::array<DimensionInfo, kSurveyDimensionCount>& dimension_table() {
  return kTable;
}

}  // namespace im2fit::lab
