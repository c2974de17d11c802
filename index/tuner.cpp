// SPDX-License-Identifier: Apache-2.0
#include "index/tuner.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace im2fit::index {
namespace {

constexpr std::ptrdiff_t kJudgedRowMax = 4000;        // for choices
constexpr std::ptrdiff_t kCalibrationRowMax = 10000;  // for intervals
constexpr double kQuadraticPenalty = 10;              // captures
constexpr double kInterceptPenalty = 3;               // neighbours of full weight
constexpr double kSlopePenalty = 0.02;
constexpr double kWorthwhile = 0.997;   // a costlier correction must gain three thousandths
constexpr int kSpreadNeighbours = 128;  // for the local spread when nothing else asks for neighbours
constexpr double kSmall = 1e-9;

}  // namespace

Tuner::Tuner(const TrainingRows& rows, const Eigen::MatrixXd& regressed, const Eigen::MatrixXd& entry_targets)
    : rows_(rows),
      regressed_(regressed),
      entry_targets_(entry_targets),
      entry_subject_(static_cast<std::size_t>(entry_targets.rows())),
      target_count_(static_cast<int>(regressed.cols())) {
  std::iota(entry_subject_.begin(), entry_subject_.end(), 0U);
  std::vector<int> captures(entry_subject_.size());
  for (const std::uint32_t s : rows.subject) captures_max_ = std::max(captures_max_, ++captures[s]);
}

void Tuner::run(int dimensions) {
  make_space();
  choose_dimensions(dimensions);
  fit_quadratic();
  choose_correction();
  answer_held_out();
}

Targets Tuner::row_of(const Eigen::MatrixXd& m, std::ptrdiff_t row) const {
  Targets out{};
  for (int t = 0; t < target_count_; ++t) out[t] = m(row, t);
  return out;
}

Position Tuner::position_of(const Eigen::MatrixXd& m, std::ptrdiff_t row, int dimensions) const {
  return project(row_of(m, row), target_count_, projection, dimensions);
}

std::vector<std::ptrdiff_t> Tuner::judged_rows(std::ptrdiff_t count_max) const {
  const std::ptrdiff_t stride = std::max<std::ptrdiff_t>(1, regressed_.rows() / count_max);
  std::vector<std::ptrdiff_t> out;
  for (std::ptrdiff_t i = 0; i < regressed_.rows(); i += stride) out.push_back(i);
  return out;
}

// Whitens by the error of the regression, then turns to the directions that carry most of the body: dimension d holds
// log2(body variance / error variance) / 2 bits.
void Tuner::make_space() {
  const Eigen::MatrixXd error = rows_.targets - regressed_;
  const auto n = static_cast<double>(error.rows());
  Eigen::MatrixXd noise = error.transpose() * error / n;
  const Eigen::MatrixXd signal =
      entry_targets_.transpose() * entry_targets_ / static_cast<double>(entry_targets_.rows());
  noise.diagonal().array() += 1e-6 + 1e-3 * noise.diagonal().array();
  const Eigen::LLT<Eigen::MatrixXd> factor(noise);
  const auto lower = factor.matrixL();
  const Eigen::MatrixXd half = lower.solve(signal);
  const Eigen::MatrixXd whitened = lower.solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (whitened + whitened.transpose()));
  const Eigen::MatrixXd inverse = lower.solve(Eigen::MatrixXd::Identity(target_count_, target_count_));
  full_projection_.resize(target_count_, target_count_);
  for (int d = 0; d < target_count_; ++d) {
    const int from = target_count_ - 1 - d;  // ascending order
    full_projection_.row(d) = eigen.eigenvectors().col(from).transpose() * inverse;
    if (d < kDimensionMax)
      dimension_bits[d] = static_cast<float>(0.5 * std::log2(std::max(eigen.eigenvalues()(from), 1.0)));
  }
  projection.clear();
  for (int d = 0; d < target_count_; ++d)
    for (int t = 0; t < target_count_; ++t) projection.push_back(static_cast<float>(full_projection_(d, t)));
}

void Tuner::choose_dimensions(int wanted) {
  const int all = std::min(target_count_, kDimensionMax);
  int chosen = std::min(wanted, all);
  if (wanted <= 0) {
    std::vector<std::pair<int, double>> errors;
    for (const int d : {6, 8, 10, 12, all}) {
      if (d > all || (!errors.empty() && errors.back().first == d)) continue;
      encode(d);
      errors.emplace_back(d, nearest_entry_error(d));
    }
    double best = 1e300;
    for (const auto& [d, e] : errors) best = std::min(best, e);
    for (const auto& [d, e] : errors)
      if (e <= best / kWorthwhile) {  // fewest dimensions: the tree prunes better
        chosen = d;
        break;
      }
  }
  encode(chosen);
  meta.dimensions = static_cast<std::uint32_t>(chosen);
  projection.resize(static_cast<std::size_t>(chosen) * static_cast<std::size_t>(target_count_));
}

// A dimension of wide spread gets long steps: all dimensions use the 8 bits, and distances stay those of the space.
void Tuner::encode(int dimensions) {
  std::vector<double> range(static_cast<std::size_t>(dimensions), kSmall);
  std::vector<double> square(static_cast<std::size_t>(dimensions), kSmall);
  for (std::ptrdiff_t i = 0; i < regressed_.rows(); ++i) {
    const Position p = position_of(regressed_, i, dimensions);
    for (int d = 0; d < dimensions; ++d) {
      range[d] = std::max(range[d], std::abs(p[d]));
      square[d] += p[d] * p[d] / static_cast<double>(regressed_.rows());
    }
  }
  inverse_spread.clear();
  for (int d = 0; d < dimensions; ++d) {
    const double spread = std::sqrt(square[d]);
    inverse_spread.push_back(static_cast<float>(1 / std::max(spread, 1e-3)));
    range[d] = std::min(range[d], 6 * spread);
  }
  meta.grid_unit = std::max(*std::max_element(range.begin(), range.end()), 1e-3) / (127.0 * kStepMax);
  steps = {};
  for (int d = 0; d < dimensions; ++d)
    steps[d] = std::clamp(static_cast<int>(std::ceil(range[d] / 127 / meta.grid_unit)), 1, kStepMax);
  const auto code = [&](const Eigen::MatrixXd& m, std::vector<std::int8_t>& out) {
    out.assign(static_cast<std::size_t>(m.rows()) * kDimensionMax, 0);
    for (std::ptrdiff_t i = 0; i < m.rows(); ++i) {
      const Position p = position_of(m, i, dimensions);
      for (int d = 0; d < dimensions; ++d)
        out[static_cast<std::size_t>(i) * kDimensionMax + static_cast<std::size_t>(d)] =
            static_cast<std::int8_t>(std::lround(std::clamp(p[d] / (meta.grid_unit * steps[d]), -127.0, 127.0)));
    }
  };
  code(regressed_, point_code);
  code(entry_targets_, entry_code);
}

// The nearest `count` points of other subjects.
std::span<Neighbour> Tuner::neighbours_of(CodeSearch& search, std::ptrdiff_t row, const Coordinates& grid,
                                          std::span<const std::uint32_t> subject, int count) const {
  const std::uint32_t own = rows_.subject[static_cast<std::size_t>(row)];
  const auto found = search.nearest(grid, static_cast<std::size_t>(count) + static_cast<std::size_t>(captures_max_));
  const auto end =
      std::remove_if(found.begin(), found.end(), [&](const Neighbour& n) { return subject[n.index] == own; });
  return found.first(
      std::min<std::size_t>(static_cast<std::size_t>(end - found.begin()), static_cast<std::size_t>(count)));
}

double Tuner::nearest_entry_error(int dimensions) const {
  const CodeTree tree(entry_code, steps);
  CodeSearch search(tree, static_cast<std::size_t>(1 + captures_max_));
  double sum = 0;
  for (const std::ptrdiff_t i : judged_rows(kJudgedRowMax)) {
    const Coordinates grid = to_grid(position_of(regressed_, i, dimensions), dimensions, meta.grid_unit);
    const auto found = neighbours_of(search, i, grid, entry_subject_, 1);
    for (int t = 0; !found.empty() && t < kTargetMin; ++t)
      sum += std::abs(entry_targets_(found[0].index, t) - rows_.targets(i, t));
  }
  return sum;
}

// A global quadratic surface over the projected space, for what a linear map of the features cannot bend to.
void Tuner::fit_quadratic() {
  const int dimensions = static_cast<int>(meta.dimensions);
  const int terms = quadratic_term_count(dimensions);
  const Eigen::MatrixXd residual = rows_.targets - regressed_;
  RowMatrixF phi(regressed_.rows(), terms);
  std::vector<double> buffer(static_cast<std::size_t>(terms));
  for (std::ptrdiff_t i = 0; i < phi.rows(); ++i) {
    quadratic_terms(position_of(regressed_, i, dimensions), inverse_spread, dimensions, buffer);
    for (int k = 0; k < terms; ++k) phi(i, k) = static_cast<float>(buffer[static_cast<std::size_t>(k)]);
  }
  std::vector<Eigen::MatrixXd> gram(static_cast<std::size_t>(rows_.fold_count), Eigen::MatrixXd::Zero(terms, terms));
  std::vector<Eigen::MatrixXd> cross(gram.size(), Eigen::MatrixXd::Zero(terms, target_count_));
  for (std::ptrdiff_t i = 0; i < phi.rows(); ++i) {
    const auto f = static_cast<std::size_t>(rows_.fold[static_cast<std::size_t>(i)]);
    const Eigen::VectorXd x = phi.row(i).cast<double>();
    gram[f].selfadjointView<Eigen::Lower>().rankUpdate(x);
    cross[f] += x * residual.row(i);
  }
  const auto solve = [&](int without) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(terms, terms) * kQuadraticPenalty;
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(terms, target_count_);
    for (int f = 0; f < rows_.fold_count; ++f) {
      if (f == without) continue;
      a += gram[static_cast<std::size_t>(f)];
      b += cross[static_cast<std::size_t>(f)];
    }
    return Eigen::MatrixXd(a.selfadjointView<Eigen::Lower>().llt().solve(b));
  };
  quadratic_correction_.resize(regressed_.rows(), target_count_);
  std::vector<Eigen::MatrixXd> fits;
  fits.reserve(static_cast<std::size_t>(rows_.fold_count));
  for (int f = 0; f < rows_.fold_count; ++f) fits.push_back(solve(f));
  for (std::ptrdiff_t i = 0; i < phi.rows(); ++i)
    quadratic_correction_.row(i) =
        phi.row(i).cast<double>() * fits[static_cast<std::size_t>(rows_.fold[static_cast<std::size_t>(i)])];
  const Eigen::MatrixXd all = solve(-1);
  quadratic.clear();
  for (int t = 0; t < target_count_; ++t)
    for (int k = 0; k < terms; ++k) quadratic.push_back(static_cast<float>(all(k, t)));
  meta.quadratic = 0;
  for (int t = 0; t < target_count_; ++t) {
    const double before = residual.col(t).cwiseAbs().sum();
    const double after = (residual.col(t) - quadratic_correction_.col(t)).cwiseAbs().sum();
    if (after < before * kWorthwhile) {
      meta.quadratic = 1;
      continue;
    }
    quadratic_correction_.col(t).setZero();
    std::fill_n(quadratic.begin() + t * terms, terms, 0.0F);
  }
}

void Tuner::set_residuals(const Eigen::MatrixXd& residuals) {
  residual_scale.assign(static_cast<std::size_t>(target_count_), 0);
  point_residual.resize(static_cast<std::size_t>(residuals.size()));
  for (int t = 0; t < target_count_; ++t) {
    const double scale = std::max(residuals.col(t).cwiseAbs().maxCoeff(), kSmall) / 32767;
    residual_scale[static_cast<std::size_t>(t)] = static_cast<float>(scale);
    for (std::ptrdiff_t i = 0; i < residuals.rows(); ++i)
      point_residual[static_cast<std::size_t>(i * target_count_ + t)] =
          static_cast<std::int16_t>(std::lround(residuals(i, t) / scale));
  }
}

// Absolute error of each judged row (rows) and target (columns).
Eigen::MatrixXd Tuner::local_errors(const CodeTree& tree, const Eigen::MatrixXd& base, const LocalOptions& options,
                                    int count) const {
  const int dimensions = static_cast<int>(meta.dimensions);
  const LocalData data{point_code, steps, dimensions, point_residual, residual_scale, target_count_, target_count_};
  CodeSearch search(tree, static_cast<std::size_t>(count) + static_cast<std::size_t>(captures_max_));
  const auto judged = judged_rows(kJudgedRowMax);
  Eigen::MatrixXd out(static_cast<std::ptrdiff_t>(judged.size()), target_count_);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const std::ptrdiff_t i = judged[k];
    const Coordinates grid = to_grid(position_of(regressed_, i, dimensions), dimensions, meta.grid_unit);
    const LocalAnswer local =
        local_regression(data, grid, neighbours_of(search, i, grid, rows_.subject, count), options);
    for (int t = 0; t < target_count_; ++t)
      out(static_cast<std::ptrdiff_t>(k), t) = std::abs(base(i, t) + local.correction[t] - rows_.targets(i, t));
  }
  return out;
}

// Each target takes the local correction only where it is better beyond chance (two standard errors of the paired
// difference): over a straight world it would only add noise.
void Tuner::choose_correction() {
  const Eigen::MatrixXd base = regressed_ + quadratic_correction_;
  set_residuals(rows_.targets - base);
  const CodeTree tree(point_code, steps);
  const int available = static_cast<int>(std::min<std::ptrdiff_t>(kNeighbourMax, regressed_.rows() / 2));
  struct Candidate {
    LocalMethod method;
    int neighbours;
  };
  meta.local_method = static_cast<std::uint32_t>(LocalMethod::none);
  meta.neighbour_count = static_cast<std::uint32_t>(std::clamp(kSpreadNeighbours, 1, std::max(available, 1)));
  meta.intercept_penalty = kInterceptPenalty;
  meta.slope_penalty = kSlopePenalty;
  const Eigen::MatrixXd plain = local_errors(tree, base, {}, 1);
  const auto n = static_cast<double>(plain.rows());
  double best = 0;
  for (const Candidate c : {Candidate{LocalMethod::mean, 32},
                            {LocalMethod::mean, 128},
                            {LocalMethod::linear, 256},
                            {LocalMethod::linear, kNeighbourMax}}) {
    if (c.neighbours > available) continue;
    const Eigen::MatrixXd gain =
        plain - local_errors(tree, base, {c.method, kInterceptPenalty, kSlopePenalty}, c.neighbours);
    std::uint32_t mask = 0;
    double total = 0;
    for (int t = 0; t < target_count_; ++t) {
      const double mean = gain.col(t).mean();
      const double error = std::sqrt((gain.col(t).array() - mean).square().sum() / (n * std::max(n - 1, 1.0)));
      if (mean <= 2 * error) continue;
      mask |= 1U << t;
      total += t < kTargetMin ? mean : 0;
    }
    if (total <= best) continue;
    best = total;
    meta.local_method = static_cast<std::uint32_t>(c.method);
    meta.local_targets = mask;
    meta.neighbour_count = static_cast<std::uint32_t>(c.neighbours);
  }
}

void Tuner::answer_held_out() {
  const int dimensions = static_cast<int>(meta.dimensions);
  const LocalData data{point_code, steps, dimensions, point_residual, residual_scale, target_count_, target_count_};
  const LocalOptions options{static_cast<LocalMethod>(meta.local_method), meta.intercept_penalty, meta.slope_penalty};
  const CodeTree points(point_code, steps);
  const CodeTree entries(entry_code, steps);
  CodeSearch near_points(points, static_cast<std::size_t>(static_cast<int>(meta.neighbour_count) + captures_max_));
  CodeSearch near_entries(entries, static_cast<std::size_t>(1 + captures_max_));
  const auto judged = judged_rows(kCalibrationRowMax);
  for (const std::ptrdiff_t i : judged) {
    HeldOut row;
    row.subject = rows_.subject[static_cast<std::size_t>(i)];
    row.frame_count = rows_.frame_count[static_cast<std::size_t>(i)];
    row.truth = row_of(rows_.targets, i);
    row.answer = row_of(regressed_, i);
    const Coordinates grid = to_grid(position_of(regressed_, i, dimensions), dimensions, meta.grid_unit);
    const LocalAnswer local = local_regression(
        data, grid, neighbours_of(near_points, i, grid, rows_.subject, static_cast<int>(meta.neighbour_count)),
        options);
    for (int t = 0; t < target_count_; ++t)
      row.answer[t] +=
          quadratic_correction_(i, t) + ((meta.local_targets >> t & 1U) != 0 ? local.correction[t] : 0.0);
    row.spread = local.spread;
    const Coordinates key =
        to_grid(project(row.answer, target_count_, projection, dimensions), dimensions, meta.grid_unit);
    const auto nearest = neighbours_of(near_entries, i, key, entry_subject_, 1);
    for (std::size_t m = 0; !nearest.empty() && m < kMeasurementCount; ++m)
      nearest_error[m] +=
          static_cast<float>(std::abs(entry_targets_(nearest[0].index, static_cast<int>(m)) - row.truth[m]) /
                             static_cast<double>(judged.size()));
    held_out.push_back(row);
  }
}

}  // namespace im2fit::index
