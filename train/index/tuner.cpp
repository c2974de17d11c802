// SPDX-License-Identifier: Apache-2.0
#include "train/index/tuner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "train/common/linear_algebra.h"
#include "train/index/tree_packing.h"

namespace im2fit::index {
namespace {

constexpr std::ptrdiff_t kJudgedRowMax = 4000;        // for choices
constexpr std::ptrdiff_t kCalibrationRowMax = 10000;  // for intervals
constexpr double kQuadraticPenalty = 10;              // captures
constexpr double kInterceptPenalty = 3;               // neighbours of full weight
constexpr double kSlopePenalty = 0.02;
constexpr double kWorthwhile = 0.997;  // a costlier correction must gain three thousandths
constexpr int kNeighbours = 32;        // for the local spread and the nearest body when no correction needs more
constexpr double kResidualStep = 0.5;  // standard deviations
constexpr double kSmall = 1e-9;

std::vector<float> row_major(const Eigen::MatrixXd& m) {
  std::vector<float> out;
  for (std::ptrdiff_t i = 0; i < m.rows(); ++i)
    for (std::ptrdiff_t j = 0; j < m.cols(); ++j) out.push_back(static_cast<float>(m(i, j)));
  return out;
}

}  // namespace

// All rows as entries of an index.
struct Tuner::Trial {
  PackedTree packed;
  CodeTree tree;
  std::vector<std::uint8_t> residuals;
  CodeSearch search;
  Trial(PackedTree p, const std::vector<std::uint8_t>& unordered, std::size_t count_max)
      : packed(std::move(p)),
        tree(packed.view()),
        residuals(in_order(unordered, packed.dimension_count, packed.order)),
        search(tree, count_max) {}
};

Tuner::Tuner(const TrainingRows& rows, const Eigen::MatrixXd& regressed)
    : rows_(rows), regressed_(regressed), target_count_(static_cast<int>(regressed.cols())) {
  int captures = 0;
  for (std::size_t i = 0; i < rows.subject.size(); ++i) {
    captures = i > 0 && rows.subject[i] == rows.subject[i - 1] ? captures + 1 : 1;
    captures_max_ = std::max(captures_max_, captures);
  }
  encoder.target_count = target_count_;
}

void Tuner::run(int dimensions) {
  make_space();
  choose_dimensions(dimensions);
  make_maps();
  fit_quadratic();
  scale_residuals();
  choose_correction();
  answer_held_out();
}

Targets Tuner::row_of(const Eigen::MatrixXd& m, std::ptrdiff_t row) const {
  Targets out{};
  for (int t = 0; t < target_count_; ++t) out[t] = m(row, t);
  return out;
}

Coordinates Tuner::grid_of(std::ptrdiff_t row) const {
  return to_grid(regressed_place(row), encoder.dimensions, encoder.grid_unit);
}

std::vector<std::ptrdiff_t> Tuner::judged_rows(std::ptrdiff_t count_max) const {
  const std::ptrdiff_t stride = std::max<std::ptrdiff_t>(1, regressed_.rows() / count_max);
  std::vector<std::ptrdiff_t> out;
  for (std::ptrdiff_t i = 0; i < regressed_.rows(); i += stride) out.push_back(i);
  return out;
}

Tuner::Trial Tuner::trial() const {
  Entries entries(encoder);
  for (std::ptrdiff_t i = 0; i < regressed_.rows(); ++i) entries.add(regressed_place(i), true_place(i));
  return Trial(pack_tree(entries.codes, encoder.dimensions, encoder.steps), entries.residuals,
               static_cast<std::size_t>(kNeighbourMax + captures_max_));
}

// Whitens by the error of the regression, then turns to the directions that carry most of the body: dimension d holds
// log2(body variance / error variance) / 2 bits.
void Tuner::make_space() {
  const auto n = static_cast<double>(regressed_.rows());
  const Eigen::MatrixXd error = rows_.targets - regressed_;
  Eigen::MatrixXd noise = lab::transposed_product(error, error) / n;
  signal_covariance_ = lab::transposed_product(rows_.targets, rows_.targets) / n;
  noise.diagonal().array() += 1e-6 + 1e-3 * noise.diagonal().array();
  error_covariance_ = noise;
  const Eigen::MatrixXd inverse = lab::inverse_factor(noise);
  const Eigen::MatrixXd whitened = lab::product(lab::product(inverse, signal_covariance_), inverse.transpose());
  const lab::SymmetricEigen eigen = lab::symmetric_eigen(0.5 * (whitened + whitened.transpose()));
  full_projection_.resize(target_count_, target_count_);
  for (int d = 0; d < target_count_; ++d) {
    const int from = target_count_ - 1 - d;  // ascending order
    full_projection_.row(d) = lab::transposed_product(eigen.vectors.col(from), inverse);
    if (d < kDimensionMax) dimension_bits[d] = static_cast<float>(0.5 * std::log2(std::max(eigen.values(from), 1.0)));
  }
}

void Tuner::choose_dimensions(int wanted) {
  const int all = std::min(target_count_, kDimensionMax);
  int chosen = std::min(wanted, all);
  if (wanted <= 0) {
    std::vector<std::pair<int, double>> errors;
    // Twelve would take three bytes more an entry: 24.7 in all at 50,000.
    for (const int d : {6, 8, 10}) {
      const int tried = std::min(d, all);
      if (!errors.empty() && errors.back().first == tried) continue;
      scale_codes(tried);
      Trial entries = trial();
      errors.emplace_back(tried, nearest_entry_error(entries));
    }
    double best = 1e300;
    for (const auto& [d, e] : errors) best = std::min(best, e);
    for (const auto& [d, e] : errors)
      if (e <= best / kWorthwhile) {  // fewest dimensions: the boxes prune better
        chosen = d;
        break;
      }
  }
  scale_codes(chosen);
  meta.dimensions = static_cast<std::uint32_t>(chosen);
}

// A dimension of wide spread gets long steps: all dimensions use the 8 bits, and distances stay those of the space.
void Tuner::scale_codes(int dimensions) {
  encoder.dimensions = dimensions;
  encoder.projection = row_major(full_projection_.topRows(dimensions));
  encoder.residual_scale.assign(static_cast<std::size_t>(dimensions), static_cast<float>(kResidualStep));
  const auto used = static_cast<std::size_t>(dimensions);
  std::vector<double> range(used, kSmall), square(used, kSmall);
  for (std::ptrdiff_t i = 0; i < regressed_.rows(); ++i) {
    const Position p = regressed_place(i);
    for (std::size_t d = 0; d < used; ++d) {
      range[d] = std::max(range[d], std::abs(p[d]));
      square[d] += p[d] * p[d] / static_cast<double>(regressed_.rows());
    }
  }
  encoder.inverse_spread.clear();
  for (std::size_t d = 0; d < used; ++d) {
    const double spread = std::sqrt(square[d]);
    encoder.inverse_spread.push_back(static_cast<float>(1 / std::max(spread, 1e-3)));
    range[d] = std::min(1.1 * range[d], 6 * spread);  // more entries than these rows will reach farther
  }
  encoder.grid_unit = std::max(*std::max_element(range.begin(), range.end()), 1e-3) / (127.0 * kStepMax);
  encoder.steps = {};
  for (std::size_t d = 0; d < used; ++d)
    encoder.steps[d] = std::clamp(static_cast<int>(std::ceil(range[d] / 127 / encoder.grid_unit)), 1, kStepMax);
  meta.grid_unit = encoder.grid_unit;
}

// How errors and places of the projected space show in the targets: least squares over the people learned from.
void Tuner::make_maps() {
  const Eigen::MatrixXd p = full_projection_.topRows(encoder.dimensions);
  const auto map = [&](const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd along = lab::product(p, covariance);
    return Eigen::MatrixXd(lab::solve_positive(lab::product(along, p.transpose()), along).transpose());
  };
  error_map = row_major(map(error_covariance_));
  const Eigen::MatrixXd ridged = signal_covariance_ + 1e-9 * Eigen::MatrixXd::Identity(target_count_, target_count_);
  place_map = row_major(map(ridged));
}

void Tuner::scale_residuals() {
  const auto used = static_cast<std::size_t>(encoder.dimensions);
  std::vector<double> square(used, kSmall);
  const Eigen::MatrixXd errors = rows_.targets - regressed_ - quadratic_correction_;
  for (std::ptrdiff_t i = 0; i < errors.rows(); ++i) {
    const Position error = encoder.place_of(row_of(errors, i));
    for (std::size_t d = 0; d < used; ++d) square[d] += error[d] * error[d] / static_cast<double>(regressed_.rows());
  }
  for (std::size_t d = 0; d < used; ++d)
    encoder.residual_scale[d] = static_cast<float>(kResidualStep * std::sqrt(square[d]));
}

std::span<Neighbour> Tuner::neighbours_of(Trial& trial, std::ptrdiff_t row, const Coordinates& grid,
                                          int count) const {
  const std::uint32_t own = rows_.subject[static_cast<std::size_t>(row)];
  const auto found =
      trial.search.nearest(grid, static_cast<std::size_t>(count) + static_cast<std::size_t>(captures_max_));
  const auto end = std::remove_if(found.begin(), found.end(), [&](const Neighbour& n) {
    return rows_.subject[trial.packed.order[n.index]] == own;
  });
  return found.first(
      std::min<std::size_t>(static_cast<std::size_t>(end - found.begin()), static_cast<std::size_t>(count)));
}

// The neighbour whose true place is nearest; -1: no neighbour.
std::ptrdiff_t Tuner::nearest_body(const Trial& trial, std::span<const Neighbour> neighbours,
                                   const Position& wanted) const {
  double best = 1e300;
  std::ptrdiff_t nearest = -1;
  for (const Neighbour& n : neighbours) {
    const std::ptrdiff_t row = trial.packed.order[n.index];
    const Position place = true_place(row);
    double square = 0;
    for (std::size_t d = 0; d < static_cast<std::size_t>(encoder.dimensions); ++d)
      square += (place[d] - wanted[d]) * (place[d] - wanted[d]);
    if (square >= best) continue;
    best = square;
    nearest = row;
  }
  return nearest;
}

double Tuner::nearest_entry_error(Trial& trial) const {
  double sum = 0;
  for (const std::ptrdiff_t i : judged_rows(kJudgedRowMax)) {
    const std::ptrdiff_t nearest =
        nearest_body(trial, neighbours_of(trial, i, grid_of(i), kNeighbours), regressed_place(i));
    for (int t = 0; nearest >= 0 && t < kTargetMin; ++t)
      sum += std::abs(rows_.targets(nearest, t) - rows_.targets(i, t));
  }
  return sum;
}

// A global quadratic surface over the projected space, for curvature that a linear map of the features lacks.
void Tuner::fit_quadratic() {
  const int dimensions = static_cast<int>(meta.dimensions);
  const int terms = quadratic_term_count(dimensions);
  const Eigen::MatrixXd residual = rows_.targets - regressed_;
  RowMatrixF phi(regressed_.rows(), terms);
  std::vector<double> buffer(static_cast<std::size_t>(terms));
  for (std::ptrdiff_t i = 0; i < phi.rows(); ++i) {
    quadratic_terms(regressed_place(i), encoder.inverse_spread, dimensions, buffer);
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
    return lab::solve_positive(std::move(a), b);
  };
  quadratic_correction_.resize(regressed_.rows(), target_count_);
  std::vector<Eigen::MatrixXd> fits;
  fits.reserve(static_cast<std::size_t>(rows_.fold_count));
  for (int f = 0; f < rows_.fold_count; ++f) fits.push_back(solve(f));
  for (std::ptrdiff_t i = 0; i < phi.rows(); ++i)
    quadratic_correction_.row(i) = phi.row(i).cast<double>().lazyProduct(
        fits[static_cast<std::size_t>(rows_.fold[static_cast<std::size_t>(i)])]);
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
  if (meta.quadratic != 0) encoder.quadratic = quadratic;
}

// Absolute error of each judged row (rows) and target (columns).
Eigen::MatrixXd Tuner::local_errors(Trial& trial, const Eigen::MatrixXd& base, const LocalOptions& options,
                                    int count) const {
  const LocalData data{&trial.tree, trial.residuals, encoder.residual_scale, error_map, target_count_};
  const auto judged = judged_rows(kJudgedRowMax);
  Eigen::MatrixXd out(static_cast<std::ptrdiff_t>(judged.size()), target_count_);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const std::ptrdiff_t i = judged[k];
    const Coordinates grid = grid_of(i);
    const LocalAnswer local = local_regression(data, grid, neighbours_of(trial, i, grid, count), options);
    for (int t = 0; t < target_count_; ++t)
      out(static_cast<std::ptrdiff_t>(k), t) = std::abs(base(i, t) + local.correction[t] - rows_.targets(i, t));
  }
  return out;
}

// Each target takes the local correction only where it is better beyond chance (two standard errors of the paired
// difference): over a straight world it would only add noise.
void Tuner::choose_correction() {
  const Eigen::MatrixXd base = regressed_ + quadratic_correction_;
  Trial entries = trial();
  const int available = static_cast<int>(std::min<std::ptrdiff_t>(kNeighbourMax, regressed_.rows() / 2));
  struct Candidate {
    LocalMethod method;
    int neighbours;
  };
  meta.local_method = static_cast<std::uint32_t>(LocalMethod::none);
  meta.neighbour_count = static_cast<std::uint32_t>(std::clamp(kNeighbours, 1, std::max(available, 1)));
  meta.intercept_penalty = kInterceptPenalty;
  meta.slope_penalty = kSlopePenalty;
  const Eigen::MatrixXd plain = local_errors(entries, base, {}, 1);
  const auto n = static_cast<double>(plain.rows());
  const double whole = plain.leftCols(kTargetMin).sum() / n;
  double best = 0;
  // On 20,000 rendered people 128 neighbours gain another 0.6 % and 512 another 1.4 % (linear); 128 take three
  // times a query's time.
  for (const Candidate c : {Candidate{LocalMethod::mean, kNeighbours}, {LocalMethod::linear, kNeighbours}}) {
    if (c.neighbours > available) continue;
    const Eigen::MatrixXd gain =
        plain - local_errors(entries, base, {c.method, kInterceptPenalty, kSlopePenalty}, c.neighbours);
    std::uint32_t mask = 0;
    double total = 0;
    for (int t = 0; t < target_count_; ++t) {
      const double mean = gain.col(t).mean();
      const double error = std::sqrt((gain.col(t).array() - mean).square().sum() / (n * std::max(n - 1, 1.0)));
      if (mean <= 2 * error) continue;
      mask |= 1U << t;
      total += t < kTargetMin ? mean : 0;
    }
    if (total <= best + (1 - kWorthwhile) * whole) continue;
    best = total;
    meta.local_method = static_cast<std::uint32_t>(c.method);
    meta.local_targets = mask;
    meta.neighbour_count = static_cast<std::uint32_t>(c.neighbours);
  }
}

void Tuner::answer_held_out() {
  Trial entries = trial();
  const LocalData data{&entries.tree, entries.residuals, encoder.residual_scale, error_map, target_count_};
  const LocalOptions options{static_cast<LocalMethod>(meta.local_method), meta.intercept_penalty, meta.slope_penalty};
  const auto judged = judged_rows(kCalibrationRowMax);
  for (const std::ptrdiff_t i : judged) {
    HeldOut row;
    row.subject = rows_.subject[static_cast<std::size_t>(i)];
    row.frame_count = rows_.frame_count[static_cast<std::size_t>(i)];
    row.distance_mm = rows_.distance_mm[static_cast<std::size_t>(i)];
    row.truth = row_of(rows_.targets, i);
    row.answer = row_of(regressed_, i);
    const Coordinates grid = grid_of(i);
    const auto found = neighbours_of(entries, i, grid, static_cast<int>(meta.neighbour_count));
    const LocalAnswer local = local_regression(data, grid, found, options);
    for (int t = 0; t < target_count_; ++t)
      row.answer[t] +=
          quadratic_correction_(i, t) + ((meta.local_targets >> t & 1U) != 0 ? local.correction[t] : 0.0);
    row.spread = local.spread;
    const std::ptrdiff_t nearest = nearest_body(entries, found, encoder.place_of(row.answer));
    for (std::size_t m = 0; nearest >= 0 && m < kMeasurementCount; ++m)
      nearest_error[m] +=
          static_cast<float>(std::abs(rows_.targets(nearest, static_cast<std::ptrdiff_t>(m)) - row.truth[m]) /
                             static_cast<double>(judged.size()));
    held_out.push_back(row);
  }
}

}  // namespace im2fit::index
