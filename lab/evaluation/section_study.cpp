// SPDX-License-Identifier: Apache-2.0
#include "lab/evaluation/section_study.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "body/measure.h"
#include "body/skeleton.h"
#include "core/rng.h"
#include "engine/report/progress.h"
#include "lab/parallel.h"
#include "lab/population/population.h"

namespace im2fit::lab {
namespace {

constexpr std::size_t kFolds = 10;
constexpr std::uint64_t kNoiseStream = 0x5EC7;
constexpr std::array<std::string_view, 11> kColumns = {
    "stature",    "weightkg",           "chestbreadth", "chestdepth",   "chestcircumference",  "waistbreadth",
    "waistdepth", "waistcircumference", "hipbreadth",   "buttockdepth", "buttockcircumference"};

// A quarter of the unit superellipse, for people share its powers.
class Superellipse {
 public:
  explicit Superellipse(double exponent) {
    for (std::size_t i = 0; i <= kSides; ++i) {
      const double angle = std::numbers::pi / 2 * static_cast<double>(i) / kSides;
      x_[i] = i == kSides ? 0 : std::pow(std::cos(angle), 2 / exponent);
      y_[i] = std::pow(std::sin(angle), 2 / exponent);
    }
  }
  double girth_mm(double breadth_mm, double depth_mm) const {
    double length = 0;
    for (std::size_t i = 1; i <= kSides; ++i) {
      const double dx = breadth_mm / 2 * (x_[i] - x_[i - 1]), dy = depth_mm / 2 * (y_[i] - y_[i - 1]);
      length += std::sqrt(dx * dx + dy * dy);
    }
    return 4 * length;
  }

 private:
  static constexpr std::size_t kSides = 256;
  std::array<double, kSides + 1> x_{}, y_{};
};

using Features = std::function<Eigen::VectorXd(const SectionPerson&, std::size_t girth)>;
using Guess = std::function<double(const SectionPerson&)>;
using People = std::vector<const SectionPerson*>;

Guess linear_fit(const People& people, std::size_t girth, const Features& features) {
  const auto count = static_cast<Eigen::Index>(people.size());
  Eigen::MatrixXd rows(count, features(*people[0], girth).size());
  Eigen::VectorXd wanted(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const SectionPerson& person = *people[static_cast<std::size_t>(i)];
    rows.row(i) = features(person, girth).transpose();
    wanted[i] = person.girth_mm[girth];
  }
  const Eigen::VectorXd weights = rows.colPivHouseholderQr().solve(wanted);
  return [weights, girth, features](const SectionPerson& p) { return weights.dot(features(p, girth)); };
}

// In decimetres, so that the columns are of one size.
Eigen::VectorXd quadratic_features(const SectionPerson& p, std::size_t g) {
  const double b = p.breadth_mm[g] / 100, d = p.depth_mm[g] / 100;
  return Eigen::Matrix<double, 6, 1>{1, b, d, b * b, b * d, d * d};
}
Eigen::VectorXd front_features(const SectionPerson& p, std::size_t) {
  return Eigen::Matrix<double, 5, 1>{1, p.stature_mm / 1000, p.breadth_mm[0] / 100, p.breadth_mm[1] / 100,
                                     p.breadth_mm[2] / 100};
}
Eigen::VectorXd all_round_features(const SectionPerson& p, std::size_t g) {
  Eigen::VectorXd out(8);
  out << front_features(p, g), p.depth_mm[0] / 100, p.depth_mm[1] / 100, p.depth_mm[2] / 100;
  return out;
}
Eigen::VectorXd all_weighed_features(const SectionPerson& p, std::size_t g) {
  Eigen::VectorXd out(9);
  out << all_round_features(p, g), p.weight_kg / 100;
  return out;
}

double fitted_factor(const People& people, std::size_t g) {
  double up = 0, down = 0;
  for (const SectionPerson* p : people) {
    const double ellipse = ellipse_girth_mm(p->breadth_mm[g], p->depth_mm[g]);
    up += ellipse * p->girth_mm[g];
    down += ellipse * ellipse;
  }
  return up / down;
}

// By golden section; what is squared falls and rises once, for the perimeter grows with the exponent. A tape longer
// than round the rectangle is out of its reach and ends at the largest.
double fitted_exponent(const People& people, std::size_t g) {
  constexpr double kGolden = 0.6180339887498949, kLeast = 1.2, kMost = 20;
  const std::size_t step = std::max<std::size_t>(1, people.size() / 400);  // enough for one number
  const auto cost = [&](double exponent) {
    const Superellipse shape(exponent);
    double sum = 0;
    for (std::size_t i = 0; i < people.size(); i += step) {
      const double error = shape.girth_mm(people[i]->breadth_mm[g], people[i]->depth_mm[g]) - people[i]->girth_mm[g];
      sum += error * error;
    }
    return sum;
  };
  double low = kLeast, high = kMost;
  for (int i = 0; i < 24; ++i) {  // to 2e-4
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    if (cost(a) < cost(b))
      high = b;
    else
      low = a;
  }
  return (low + high) / 2;
}

Guess fitted(SectionEstimator estimator, const People& people, const People& synthetic, std::size_t g) {
  switch (estimator) {
    case SectionEstimator::ellipse:
      break;
    case SectionEstimator::scaled: {
      const double factor = fitted_factor(people, g);
      return [factor, g](const auto& p) { return factor * ellipse_girth_mm(p.breadth_mm[g], p.depth_mm[g]); };
    }
    case SectionEstimator::superellipse: {
      const Superellipse shape(fitted_exponent(people, g));
      return [shape, g](const auto& p) { return shape.girth_mm(p.breadth_mm[g], p.depth_mm[g]); };
    }
    case SectionEstimator::quadratic:
      return linear_fit(people, g, quadratic_features);
    case SectionEstimator::synthetic:
      return linear_fit(synthetic, g, quadratic_features);
    case SectionEstimator::front:
      return linear_fit(people, g, front_features);
    case SectionEstimator::all_round:
      return linear_fit(people, g, all_round_features);
    case SectionEstimator::all_weighed:
      return linear_fit(people, g, all_weighed_features);
  }
  return [g](const auto& p) { return ellipse_girth_mm(p.breadth_mm[g], p.depth_mm[g]); };
}

std::vector<SectionPerson> with_noise(std::vector<SectionPerson> people, double noise_mm, std::uint64_t seed) {
  for (std::size_t i = 0; i < people.size(); ++i) {
    Rng rng = Rng::for_item(seed, kNoiseStream, i);
    for (std::size_t g = 0; g < kTrunkGirths; ++g) {
      people[i].breadth_mm[g] += rng.normal(0, noise_mm);
      people[i].depth_mm[g] += rng.normal(0, noise_mm);
    }
  }
  return people;
}

People pointers(const std::vector<SectionPerson>& people, const std::function<bool(std::size_t)>& taken) {
  People out;
  for (std::size_t i = 0; i < people.size(); ++i)
    if (taken(i)) out.push_back(&people[i]);
  return out;
}

ErrorStatistics cross_fitted(SectionEstimator estimator, const std::vector<SectionPerson>& people,
                             const People& synthetic, std::size_t g) {
  std::vector<double> errors;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    const People others = pointers(people, [&](std::size_t i) { return i % kFolds != fold; });
    const Guess guess = fitted(estimator, others, synthetic, g);
    for (std::size_t i = fold; i < people.size(); i += kFolds)
      errors.push_back(guess(people[i]) - people[i].girth_mm[g]);
  }
  return error_statistics(errors);
}

SectionPerson section_person(const body::BodyModel& model, const Subject& subject) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count())), posed(rest.size());
  morph_subject(model, subject, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model, rest);
  body::skin(model, rest, skeleton, body::relaxed_pose(skeleton, body::relaxed_spread_deg(model, rest)), posed);
  SectionPerson person;
  person.stature_mm = subject.truth[measurement_index(Measurement::stature)];
  person.weight_kg = subject.truth[measurement_index(Measurement::weight)];
  constexpr std::array<Measurement, kTrunkGirths> kIds = {Measurement::chest_girth, Measurement::waist_girth,
                                                          Measurement::hip_girth};
  for (const body::Section& section : body::girth_sections(model, posed, subject.params.gender))
    for (std::size_t g = 0; g < kTrunkGirths; ++g) {
      if (section.id != kIds[g] || section.hull.empty()) continue;
      const auto [left, right] =
          std::minmax_element(section.hull.begin(), section.hull.end(), [](Vec3f a, Vec3f b) { return a.x < b.x; });
      const auto [back, front] =
          std::minmax_element(section.hull.begin(), section.hull.end(), [](Vec3f a, Vec3f b) { return a.z < b.z; });
      person.breadth_mm[g] = right->x - left->x;
      person.depth_mm[g] = front->z - back->z;
      person.girth_mm[g] = subject.truth[measurement_index(kIds[g])];
    }
  return person;
}

}  // namespace

double ellipse_girth_mm(double breadth_mm, double depth_mm) {
  // Gauss: 2 pi (a^2 - sum of 2^(n-1) c_n^2) / M(a, b), with c_0^2 = a^2 - b^2 and c_n the half differences.
  double a = std::max(breadth_mm, depth_mm) / 2, b = std::min(breadth_mm, depth_mm) / 2;
  if (!(b > 0)) return 4 * a;
  const double first = a;
  double c = std::sqrt(a * a - b * b), power = 0.5, sum = power * c * c;
  while (c > 1e-12 * first) {
    c = (a - b) / 2;
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
    power *= 2;
    sum += power * c * c;
  }
  return 2 * std::numbers::pi * (first * first - sum) / a;
}

double superellipse_girth_mm(double breadth_mm, double depth_mm, double exponent) {
  return Superellipse(exponent).girth_mm(breadth_mm, depth_mm);
}

Result<SectionPeople> read_section_people(const std::string& ansur_folder) {
  SectionPeople people;
  for (const bool woman : {true, false}) {
    const auto rows = read_ansur_columns(ansur_folder, woman, kColumns);
    if (!rows) return rows.error();
    for (const std::vector<double>& row : *rows) {
      SectionPerson& person = people[woman ? 0 : 1].emplace_back();
      person.stature_mm = row[0];
      person.weight_kg = row[1] / 10;
      for (std::size_t g = 0; g < kTrunkGirths; ++g) {
        person.breadth_mm[g] = row[2 + 3 * g];
        person.depth_mm[g] = row[3 + 3 * g];
        person.girth_mm[g] = row[4 + 3 * g];
      }
    }
  }
  return people;
}

SectionPeople synthetic_section_people(const body::BodyModel& model, int count, int threads) {
  constexpr std::uint64_t kSeed = 0x5EC7104;
  std::vector<std::pair<bool, SectionPerson>> drawn(static_cast<std::size_t>(count));
  Progress progress("sections", drawn.size());
  for_each_item(
      drawn.size(), threads,
      [&](std::uint64_t i) {
        const Subject subject = draw_subject(model, Family::training, kSeed, i);
        drawn[i] = {subject.woman, section_person(model, subject)};
      },
      [&](std::uint64_t done) { progress.update(done); });
  SectionPeople people;
  for (const auto& [woman, person] : drawn) people[woman ? 0 : 1].push_back(person);
  return people;
}

SectionStudy study_sections(const SectionPeople& people, const SectionPeople& synthetic, double noise_mm) {
  SectionStudy study;
  for (std::size_t s = 0; s < 2; ++s) {
    const auto seen = with_noise(people[s], noise_mm, s);
    const auto all = [](std::size_t) { return true; };
    const People drawn = pointers(synthetic[s], all);
    for (std::size_t g = 0; g < kTrunkGirths; ++g) {
      study.factor[s][g] = fitted_factor(pointers(seen, all), g);
      study.exponent[s][g] = fitted_exponent(pointers(seen, all), g);
      for (std::size_t estimator = 0; estimator < kSectionEstimatorCount; ++estimator)
        if (static_cast<SectionEstimator>(estimator) != SectionEstimator::synthetic || !drawn.empty())
          study.errors[estimator][s][g] = cross_fitted(static_cast<SectionEstimator>(estimator), seen, drawn, g);
    }
  }
  return study;
}

}  // namespace im2fit::lab
