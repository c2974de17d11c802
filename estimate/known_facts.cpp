// SPDX-License-Identifier: Apache-2.0
#include "estimate/known_facts.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "index/clothing_estimate.h"

namespace im2fit {
namespace {

constexpr std::array<ErrorCorrelation, kErrorTableCount> kErrorCorrelation = {{
#include "estimate/error_correlation.inc"
}};

// Of an interval that has no width, so that none is 0.
constexpr double kSdMin = 1e-3;
constexpr double kSdsInInterval = 2 * 1.96;
constexpr double kSexSd = 0.05;  // of a sex given, in probability

double sd_of(const index::IntervalEstimate& e) {
  const double sd = (static_cast<double>(e.high) - static_cast<double>(e.low)) / kSdsInInterval;
  return sd > kSdMin ? sd : kSdMin;
}

// Gaussian over errors (truth less answer), in their standard deviations.
class Posterior {
 public:
  explicit Posterior(const ErrorCorrelation& correlation) {
    for (std::size_t i = 0; i < kErrorCount; ++i)
      for (std::size_t j = 0; j < kErrorCount; ++j) covariance_[i][j] = static_cast<double>(correlation[i][j]);
  }
  double mean(std::size_t i) const { return mean_[i]; }
  double variance(std::size_t i) const { return covariance_[i][i]; }
  // Squared distance of an observation from what is expected, in variances.
  double surprise(std::size_t i, double observed, double variance_observed) const {
    const double off = observed - mean_[i];
    return off * off / (covariance_[i][i] + variance_observed);
  }
  void observe(std::size_t i, double observed, double variance_observed) {
    const double total = covariance_[i][i] + variance_observed;
    if (total <= 0) return;
    const double off = observed - mean_[i];
    std::array<double, kErrorCount> gain{}, row = covariance_[i];
    for (std::size_t j = 0; j < kErrorCount; ++j) gain[j] = row[j] / total;
    for (std::size_t j = 0; j < kErrorCount; ++j) {
      mean_[j] += gain[j] * off;
      for (std::size_t k = 0; k < kErrorCount; ++k) covariance_[j][k] -= gain[j] * row[k];
    }
  }

 private:
  std::array<double, kErrorCount> mean_{};
  std::array<std::array<double, kErrorCount>, kErrorCount> covariance_{};
};

// The estimate moved by the posterior's mean, its interval narrowed as the standard deviation is.
void move(index::IntervalEstimate& e, double unit, double mean, double narrower) {
  const double value = static_cast<double>(e.value) + unit * mean;
  const double below = static_cast<double>(e.value) - static_cast<double>(e.low);
  const double above = static_cast<double>(e.high) - static_cast<double>(e.value);
  e = {static_cast<float>(value), static_cast<float>(value - narrower * below),
       static_cast<float>(value + narrower * above)};
}

// No message repeats a value: it is personal, and messages are logged.
Status check_value(const KnownValue& v, const char* name, const char* unit, KnownRange value_range, int sd_most) {
  const auto& [least, most] = value_range;
  if (v.sd == 0) return Ok{};
  const auto range = [&](const std::string& from, int to) {
    return "expected " + from + " to " + std::to_string(to) + " " + unit;
  };
  if (!std::isfinite(v.value) || v.value < static_cast<float>(least) || v.value > static_cast<float>(most))
    return Error{ErrorCode::invalid_argument,
                 "known " + std::string(name) + ": " + range(std::to_string(least), most)};
  if (!std::isfinite(v.sd) || v.sd < 0.1F || v.sd > static_cast<float>(sd_most))
    return Error{ErrorCode::invalid_argument, "standard deviation of the known " + std::string(name) + ": " +
                                                  range("0.1", sd_most) + ", or 0 for a fact not known"};
  return Ok{};
}

}  // namespace

std::vector<std::string_view> names_of_facts(KnownFactSet facts) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kKnownFactCount; ++i)
    if ((facts >> i & 1U) != 0) names.push_back(kKnownFactNames[i]);
  return names;
}

KnownFactSet KnownFacts::given() const {
  return (stature_mm.sd > 0 ? bit_of(KnownFact::stature) : 0) | (weight_kg.sd > 0 ? bit_of(KnownFact::weight) : 0) |
         (sex != KnownSex::unknown ? bit_of(KnownFact::sex) : 0) | (age_years.sd > 0 ? bit_of(KnownFact::age) : 0);
}

Status check_known(const KnownFacts& facts) {
  if (auto ok = check_value(facts.stature_mm, "stature", "mm", kKnownStatureMm, 1000); !ok) return ok;
  if (auto ok = check_value(facts.weight_kg, "weight", "kg", kKnownWeightKg, 1000); !ok) return ok;
  return check_value(facts.age_years, "age", "years", kKnownAgeYears, 5);
}

std::array<double, kErrorCount> error_sds(const index::Answer& answer, const AgeAnswer& age) {
  std::array<double, kErrorCount> sds{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m) sds[m] = sd_of(answer.measurements[m]);
  const auto p = static_cast<double>(answer.female);
  sds[kSexError] = std::sqrt(p * (1 - p) + kSexVarianceMin);
  sds[kAgeError] = sd_of(age.years);
  return sds;
}

namespace {

// What a turn measures errs by itself: a person whose weight is 3 kg off is not wider than was seen.
ErrorCorrelation independent_errors() {
  ErrorCorrelation out{};
  for (std::size_t i = 0; i < kErrorCount; ++i) out[i][i] = 1;
  return out;
}

}  // namespace

std::size_t error_table_of(const index::Answer& answer) {
  return (index::looks_dressed(answer, ClothingGiven::unknown) ? 2U : 0U) +
         (answer.from == index::AnsweredFrom::front_and_back ? 1U : 0U);
}

KnownOutcome condition(const KnownFacts& facts, index::Answer& answer, AgeAnswer& age) {
  KnownOutcome outcome;
  const KnownFactSet given = facts.given();
  if (given == 0) return outcome;
  const std::array<double, kErrorCount> sds = error_sds(answer, age);
  Posterior posterior(answer.from == index::AnsweredFrom::around ? independent_errors()
                                                                 : kErrorCorrelation[error_table_of(answer)]);
  const auto take = [&](KnownFact fact, std::size_t error, double off, double sd, bool may_doubt) {
    if ((given & bit_of(fact)) == 0) return;
    const double observed = off / sds[error], variance = sd / sds[error] * (sd / sds[error]);
    if (may_doubt && posterior.surprise(error, observed, variance) > kDoubtSds * kDoubtSds) {
      outcome.doubted |= bit_of(fact);
      return;
    }
    posterior.observe(error, observed, variance);
    outcome.used |= bit_of(fact);
  };
  const auto off = [](const KnownValue& known, const index::IntervalEstimate& e) {
    return static_cast<double>(known.value) - static_cast<double>(e.value);
  };
  constexpr std::size_t kStature = measurement_index(Measurement::stature);
  constexpr std::size_t kWeight = measurement_index(Measurement::weight);
  take(KnownFact::stature, kStature, off(facts.stature_mm, answer.measurements[kStature]),
       static_cast<double>(facts.stature_mm.sd), true);
  take(KnownFact::age, kAgeError, off(facts.age_years, age.years), static_cast<double>(facts.age_years.sd), false);
  take(KnownFact::sex, kSexError, (facts.sex == KnownSex::woman ? 1.0 : 0.0) - static_cast<double>(answer.female),
       kSexSd, false);
  take(KnownFact::weight, kWeight, off(facts.weight_kg, answer.measurements[kWeight]),
       static_cast<double>(facts.weight_kg.sd), true);
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    move(answer.measurements[m], sds[m], posterior.mean(m), std::sqrt(std::max(0.0, posterior.variance(m))));
  answer.female =
      (outcome.used & bit_of(KnownFact::sex)) != 0
          ? (facts.sex == KnownSex::woman ? 1.0F : 0.0F)
          : static_cast<float>(std::clamp(
                static_cast<double>(answer.female) + sds[kSexError] * posterior.mean(kSexError), 0.0, 1.0));
  if ((outcome.used & bit_of(KnownFact::age)) != 0) {
    const float years = facts.age_years.value, sd = facts.age_years.sd;
    age.years = {years, years - 1.96F * sd, years + 1.96F * sd};
    age.bands.fill(0);
    age.bands[age_band_of(years)] = 1;
  }
  return outcome;
}

}  // namespace im2fit
