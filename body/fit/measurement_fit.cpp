// SPDX-License-Identifier: Apache-2.0
#include "body/fit/measurement_fit.h"

#include <algorithm>
#include <cmath>

#include "body/fatness.h"
#include "body/fit/seen_prior.h"
#include "core/cholesky.h"

namespace im2fit::body {
namespace {

constexpr std::array<MeasurementRegression, 2> kRegressions = {{
#include "body/fit/measurement_regression.inc"
}};

constexpr std::size_t kRows = kMeasurementCount, kColumns = kFitParameterCount;
using Rows = std::array<double, kRows>;
using Columns = std::array<double, kColumns>;

// With a body seen most need five, one in twelve nine; where these do not do, for the body seen may lie where slopes
// of the table say little, the search begins anew without it.
constexpr int kStepCountMax = 14;
// A goal's share of its own standard deviation that it may be missed by for one standard deviation of people: so
// small that goals are met, and those known best where they contradict one another.
constexpr double kTightness = 0.02;
constexpr double kSdMin = 0.25, kSdMax = 1000;  // mm or kg
constexpr std::size_t kHeldMax = 10;            // unknowns held at their limits
constexpr double kHeldSlack = 1e-4;
constexpr double kAskedPivotMin = 1e-12;  // where goals contradict one another
constexpr std::size_t kAskedMax = kRows + kHeldMax;
constexpr double kStepMax = 4;  // standard deviations of people: farther no slope is believed
// Of the distance of a seen point of the skin: the fit's own errors, which neighbours share, so that a point counts
// for little. 12 to 90 mm were tried (docs/notebook/fit.md).
constexpr double kSeenSdMm = 16;
// The same of a body measured all round; where its goals cannot be met nearly, the next. With 16 the answered thighs
// of eight people of `other` err by 18 mm, with 12, 9 and 6 by 12, 10 and 8; the weight of the mesh then misses the
// answered one by up to 0.5, 0.7 and 0.8 kg.
constexpr std::array<double, 3> kAroundSdsMm = {8, 16, 32};
// What is met well enough where the body was measured all round: one body to a millimetre (docs/one-body.md), and
// less than half of what a weight's 95 % interval has on either side after a turn (2.3 kg).
constexpr double kNearlyMm = 1, kNearlyKg = 1;
// Residuals at which the search ends: a tenth of the reported limit (kResidualToldMm).
constexpr double kMetMm = 0.2, kMetKg = 0.02;
// Goals give way by kTightness, so that a search may come to rest a little beyond those: ended where a step takes the
// cost to more than kRestShare of what it was, and residuals are at most so many times as large.
constexpr double kRestShare = 0.7, kMetAtRest = 2;

double limited(double v, double low, double high) {
  return v > low ? (v < high ? v : high) : low;
}

bool is_mass(std::size_t row) {
  return row == measurement_index(Measurement::weight);
}

// How far bodies go; what begins farther out stays where it is.
struct Limits {
  float low, high;
};
constexpr Limits kHeightLimits = {0, 1}, kBuildLimits = {-kSlimnessMax, 1 + kFatnessMax}, kCrotchLimits = {-1, 1};
Limits limits_of(WarpValue v) {
  if (v <= WarpValue::head_rise) return {-0.06F, 0.06F};
  switch (v) {
    case WarpValue::hip_square:
    case WarpValue::waist_square:
    case WarpValue::chest_square:
      return {-0.1F, 0.12F};
    case WarpValue::deltoid_girth:
      return {-0.5F, 0.5F};
    case WarpValue::upper_arm_length:
    case WarpValue::forearm_length:
    case WarpValue::head_breadth:
    case WarpValue::head_length:
      return {-0.25F, 0.25F};
    default:
      return {-0.4F, 0.4F};
  }
}

double moved(float from, double by, Limits limits) {
  return limited(static_cast<double>(from) + by, static_cast<double>(std::min(limits.low, from)),
                 static_cast<double>(std::max(limits.high, from)));
}

}  // namespace

const MeasurementRegression& measurement_regression(bool woman) {
  return kRegressions[woman ? 0 : 1];
}

float girth_residual_mm(const MeasurementValues& residual) {
  float most = 0;
  for (const Measurement m : {Measurement::neck_girth, Measurement::shoulder_girth, Measurement::chest_girth,
                              Measurement::waist_girth, Measurement::hip_girth}) {
    const float r = residual[measurement_index(m)];
    most = std::max(most, r < 0 ? -r : r);
  }
  return most;
}

void change_body(const BodyModel& model, const Params& from, const FitParameters& change, Params& out) {
  out = from;
  out.modifiers.resize(model.modifier_names().size());
  out.height = static_cast<float>(moved(from.height, change[0], kHeightLimits));
  const double build = moved(from.weight, change[1], kBuildLimits);
  out.weight = static_cast<float>(limited(build, 0, 1));
  const auto fatness = static_cast<float>(build - static_cast<double>(out.weight));
  if (fatness != 0)
    for (const FatnessPart& part : kFatness)
      if (const int index = model.modifier_index(part.modifier); index >= 0)
        out.modifiers[static_cast<std::size_t>(index)] += fatness * part.share;
  if (const int index = model.modifier_index(kCrotchModifier); index >= 0) {
    const auto crotch = static_cast<std::size_t>(index);
    out.modifiers[crotch] = static_cast<float>(moved(out.modifiers[crotch], change[kCrotchParameter], kCrotchLimits));
  }
  for (std::size_t i = 0; i < kWarpCount; ++i)
    out.warp.values[i] =
        static_cast<float>(moved(from.warp.values[i], change[2 + i], limits_of(static_cast<WarpValue>(i))));
}

class MeasurementFitter::Work {
 public:
  explicit Work(const BodyModel& model) : model_(model), measurer_(model), seen_prior_(model) {
    for (Params* p : {&from_, &here_, &best_}) p->modifiers.reserve(model.modifier_names().size());
  }

  MeasurementFit run(Params& params, const MeasurementGoals& goals, const SeenBody* seen) {
    from_ = params;
    set_goals(goals);
    set_limits();
    MeasurementFit fit;
    bool found = false;
    if (seen != nullptr && seen->valid && !seen->around) {
      set_prior(params.gender, seen, kSeenSdMm);
      found = search(fit);
    }
    // A body measured all round is worth more than the last tenths of a millimetre, and is followed as far as it can
    // be.
    if (seen != nullptr && seen->valid && seen->around)
      for (const double sd_mm : kAroundSdsMm) {
        set_prior(params.gender, seen, sd_mm);
        found = search(fit, true);
        if (found) break;
      }
    if (!found) {
      set_prior(params.gender, nullptr, 0);
      search(fit);
    }
    params = best_;
    return fit;
  }
  const Measurer& measured() const { return measurer_; }
  const BodyModel& model() const { return model_; }

 private:
  // Whether all goals are met, or nearly where that is enough. The measurer then holds what was found.
  bool search(MeasurementFit& fit, bool nearly_is_enough = false) {
    fit = {};
    whitened_.fill(0);
    double best_cost = 0, cost_before = 0, times = 1;  // of the residuals at which the search ends
    int best_step = 0;
    Rows off{}, off_before{};
    Columns before{};
    for (fit.steps = 0;; ++fit.steps) {
      go_to(whitened_);
      const MeasurementValues values = measurer_.measure(here_);
      off = off_of(values);
      if (fit.steps == 0)
        scale_slopes(values);
      else
        learn(before, off_before, off);
      const double cost = cost_of(off);
      times = fit.steps > 0 && cost > kRestShare * cost_before ? kMetAtRest : 1;
      cost_before = cost;
      if (fit.steps == 0 || cost < best_cost) {
        best_cost = cost;
        best_ = here_;
        best_step = fit.steps;
        fit.values = values;
        fit.distance = static_cast<float>(length(whitened_));
      }
      if (met(off, times) || fit.steps == kStepCountMax) break;
      if (nearly_is_enough && times > 1 && nearly_met(off)) break;
      before = whitened_;
      off_before = off;
      step(off);
    }
    const Rows last = off_of(fit.values);
    for (std::size_t r = 0; r < kRows; ++r) fit.residual[r] = static_cast<float>(last[r]);
    if (best_step != fit.steps) measurer_.measure(best_);
    return met(last, times) || (nearly_is_enough && nearly_met(last));
  }

  void set_prior(float gender, const SeenBody* seen, double sd_mm) {
    const MeasurementRegression& regression = measurement_regression(gender < 0.5F);
    std::size_t next = 0;
    prior_ = {};
    for (std::size_t i = 0; i < kColumns; ++i)
      for (std::size_t j = 0; j <= i; ++j) prior_.factor[i][j] = static_cast<double>(regression.spread[next++]);
    if (seen != nullptr) seen_prior_.see(from_, *seen, sd_mm, prior_);
    for (std::size_t r = 0; r < kRows; ++r)
      for (std::size_t j = 0; j < kColumns; ++j) {
        double sum = 0;
        for (std::size_t i = j; i < kColumns; ++i)
          sum += static_cast<double>(regression.slopes[r][i]) * prior_.factor[i][j];
        slopes_[r][j] = sum;
      }
  }

  void set_goals(const MeasurementGoals& goals) {
    for (std::size_t r = 0; r < kRows; ++r) {
      asked_[r] = std::isfinite(goals[r].value);
      goal_[r] = asked_[r] ? static_cast<double>(goals[r].value) : 0;
      sd_[r] = limited(static_cast<double>(goals[r].sd), kSdMin, kSdMax);
    }
  }

  void set_limits() {
    const auto set = [&](std::size_t i, float from, Limits limits) {
      low_[i] = std::min(static_cast<double>(limits.low) - static_cast<double>(from), 0.0);
      high_[i] = std::max(static_cast<double>(limits.high) - static_cast<double>(from), 0.0);
    };
    set(0, from_.height, kHeightLimits);
    set(1, from_.weight, kBuildLimits);
    for (std::size_t i = 0; i < kWarpCount; ++i)
      set(2 + i, from_.warp.values[i], limits_of(static_cast<WarpValue>(i)));
    const int crotch = model_.modifier_index(kCrotchModifier);
    const bool given = crotch >= 0 && static_cast<std::size_t>(crotch) < from_.modifiers.size();
    set(kCrotchParameter, given ? from_.modifiers[static_cast<std::size_t>(crotch)] : 0, kCrotchLimits);
  }

  void go_to(const Columns& whitened) {
    FitParameters change = prior_.centre;
    for (std::size_t i = 0; i < kColumns; ++i)
      for (std::size_t j = 0; j <= i; ++j) change[i] += prior_.factor[i][j] * whitened[j];
    change_body(model_, from_, change, here_);
  }

  Rows off_of(const MeasurementValues& values) const {
    Rows off{};
    for (std::size_t r = 0; r < kRows; ++r)
      if (asked_[r]) off[r] = static_cast<double>(values[r]) - goal_[r];
    return off;
  }

  double cost_of(const Rows& off) const {
    double sum = 0;
    for (std::size_t r = 0; r < kRows; ++r) sum += off[r] * off[r] / (sd_[r] * sd_[r]);
    return sum;
  }

  static bool met(const Rows& off, double times) {
    for (std::size_t r = 0; r < kRows; ++r)
      if (!(std::fabs(off[r]) <= times * (is_mass(r) ? kMetKg : kMetMm))) return false;
    return true;
  }

  static bool nearly_met(const Rows& off) {
    for (std::size_t r = 0; r < kRows; ++r)
      if (!(std::fabs(off[r]) <= (is_mass(r) ? kNearlyKg : kNearlyMm))) return false;
    return true;
  }

  static double length(const Columns& c) {
    double sum = 0;
    for (const double v : c) sum += v * v;
    return std::sqrt(sum);
  }

  void scale_slopes(const MeasurementValues& values) {
    for (std::size_t r = 0; r < kRows; ++r)
      for (double& slope : slopes_[r]) slope *= static_cast<double>(values[r]);
  }

  // Broyden's update (1965): the least change of the slopes after which they foretell the last step.
  void learn(const Columns& before, const Rows& off_before, const Rows& off) {
    Columns by{};
    double squares = 0;
    for (std::size_t j = 0; j < kColumns; ++j) {
      by[j] = whitened_[j] - before[j];
      squares += by[j] * by[j];
    }
    if (!(squares > 0)) return;
    for (std::size_t r = 0; r < kRows; ++r) {
      double error = off[r] - off_before[r];
      for (std::size_t j = 0; j < kColumns; ++j) error -= slopes_[r][j] * by[j];
      for (std::size_t j = 0; j < kColumns; ++j) slopes_[r][j] += error / squares * by[j];
    }
  }

  // The most likely change that meets the goals as they are foretold: z = A' (A A' + S)^-1 (A z0 - off). An unknown
  // that would leave its limits is a goal more: to lie at its limit.
  void step(const Rows& off) {
    count_ = 0;
    for (std::size_t r = 0; r < kRows; ++r) {
      if (!asked_[r]) continue;
      double to = -off[r];
      for (std::size_t j = 0; j < kColumns; ++j) to += slopes_[r][j] * whitened_[j];
      ask(slopes_[r], to, kTightness * sd_[r]);
    }
    std::array<bool, kColumns> held{};
    Columns next = nearest();
    for (std::size_t more = kHeldMax; more > 0; --more) {
      const Beyond worst = worst_beyond(next, held);
      if (worst.by <= 0) break;
      held[worst.unknown] = true;
      ask(prior_.factor[worst.unknown], worst.limit - prior_.centre[worst.unknown], kHeldSlack);
      next = nearest();
    }
    Columns by{};
    for (std::size_t j = 0; j < kColumns; ++j) by[j] = next[j] - whitened_[j];
    const double far = length(by), share = far > kStepMax ? kStepMax / far : 1;
    for (std::size_t j = 0; j < kColumns; ++j) whitened_[j] += share * by[j];
  }

  void ask(const Columns& row, double to, double slack) {
    for (std::size_t c = 0; c < count_; ++c) products_[count_][c] = product(row, asking_[c]);
    products_[count_][count_] = product(row, row) + slack * slack;
    asking_[count_] = row;
    to_[count_] = to;
    ++count_;
  }

  // The least change that meets the goals.
  Columns nearest() {
    Products m = products_;
    std::array<double, kAskedMax> x = to_;
    cholesky_factor(m, count_, kAskedPivotMin);
    cholesky_solve(m, count_, x);
    Columns out{};
    for (std::size_t r = 0; r < count_; ++r)
      for (std::size_t j = 0; j < kColumns; ++j) out[j] += asking_[r][j] * x[r];
    return out;
  }

  struct Beyond {
    std::size_t unknown = 0;
    double by = 0, limit = 0;  // standard deviations; of the change
  };
  Beyond worst_beyond(const Columns& whitened, const std::array<bool, kColumns>& held) const {
    Beyond worst;
    for (std::size_t i = 0; i < kColumns; ++i) {
      if (held[i]) continue;
      const double change = prior_.centre[i] + product(prior_.factor[i], whitened);
      const double limit = limited(change, low_[i], high_[i]);
      const double by = std::fabs(change - limit) / std::sqrt(product(prior_.factor[i], prior_.factor[i]));
      if (by > worst.by) worst = {i, by, limit};
    }
    return worst;
  }

  static double product(const Columns& a, const Columns& b) {
    double sum = 0;
    for (std::size_t j = 0; j < kColumns; ++j) sum += a[j] * b[j];
    return sum;
  }

  using Products = std::array<std::array<double, kAskedMax>, kAskedMax>;

  const BodyModel& model_;
  Measurer measurer_;
  Params from_, here_, best_;
  SeenPrior seen_prior_;
  FitPrior prior_;
  std::array<std::array<double, kColumns>, kRows> slopes_{};  // by whitened unknowns
  std::array<bool, kRows> asked_{};
  Rows goal_{}, sd_{};
  Columns low_{}, high_{};  // limits of the change
  Columns whitened_{};
  std::size_t count_ = 0;  // goals and held unknowns of a step
  std::array<Columns, kAskedMax> asking_{};
  std::array<double, kAskedMax> to_{};
  Products products_{};
};

MeasurementFitter::MeasurementFitter(const BodyModel& model) : work_(std::make_unique<Work>(model)) {}
MeasurementFitter::MeasurementFitter(MeasurementFitter&&) noexcept = default;
MeasurementFitter& MeasurementFitter::operator=(MeasurementFitter&&) noexcept = default;
MeasurementFitter::~MeasurementFitter() = default;

MeasurementFit MeasurementFitter::run(Params& params, const MeasurementGoals& goals, const SeenBody* seen) {
  return work_->run(params, goals, seen);
}

const Measurer& MeasurementFitter::measured() const {
  return work_->measured();
}
const BodyModel& MeasurementFitter::model() const {
  return work_->model();
}

}  // namespace im2fit::body
