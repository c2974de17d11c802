// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/site_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "evaluation/measurements/error_statistics.h"

namespace im2fit::lab {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Each spread is one of these; the likelihood of the people chooses, with a half-normal prior of the SD named `usual`
// (docs/calibration.md says from where).
struct SpreadChoice {
  double SiteSpreads::*spread;
  double usual;
  std::array<double, 7> values;
};
constexpr std::array<SpreadChoice, 6> kSpreads = {{
    {&SiteSpreads::scale, 0.01, {0, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08}},
    {&SiteSpreads::girth, 0.01, {0, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08}},
    {&SiteSpreads::offset, 1, {0, 0.25, 0.5, 0.75, 1, 2, 4}},
    {&SiteSpreads::sex, 0.5, {0, 0.25, 0.5, 0.75, 1, 2, 4}},
    {&SiteSpreads::slope, 0.05, {0, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2}},
    {&SiteSpreads::camera, 0.005, {0, 0.00125, 0.0025, 0.005, 0.01, 0.02, 0.04}},
}};
constexpr int kSweeps = 2;  // over the spreads, each chosen with the others as they stand
constexpr int kRounds = 3;  // of correction, then noise about it

// Prior knowledge of a width counts as this number of people: the index gives 1 for all measurements together, and
// all together give each.
constexpr double kWidthPeopleOfAll = 8, kWidthPeopleOfEach = 10;

double allowance(std::size_t m) {
  const double limit_mm = iso_20685_limit_mm(static_cast<Measurement>(m));
  return limit_mm > 0 ? limit_mm : 1;
}

double growth(std::size_t m) {
  return static_cast<Measurement>(m) == Measurement::weight ? 3 : 1;
}

// Where each unknown stands in the vector of all.
struct Layout {
  std::vector<std::size_t> measured;  // measurements with enough tape values
  std::array<int, kMeasurementCount> place{};
  std::vector<std::string> cameras;
  int count() const { return static_cast<int>(3 * measured.size() + 2 + cameras.size()); }
  int offset(std::size_t m) const { return place[m]; }
  int sex(std::size_t m) const { return place[m] + static_cast<int>(measured.size()); }
  int slope(std::size_t m) const { return place[m] + static_cast<int>(2 * measured.size()); }
  int scale() const { return static_cast<int>(3 * measured.size()); }
  int girth() const { return scale() + 1; }
  int camera(std::size_t c) const { return scale() + 2 + static_cast<int>(c); }
};

class Fit {
 public:
  Fit(std::span<const SitePerson* const> people, int people_min) : people_(people) {
    layout_.place.fill(-1);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      double sum = 0;
      for (const SitePerson* p : people)
        if (p->tape[m].taken()) ++taken_[m], sum += static_cast<double>(p->answer[m].value);
      if (taken_[m] < people_min) continue;
      centre_[m] = sum / taken_[m];
      layout_.place[m] = static_cast<int>(layout_.measured.size());
      layout_.measured.push_back(m);
    }
    std::set<std::string> cameras;
    for (const SitePerson* p : people)
      if (!p->camera.empty()) cameras.insert(p->camera);
    if (cameras.size() > 1) layout_.cameras.assign(cameras.begin(), cameras.end());
    tape_ = tape_errors(people);
    width2_.fill(1);
    correlation_ = MatrixXd::Identity(size(), size());
  }

  SiteModel run() {
    SiteModel model;
    if (layout_.measured.empty()) return model;
    const auto alone = widths_with(VectorXd::Zero(layout_.count()), MatrixXd::Zero(layout_.count(), layout_.count()));
    for (int round = 0; round < kRounds; ++round) {
      gather();
      choose_spreads();
      solve();
      width2_ = widths_with(mean_, covariance_);
      learn_correlation();
    }
    return said(alone);
  }

 private:
  using Widths = std::array<double, kMeasurementCount>;
  int size() const { return static_cast<int>(layout_.measured.size()); }

  // The factors of the unknowns in a person's tape less answer.
  VectorXd factors(const SitePerson& p, std::size_t m) const {
    VectorXd x = VectorXd::Zero(layout_.count());
    const auto value = static_cast<double>(p.answer[m].value);
    x[layout_.offset(m)] = 1;
    x[layout_.sex(m)] = p.female - 0.5;
    x[layout_.slope(m)] = value - centre_[m];
    x[layout_.scale()] = growth(m) * value;
    if (is_girth(m)) x[layout_.girth()] = value;
    for (std::size_t c = 0; c < layout_.cameras.size(); ++c)
      if (p.camera == layout_.cameras[c]) x[layout_.camera(c)] = growth(m) * value;
    return x;
  }
  double tape_variance(const SitePerson& p, std::size_t m) const {
    return tape_[m] * tape_[m] / (p.tape[m].twice() ? 2 : 1);
  }

  // Normal equations of all people, each with the inverse covariance of its own noise.
  void gather() {
    const int n = layout_.count();
    normal_ = MatrixXd::Zero(n, n);
    right_ = VectorXd::Zero(n);
    for (const SitePerson* p : people_) {
      std::vector<std::size_t> here;
      for (const std::size_t m : layout_.measured)
        if (p->tape[m].taken()) here.push_back(m);
      if (here.empty()) continue;
      const auto k = static_cast<int>(here.size());
      MatrixXd noise(k, k), x(k, n);
      VectorXd y(k);
      for (int i = 0; i < k; ++i) {
        const std::size_t m = here[static_cast<std::size_t>(i)];
        x.row(i) = factors(*p, m).transpose();
        y[i] = -p->error(m);
        for (int j = 0; j < k; ++j) {
          const std::size_t o = here[static_cast<std::size_t>(j)];
          noise(i, j) = correlation_(layout_.place[m], layout_.place[o]) * answer_sd(p->answer[m]) *
                        answer_sd(p->answer[o]) * std::sqrt(width2_[m] * width2_[o]);
        }
        noise(i, i) += tape_variance(*p, m) + 1e-9;
      }
      const Eigen::LDLT<MatrixXd> solved(noise);
      normal_ += x.transpose() * solved.solve(x);
      right_ += x.transpose() * solved.solve(y);
    }
  }

  VectorXd prior_sds(const SiteSpreads& s) const {
    VectorXd sds = VectorXd::Zero(layout_.count());
    for (const std::size_t m : layout_.measured) {
      sds[layout_.offset(m)] = s.offset * allowance(m);
      sds[layout_.sex(m)] = s.sex * allowance(m);
      sds[layout_.slope(m)] = s.slope;
    }
    sds[layout_.scale()] = s.scale;
    sds[layout_.girth()] = s.girth;
    for (std::size_t c = 0; c < layout_.cameras.size(); ++c) sds[layout_.camera(c)] = s.camera;
    return sds;
  }

  // Log of the people's likelihood by these spreads and of the spreads' own prior, but for a constant.
  double evidence(const SiteSpreads& s) const {
    const VectorXd sds = prior_sds(s);
    const MatrixXd inner = MatrixXd::Identity(layout_.count(), layout_.count()) +
                           MatrixXd(sds.asDiagonal() * normal_ * sds.asDiagonal());
    const Eigen::LLT<MatrixXd> solved(inner);
    const VectorXd right = sds.cwiseProduct(right_);
    double sum = 0.5 * right.dot(solved.solve(right));
    const MatrixXd root = solved.matrixL();
    for (int i = 0; i < layout_.count(); ++i) sum -= std::log(root(i, i));
    for (const SpreadChoice& choice : kSpreads) {
      const double usuals = s.*choice.spread / choice.usual;
      sum -= 0.5 * usuals * usuals;
    }
    return sum;
  }

  void choose_spreads() {
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const SpreadChoice& choice : kSpreads) {
        if (choice.spread == &SiteSpreads::camera && layout_.cameras.empty()) continue;
        double best = -std::numeric_limits<double>::infinity(), chosen = 0;
        for (const double value : choice.values) {
          SiteSpreads tried = spreads_;
          tried.*choice.spread = value;
          const double sum = evidence(tried);
          if (sum <= best) continue;
          best = sum;
          chosen = value;
        }
        spreads_.*choice.spread = chosen;
      }
  }

  void solve() {
    const VectorXd sds = prior_sds(spreads_);
    const MatrixXd inner = MatrixXd::Identity(layout_.count(), layout_.count()) +
                           MatrixXd(sds.asDiagonal() * normal_ * sds.asDiagonal());
    const Eigen::LLT<MatrixXd> solved(inner);
    mean_ = sds.cwiseProduct(solved.solve(sds.cwiseProduct(right_)));
    covariance_ =
        sds.asDiagonal() * solved.solve(MatrixXd::Identity(layout_.count(), layout_.count())) * sds.asDiagonal();
  }

  // Squares of widths: expected squares of the residuals, in the answer's own SDs, less the tape's error. Each
  // measurement's square is drawn to that of all, and that to 1.
  Widths widths_with(const VectorXd& mean, const MatrixXd& covariance) const {
    Widths sum{}, widths{};
    widths.fill(1);
    double of_all = 0;
    for (const std::size_t m : layout_.measured) {
      for (const SitePerson* p : people_) {
        if (!p->tape[m].taken()) continue;
        const VectorXd x = factors(*p, m);
        const double left = -p->error(m) - x.dot(mean), sd = answer_sd(p->answer[m]);
        sum[m] += (left * left + x.dot(covariance * x) - tape_variance(*p, m)) / (sd * sd);
      }
      sum[m] = std::max(sum[m], 0.05 * taken_[m]);
      of_all += sum[m] / taken_[m] / size();
    }
    const double n = static_cast<double>(people_.size());
    of_all = (kWidthPeopleOfAll + n * of_all) / (kWidthPeopleOfAll + n);
    for (const std::size_t m : layout_.measured)
      widths[m] = (kWidthPeopleOfEach * of_all + sum[m]) / (kWidthPeopleOfEach + taken_[m]);
    return widths;
  }

  // Correlation of the residuals, shrunk to zero by the share with the least expected square error (Schaefer and
  // Strimmer 2005).
  void learn_correlation() {
    const int k = size();
    const auto n = static_cast<int>(people_.size());
    MatrixXd z = MatrixXd::Zero(n, k);
    for (int i = 0; i < n; ++i) {
      const SitePerson& p = *people_[static_cast<std::size_t>(i)];
      for (const std::size_t m : layout_.measured)
        if (p.tape[m].taken())
          z(i, layout_.place[m]) = (-p.error(m) - factors(p, m).dot(mean_)) / answer_sd(p.answer[m]);
    }
    for (int j = 0; j < k; ++j) {
      z.col(j).array() -= z.col(j).mean();
      z.col(j) /= std::max(1e-9, std::sqrt(z.col(j).squaredNorm() / std::max(1, n - 1)));
    }
    const MatrixXd r = z.transpose() * z / std::max(1, n - 1);
    double variance = 0, squares = 0;
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) {
        if (i == j) continue;
        const VectorXd w = z.col(i).cwiseProduct(z.col(j));
        const double nn = n;
        variance += nn / std::pow(nn - 1, 3) * (w.array() - w.mean()).square().sum();
        squares += r(i, j) * r(i, j);
      }
    const double share = squares > 0 ? std::clamp(variance / squares, 0.0, 1.0) : 1;
    correlation_ = (1 - share) * r + share * MatrixXd::Identity(k, k);
    correlation_.diagonal().setOnes();
  }

  // 95 % of a new person need more SDs where the SD itself is known from few: Student's t against the normal, to the
  // first order (Cornish and Fisher).
  double few_people(std::size_t m) const {
    constexpr double kNormal = 1.96;
    return 1 + (kNormal * kNormal + 1) / (4 * (taken_[m] + kWidthPeopleOfEach));
  }

  SiteModel said(const Widths& alone) const {
    SiteModel model;
    model.spreads = spreads_;
    for (std::size_t c = 0; c < layout_.cameras.size(); ++c)
      model.cameras.push_back({layout_.cameras[c], 1 + mean_[layout_.camera(c)]});
    for (const std::size_t m : layout_.measured) {
      SiteModel::Row& row = model.rows[m];
      const double slope = mean_[layout_.slope(m)], sex = mean_[layout_.sex(m)];
      const double offset = mean_[layout_.offset(m)] - slope * centre_[m];
      row.people = taken_[m];
      row.scale = 1 + slope + growth(m) * mean_[layout_.scale()] + (is_girth(m) ? mean_[layout_.girth()] : 0);
      row.offset_men = offset - sex / 2;
      row.offset_women = offset + sex / 2;
      double unknown = 0;
      for (const SitePerson* p : people_) {
        if (!p->tape[m].taken()) continue;
        const VectorXd x = factors(*p, m);
        const double sd = answer_sd(p->answer[m]);
        unknown += x.dot(covariance_ * x) / (sd * sd) / taken_[m];
      }
      row.width = few_people(m) * std::sqrt(width2_[m] + unknown) / row.scale;
      row.width_alone = few_people(m) * std::sqrt(alone[m]);
    }
    return model;
  }

  std::span<const SitePerson* const> people_;
  Layout layout_;
  std::array<int, kMeasurementCount> taken_{};
  std::array<double, kMeasurementCount> centre_{}, tape_{};
  Widths width2_{};
  MatrixXd correlation_, normal_, covariance_;
  VectorXd right_, mean_;
  SiteSpreads spreads_;
};

}  // namespace

std::array<double, kMeasurementCount> tape_errors(std::span<const SitePerson* const> people) {
  std::array<double, kMeasurementCount> errors{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<std::array<double, 2>> pairs;
    for (const SitePerson* p : people)
      if (p->tape[m].twice()) pairs.push_back({p->tape[m].first, p->tape[m].second});
    if (static_cast<int>(pairs.size()) >= kTapePairsMin) errors[m] = repeatability(pairs).tem;
  }
  return errors;
}

SiteModel fit_site_model(std::span<const SitePerson* const> people, int people_min) {
  return Fit(people, people_min).run();
}

index::IntervalEstimate corrected(const SiteModel& model, const SitePerson& person, std::size_t m, bool values) {
  const SiteModel::Row& row = model.rows[m];
  const index::IntervalEstimate& e = person.answer[m];
  if (row.people == 0) return e;
  double scale = values ? row.scale : 1;
  if (values)
    for (const SiteModel::Camera& camera : model.cameras)
      if (camera.name == person.camera)
        scale *= growth(m) == 3 ? camera.scale * camera.scale * camera.scale : camera.scale;
  const double offset = values ? row.offset_men + (row.offset_women - row.offset_men) * person.female : 0;
  const auto value = static_cast<double>(e.value);
  const double widened = (values ? row.width : row.width_alone) * scale;
  const double centre = value * scale + offset;
  return {static_cast<float>(centre), static_cast<float>(centre - (value - static_cast<double>(e.low)) * widened),
          static_cast<float>(centre + (static_cast<double>(e.high) - value) * widened)};
}

}  // namespace im2fit::lab
