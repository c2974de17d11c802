// SPDX-License-Identifier: Apache-2.0
// What a person knows of themselves (stature, weight, sex, age) as evidence beside what the camera saw. The answer is
// read as a Gaussian over all measurements, sex and age together; a known fact is an observation of one of them, and
// everything that goes with it moves and narrows by the same step (Kalman's). How errors go together was learned on
// people unlike the index's own (error_correlation.inc), by views and clothing.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "estimate/age.h"
#include "index/index.h"

namespace im2fit {

enum class KnownFact : int { stature, weight, sex, age };
inline constexpr std::size_t kKnownFactCount = 4;
inline constexpr std::array<std::string_view, kKnownFactCount> kKnownFactNames = {"stature", "weight", "sex", "age"};
using KnownFactSet = std::uint32_t;  // bit 1 << fact
constexpr KnownFactSet bit_of(KnownFact fact) {
  return KnownFactSet{1} << static_cast<int>(fact);
}

std::vector<std::string_view> names_of_facts(KnownFactSet facts);  // "stature", "weight"

// Standard deviations of facts that come without one.
// Of a weight: bathroom scales, clothes and the time of day; as people report it (rounded, remembered).
inline constexpr float kScaleSdKg = 0.7F, kStatedWeightSdKg = 3.0F;
// Of a stature as people report it: SD of the difference to the measured one in surveys (Gorber et al. 2007,
// Obesity Reviews 8, 307-326: 20 mm and more).
inline constexpr float kStatedStatureSdMm = 20;
inline constexpr float kStatedAgeSdYears = 0.5F;  // completed years

// Accepted values.
struct KnownRange {
  int least, most;
};
inline constexpr KnownRange kKnownStatureMm = {500, 2500}, kKnownWeightKg = {15, 400}, kKnownAgeYears = {0, 120};
// Ages of people are given in completed years; the expected age is half a year more.
inline constexpr KnownRange kCompletedYears = {1, 119};
constexpr float age_of_completed_years(float years) {
  return years + 0.5F;
}

// A value and its standard deviation; sd 0: not known.
struct KnownValue {
  float value = 0;
  float sd = 0;
};
enum class KnownSex : int { unknown, woman, man };

// Trivially copyable. Personal data: kept in memory only, and in files where a result is asked for.
struct KnownFacts {
  KnownValue stature_mm, weight_kg, age_years;
  KnownSex sex = KnownSex::unknown;
  KnownFactSet given() const;
};
// Values: the ranges above; standard deviations: 0.1..1000, of an age 0.1..5. Error: invalid_argument, naming the
// fact and the range.
Status check_known(const KnownFacts& facts);

struct KnownOutcome {
  KnownFactSet used = 0;     // that the answer rests on
  KnownFactSet doubted = 0;  // left out: too far from what was seen, and from the other facts
};

// Moves and narrows answer and age by the facts. Facts are taken one by one: stature, age, sex, weight; one that lies
// outside of what is expected by then (kDoubtSds standard deviations) is left out and named. Sex is taken as it is
// given. No allocation; only + - * / sqrt in written order: the same bits on every machine.
inline constexpr double kDoubtSds = 2.6;
KnownOutcome condition(const KnownFacts& facts, index::Answer& answer, AgeAnswer& age);

// How the errors of an answer go together: measurements, sex, age. Their standard deviations are the answer's own: of
// a measurement and of age a quarter of the 95 % interval (1.96 to either side), which holds for other makes of body,
// too; of sex sqrt(p (1 - p) + kSexVarianceMin), p the answered probability.
inline constexpr std::size_t kErrorCount = kMeasurementCount + 2;
inline constexpr std::size_t kSexError = kMeasurementCount, kAgeError = kMeasurementCount + 1;
inline constexpr double kSexVarianceMin = 0.01;
using ErrorCorrelation = std::array<std::array<float, kErrorCount>, kErrorCount>;
// Standard deviations of an answer's errors, in that order.
std::array<double, kErrorCount> error_sds(const index::Answer& answer, const AgeAnswer& age);
// Tables of error_correlation.inc: bare from the front, bare from both sides, dressed from the front, dressed from
// both sides.
inline constexpr std::size_t kErrorTableCount = 4;
std::size_t error_table_of(const index::Answer& answer);

}  // namespace im2fit
