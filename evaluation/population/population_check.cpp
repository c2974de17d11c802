// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/population_check.h"

#include <fmt/core.h>

#include <cmath>

#include "evaluation/population/ansur.h"
#include "report/text_table.h"

namespace im2fit::lab {
namespace {

// US adults of NHANES 1999-2002.
struct Nhanes {
  double stature_mm, stature_sd_mm, weight_kg, weight_sd_kg;
};
constexpr Nhanes kNhanesWomen{1618, 70, 76, 20};
constexpr Nhanes kNhanesMen{1759, 75, 88.8, 20};

// Stature and the logarithm of weight as two normals that go together.
struct StatureAndWeight {
  double mean[2] = {}, variance[2] = {}, covariance = 0;

  static std::array<double, 2> of(const ComparedRow& row) { return {row[0], std::log(row[1])}; }
  explicit StatureAndWeight(const std::vector<ComparedRow>& rows) {
    const auto n = static_cast<double>(rows.size());
    for (const auto& row : rows)
      for (std::size_t i = 0; i < 2; ++i) mean[i] += of(row)[i] / n;
    for (const auto& row : rows) {
      const double a = of(row)[0] - mean[0], b = of(row)[1] - mean[1];
      variance[0] += a * a / n;
      variance[1] += b * b / n;
      covariance += a * b / n;
    }
  }
  double log_density(const ComparedRow& row) const {
    const double determinant = variance[0] * variance[1] - covariance * covariance;
    const double a = of(row)[0] - mean[0], b = of(row)[1] - mean[1];
    const double squared = (variance[1] * a * a - 2 * covariance * a * b + variance[0] * b * b) / determinant;
    return -0.5 * squared - 0.5 * std::log(determinant);
  }
};

class Judge {
 public:
  explicit Judge(std::vector<std::string>& broken) : broken_(broken) {}
  void expect(const std::string& what, double found, double wanted, double tolerance, int digits) {
    if (std::fabs(found - wanted) <= tolerance) return;
    broken_.push_back(fmt::format("{} is {:.{}f}, expected {:.{}f} +- {:.{}f}", what, found, digits, wanted, digits,
                                  tolerance, digits));
  }

 private:
  std::vector<std::string>& broken_;
};

void judge(const PopulationComparison::Sex& sex, const PopulationTolerances& t, std::vector<std::string>& broken) {
  Judge judge(broken);
  const std::string who = sex.woman ? "women's " : "men's ";
  const Nhanes& n = sex.woman ? kNhanesWomen : kNhanesMen;
  judge.expect(who + "mean stature (NHANES)", sex.drawn.mean[0], n.stature_mm, t.nhanes_stature_mm, 1);
  judge.expect(who + "mean weight (NHANES)", sex.drawn.mean[1], n.weight_kg, t.nhanes_weight_kg, 1);
  judge.expect(who + "SD of stature (NHANES)", sex.drawn.sd[0], n.stature_sd_mm, t.nhanes_sd * n.stature_sd_mm, 1);
  judge.expect(who + "SD of weight (NHANES)", sex.drawn.sd[1], n.weight_sd_kg, t.nhanes_sd * n.weight_sd_kg, 1);
  for (std::size_t i = 0; i < kComparedCount; ++i) {
    const std::string name = who + std::string(kCompared[i].name);
    const PeopleMoments &found = sex.like_ansur, &real = sex.ansur;
    // Of girths the mean and spread are judged at equal age, too (proportions_check.h).
    if (i < 2) judge.expect(name + ", mean (ANSUR II)", found.mean[i], real.mean[i], t.ansur_mean * real.mean[i], 1);
    if (i < 2) judge.expect(name + ", SD (ANSUR II)", found.sd[i], real.sd[i], t.ansur_sd * real.sd[i], 1);
    for (std::size_t j = 0; j < i; ++j)
      judge.expect(name + " with " + std::string(kCompared[j].name) + ", correlation (ANSUR II)",
                   found.correlation[i][j], real.correlation[i][j], t.ansur_correlation, 2);
  }
}

ComparedRow row_of(const Subject& subject, const body::Dimensions& dimensions) {
  using body::Dimension;
  return {static_cast<double>(subject.truth[measurement_index(Measurement::stature)]),
          static_cast<double>(subject.truth[measurement_index(Measurement::weight)]),
          dimensions[Dimension::chest_girth], dimensions[Dimension::waist_girth],
          dimensions[Dimension::buttock_girth]};
}

}  // namespace

PeopleMoments moments_of(const std::vector<ComparedRow>& rows, const std::vector<double>& weights) {
  PeopleMoments m;
  double sum = 0, squares = 0;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    sum += weight(i);
    squares += weight(i) * weight(i);
    for (std::size_t c = 0; c < kComparedCount; ++c) m.mean[c] += weight(i) * rows[i][c];
  }
  if (sum <= 0) return m;
  m.people = sum * sum / squares;
  for (double& mean : m.mean) mean /= sum;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t a = 0; a < kComparedCount; ++a)
      for (std::size_t b = 0; b < kComparedCount; ++b)
        m.correlation[a][b] += weight(i) / sum * (rows[i][a] - m.mean[a]) * (rows[i][b] - m.mean[b]);
  for (std::size_t a = 0; a < kComparedCount; ++a) m.sd[a] = std::sqrt(m.correlation[a][a]);
  for (std::size_t a = 0; a < kComparedCount; ++a)
    for (std::size_t b = 0; b < kComparedCount; ++b) m.correlation[a][b] /= m.sd[a] * m.sd[b];
  return m;
}

Result<std::vector<ComparedRow>> read_ansur(const std::string& folder, bool woman) {
  std::array<std::string_view, kComparedCount> columns;
  for (std::size_t c = 0; c < kComparedCount; ++c) columns[c] = kCompared[c].ansur;
  const auto people = read_ansur_columns(folder, woman, columns);
  if (!people) return people.error();
  std::vector<ComparedRow> rows;
  for (const std::vector<double>& person : *people) {
    ComparedRow& row = rows.emplace_back();
    for (std::size_t c = 0; c < kComparedCount; ++c) row[c] = person[c] * kCompared[c].ansur_unit;
  }
  return rows;
}

Result<PopulationComparison> compare_population(const std::vector<Subject>& subjects,
                                                const std::vector<body::Dimensions>& dimensions,
                                                const std::string& ansur_folder,
                                                const PopulationTolerances& tolerances) {
  PopulationComparison comparison;
  for (std::size_t s = 0; s < 2; ++s) {
    PopulationComparison::Sex& sex = comparison.sexes[s];
    sex.woman = s == 0;
    auto real = read_ansur(ansur_folder, sex.woman);
    if (!real) return real.error();
    sex.ansur_rows = std::move(*real);
    for (std::size_t i = 0; i < subjects.size(); ++i)
      if (subjects[i].woman == sex.woman) sex.rows.push_back(row_of(subjects[i], dimensions[i]));
    if (sex.rows.size() < 100)
      return Error{ErrorCode::invalid_argument, "population: too few people to compare; draw at least 1000"};
    const StatureAndWeight here(sex.rows), there(sex.ansur_rows);
    for (const ComparedRow& row : sex.rows)
      sex.weights.push_back(std::exp(there.log_density(row) - here.log_density(row)));
    sex.drawn = moments_of(sex.rows, {});
    sex.like_ansur = moments_of(sex.rows, sex.weights);
    sex.ansur = moments_of(sex.ansur_rows, {});
    judge(sex, tolerances, comparison.broken);
  }
  return comparison;
}

std::string text_of(const PopulationComparison& comparison) {
  TextTable means({"mean +- SD", "drawn", "NHANES", "at ANSUR II's stature and weight", "ANSUR II"});
  TextTable pairs({"correlation", "drawn", "at ANSUR II's stature and weight", "ANSUR II"});
  const auto spread = [](double mean, double sd) { return number(mean, 1) + " +- " + number(sd, 1); };
  for (const auto& sex : comparison.sexes) {
    const Nhanes& n = sex.woman ? kNhanesWomen : kNhanesMen;
    const std::string who = sex.woman ? "women " : "men ";
    for (std::size_t i = 0; i < kComparedCount; ++i) {
      const std::string nhanes = i == 0   ? spread(n.stature_mm, n.stature_sd_mm)
                                 : i == 1 ? spread(n.weight_kg, n.weight_sd_kg)
                                          : "-";
      means.add({who + std::string(kCompared[i].name) + " " + std::string(kCompared[i].unit),
                 spread(sex.drawn.mean[i], sex.drawn.sd[i]), nhanes,
                 spread(sex.like_ansur.mean[i], sex.like_ansur.sd[i]), spread(sex.ansur.mean[i], sex.ansur.sd[i])});
      for (std::size_t j = 0; j < i; ++j)
        pairs.add({who + std::string(kCompared[i].name) + ", " + std::string(kCompared[j].name),
                   number(sex.drawn.correlation[i][j], 2), number(sex.like_ansur.correlation[i][j], 2),
                   number(sex.ansur.correlation[i][j], 2)});
    }
  }
  std::string text = means.text() + "\n" + pairs.text();
  for (const auto& line : comparison.broken) text += "beyond tolerance: " + line + "\n";
  if (comparison.broken.empty()) text += "all within tolerance\n";
  return text;
}

}  // namespace im2fit::lab
