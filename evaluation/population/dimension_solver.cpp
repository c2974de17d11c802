// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/dimension_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace im2fit::lab {
namespace {

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

// Squared tolerance of the energy against the dimensions': 1 of energy costs as much as 1 / kEnergySd tolerances.
constexpr double kEnergySd = 40;
constexpr double kBreadthOfGirth = 0.4;  // at the chest

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

DimensionValues solve_dimensions(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                                 const Eigen::VectorXd& posture, int steps, Eigen::VectorXd& c,
                                 std::span<Vec3f> rest) {
  return Solver(mean, wanted, start, posture, rest).run(steps, c);
}

DimensionValues solve_in_pose(const Mean& mean, const DimensionValues& wanted, const Eigen::VectorXd& start,
                              const Eigen::VectorXd& posture, const SolverSteps& steps, std::span<Vec3f> rest,
                              const std::function<MeasurementValues()>& measure) {
  DimensionValues goal = wanted, achieved{};
  const auto of = [](DimensionValues& values, SurveyDimension d) -> double& { return values[dimension_index(d)]; };
  const auto wanted_of = [&](SurveyDimension d) { return wanted[dimension_index(d)]; };
  Eigen::VectorXd c = start;
  for (int round = 0; round < steps.rounds; ++round) {
    achieved = solve_dimensions(mean, goal, start, posture, round == 0 ? steps.first : steps.more, c, rest);
    const MeasurementValues measured = measure();
    const auto more_at_rest = [&](SurveyDimension d, Measurement m) {
      return of(achieved, d) - static_cast<double>(measured[measurement_index(m)]);
    };
    const double chest_mm = more_at_rest(SurveyDimension::chest_girth, Measurement::chest_girth);
    of(goal, SurveyDimension::chest_girth) = wanted_of(SurveyDimension::chest_girth) + chest_mm;
    of(goal, SurveyDimension::chest_breadth) = wanted_of(SurveyDimension::chest_breadth) + kBreadthOfGirth * chest_mm;
    of(goal, SurveyDimension::acromion_breadth) =
        wanted_of(SurveyDimension::acromion_breadth) +
        more_at_rest(SurveyDimension::acromion_breadth, Measurement::shoulder_breadth);
  }
  return achieved;
}

const std::array<DimensionInfo, kSurveyDimensionCount>& dimension_table() {
  return kTable;
}

}  // namespace im2fit::lab
