// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/proportions_check.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "evaluation/population/ansur.h"
#include "report/svg_plot.h"
#include "report/text_table.h"

namespace im2fit::lab {
namespace {

using body::Dimension;
using body::kDimensionCount;

constexpr std::array<AnsurColumn, kDimensionCount> kColumns = {{{"cervicaleheight"},
                                                                {"acromialheight"},
                                                                {"chestheight"},
                                                                {"waistheightomphalion"},
                                                                {"buttockheight"},
                                                                {"crotchheight"},
                                                                {"kneeheightmidpatella"},
                                                                {"biacromialbreadth"},
                                                                {"bideltoidbreadth"},
                                                                {"chestdepth"},
                                                                {"chestcircumference"},
                                                                {"waistbreadth", kWaistOverCalliper},
                                                                {"waistdepth", kWaistOverCalliper},
                                                                {"waistcircumference"},
                                                                {"hipbreadth", kHipOverCalliper},
                                                                {"buttockdepth", kHipOverCalliper},
                                                                {"buttockcircumference"},
                                                                {"neckcircumference"},
                                                                {"thighcircumference"},
                                                                {"calfcircumference"},
                                                                {"bicepscircumferenceflexed"},
                                                                {"forearmcircumferenceflexed"},
                                                                {"acromionradialelength"},
                                                                {"radialestylionlength"},
                                                                {"headbreadth"},
                                                                {"headlength"}}};
// Where a buttock is fullest is ill defined on people and on meshes alike: shown, not judged.
constexpr bool is_judged(std::size_t dimension) {
  return dimension != static_cast<std::size_t>(Dimension::buttock_height);
}
struct Ratio {
  std::string_view name;
  Dimension breadth, depth, girth;
};
constexpr Ratio kRatios[] = {
    {"waist breadth/depth", Dimension::waist_breadth, Dimension::waist_depth, Dimension::waist_girth},
    {"hip breadth/depth", Dimension::hip_breadth, Dimension::buttock_depth, Dimension::buttock_girth},
    {"chest girth/depth", Dimension::chest_girth, Dimension::chest_depth, Dimension::chest_girth}};
constexpr std::ptrdiff_t kGiven = 4;

// A row a person: the given values, and the logarithms of dimensions.
struct People {
  Eigen::MatrixXd given, logarithms;
  std::vector<double> mass_index;
  explicit People(std::size_t count)
      : given(static_cast<std::ptrdiff_t>(count), kGiven),
        logarithms(static_cast<std::ptrdiff_t>(count), static_cast<std::ptrdiff_t>(kDimensionCount)),
        mass_index(count) {}
  void set(std::size_t at, double stature_mm, double weight_kg, double age_years) {
    given.row(static_cast<std::ptrdiff_t>(at)) << 1, std::log(stature_mm), std::log(weight_kg), age_years;
    mass_index[at] = weight_kg / (stature_mm * stature_mm * 1e-6);
  }
};

Result<People> read_people(const std::string& folder, bool woman) {
  std::vector<std::string_view> columns = {"stature", "weightkg", "age"};
  for (const AnsurColumn& column : kColumns) columns.push_back(column.name);
  const auto rows = read_ansur_columns(folder, woman, columns);
  if (!rows) return rows.error();
  People people(rows->size());
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto& row = (*rows)[i];
    people.set(i, row[0], 0.1 * row[1], row[2]);
    for (std::size_t d = 0; d < kDimensionCount; ++d)
      people.logarithms(static_cast<std::ptrdiff_t>(i), static_cast<std::ptrdiff_t>(d)) =
          std::log(row[3 + d] * kColumns[d].mesh_factor);
  }
  return people;
}

Eigen::MatrixXd slopes_of(const Eigen::MatrixXd& given, const Eigen::MatrixXd& values) {
  return (given.transpose() * given).ldlt().solve(given.transpose() * values);
}
double sd_of(const Eigen::VectorXd& v) {
  return std::sqrt((v.array() - v.mean()).square().mean());
}

std::vector<double> means_by_third(const Eigen::VectorXd& values, const std::vector<double>& by) {
  std::vector<std::size_t> order(by.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return by[a] < by[b]; });
  std::vector<double> means;
  for (std::size_t third = 0; third < 3; ++third) {
    const std::size_t from = third * order.size() / 3, to = (third + 1) * order.size() / 3;
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += values(static_cast<std::ptrdiff_t>(order[i]));
    means.push_back(sum / static_cast<double>(std::max<std::size_t>(to - from, 1)));
  }
  return means;
}

DimensionComparison compare(std::string_view name, const Eigen::VectorXd& here, const Eigen::VectorXd& there,
                            double unit, const std::vector<double>& mass_index) {
  DimensionComparison out;
  out.name = name;
  out.residual_mean = here.mean() / unit;
  out.residual_by_third = means_by_third(here / unit, mass_index);
  out.spread = sd_of(here) / sd_of(there);
  return out;
}

ProportionComparison::Sex compare_sex(bool woman, const People& here, const People& there) {
  ProportionComparison::Sex sex;
  sex.woman = woman;
  const Eigen::MatrixXd slopes = slopes_of(there.given, there.logarithms);
  const Eigen::MatrixXd left_here = here.logarithms - here.given * slopes;
  const Eigen::MatrixXd left_there = there.logarithms - there.given * slopes;
  for (std::ptrdiff_t d = 0; d < left_here.cols(); ++d) {
    auto& out =
        sex.dimensions.emplace_back(compare(kColumns[static_cast<std::size_t>(d)].name, left_here.col(d),
                                            left_there.col(d), sd_of(there.logarithms.col(d)), here.mass_index));
    out.mean_mm = here.logarithms.col(d).array().exp().mean();
    out.ansur_mean_mm = there.logarithms.col(d).array().exp().mean();
  }
  for (const Ratio& ratio : kRatios) {
    // Also given the girth.
    const auto with_girth = [&](const People& people) {
      Eigen::MatrixXd given(people.given.rows(), kGiven + 1);
      given << people.given, people.logarithms.col(static_cast<std::ptrdiff_t>(ratio.girth));
      return given;
    };
    const auto value = [&](const People& people) -> Eigen::VectorXd {
      return people.logarithms.col(static_cast<std::ptrdiff_t>(ratio.breadth)) -
             people.logarithms.col(static_cast<std::ptrdiff_t>(ratio.depth));
    };
    const Eigen::MatrixXd given_here = with_girth(here), given_there = with_girth(there);
    const Eigen::VectorXd law = slopes_of(given_there, value(there));
    const Eigen::VectorXd rest_here = value(here) - given_here * law, rest_there = value(there) - given_there * law;
    sex.ratios.push_back(compare(ratio.name, rest_here, rest_there, sd_of(rest_there), here.mass_index));
  }
  double squares = 0;
  int pairs = 0;
  const auto correlation = [](const Eigen::MatrixXd& m, std::ptrdiff_t a, std::ptrdiff_t b) {
    const Eigen::VectorXd x = m.col(a).array() - m.col(a).mean(), y = m.col(b).array() - m.col(b).mean();
    return x.dot(y) / std::sqrt(x.squaredNorm() * y.squaredNorm());
  };
  for (std::ptrdiff_t a = 0; a < left_here.cols(); ++a)
    for (std::ptrdiff_t b = 0; b < a; ++b) {
      if (!is_judged(static_cast<std::size_t>(a)) || !is_judged(static_cast<std::size_t>(b))) continue;
      const double difference = correlation(left_here, a, b) - correlation(left_there, a, b);
      squares += difference * difference;
      ++pairs;
      if (std::fabs(difference) > std::fabs(sex.correlation_most)) {
        sex.correlation_most = difference;
        sex.correlation_most_of = fmt::format("{} with {}", kColumns[static_cast<std::size_t>(a)].name,
                                              kColumns[static_cast<std::size_t>(b)].name);
      }
    }
  sex.correlation_rms = std::sqrt(squares / std::max(pairs, 1));
  return sex;
}

void judge(const ProportionComparison::Sex& sex, const ProportionTolerances& t, std::vector<std::string>& broken) {
  const char* who = sex.woman ? "women's" : "men's";
  const auto expect = [&](const DimensionComparison& d, double mean_most, double spread_most) {
    if (std::fabs(d.residual_mean) > mean_most)
      broken.push_back(
          fmt::format("{} {}, mean at equal stature, weight and age: {:+.2f} SD from ANSUR II's, allowed "
                      "{:.2f}",
                      who, d.name, d.residual_mean, mean_most));
    if (std::fabs(d.spread - 1) > spread_most)
      broken.push_back(
          fmt::format("{} {}, spread at equal stature, weight and age: {:.2f} of ANSUR II's, allowed "
                      "{:.2f} to {:.2f}",
                      who, d.name, d.spread, 1 - spread_most, 1 + spread_most));
  };
  for (std::size_t d = 0; d < sex.dimensions.size(); ++d)
    if (is_judged(d)) expect(sex.dimensions[d], t.mean_sd, t.spread);
  for (const DimensionComparison& r : sex.ratios) expect(r, t.ratio_mean_sd, t.ratio_spread);
  if (sex.correlation_rms > t.correlation)
    broken.push_back(fmt::format("{} residual correlations differ by {:.2f} (root mean square), allowed {:.2f}", who,
                                 sex.correlation_rms, t.correlation));
}

}  // namespace

const AnsurColumn& ansur_column(Dimension dimension) {
  return kColumns[static_cast<std::size_t>(dimension)];
}

Result<ProportionComparison> compare_proportions(const std::vector<Subject>& subjects,
                                                 const std::vector<body::Dimensions>& dimensions,
                                                 const std::string& ansur_folder,
                                                 const ProportionTolerances& tolerances) {
  ProportionComparison out;
  for (const bool woman : {true, false}) {
    const auto there = read_people(ansur_folder, woman);
    if (!there) return there.error();
    std::vector<std::size_t> of_sex;
    for (std::size_t i = 0; i < subjects.size(); ++i)
      if (subjects[i].woman == woman) of_sex.push_back(i);
    if (of_sex.size() < 100)
      return Error{ErrorCode::invalid_argument, "population: too few people to compare; draw at least 1000"};
    People here(of_sex.size());
    for (std::size_t i = 0; i < of_sex.size(); ++i) {
      const Subject& subject = subjects[of_sex[i]];
      here.set(i, static_cast<double>(subject.truth[measurement_index(Measurement::stature)]),
               static_cast<double>(subject.truth[measurement_index(Measurement::weight)]),
               static_cast<double>(subject.params.age_years));
      for (std::size_t d = 0; d < kDimensionCount; ++d)
        here.logarithms(static_cast<std::ptrdiff_t>(i), static_cast<std::ptrdiff_t>(d)) =
            std::log(std::max(dimensions[of_sex[i]].mm[d], 1.0));
    }
    out.sexes.push_back(compare_sex(woman, here, *there));
    judge(out.sexes.back(), tolerances, out.broken);
  }
  return out;
}

std::string text_of(const ProportionComparison& comparison) {
  std::string text;
  for (const auto& sex : comparison.sexes) {
    TextTable table({sex.woman ? "women, dimension" : "men, dimension", "mean mm", "ANSUR II mm",
                     "off at equal stature, weight, age: SD", "by third of BMI", "spread / ANSUR II's"});
    const auto add = [&](const DimensionComparison& d, bool has_mean) {
      table.add({d.name, has_mean ? number(d.mean_mm, 0) : "-", has_mean ? number(d.ansur_mean_mm, 0) : "-",
                 fmt::format("{:+.2f}", d.residual_mean),
                 fmt::format("{:+.2f} {:+.2f} {:+.2f}", d.residual_by_third[0], d.residual_by_third[1],
                             d.residual_by_third[2]),
                 number(d.spread, 2)});
    };
    for (const auto& d : sex.dimensions) add(d, true);
    for (const auto& r : sex.ratios) add(r, false);
    text += table.text();
    text += fmt::format("residual correlations differ by {:.2f} (root mean square), most {:+.2f}: {}\n\n",
                        sex.correlation_rms, sex.correlation_most, sex.correlation_most_of);
  }
  for (const auto& line : comparison.broken) text += "beyond tolerance: " + line + "\n";
  if (comparison.broken.empty()) text += "all dimensions within tolerance\n";
  return text;
}

std::string plot_of(const ProportionComparison& comparison) {
  constexpr double kLeft = 190, kTop = 60, kRow = 18, kWide = 260, kGap = 60;
  std::size_t rows = 0;
  for (const auto& sex : comparison.sexes) rows = std::max(rows, sex.dimensions.size() + sex.ratios.size());
  const double tall = static_cast<double>(rows) * kRow;
  Svg svg(kLeft + 4 * (kWide + kGap), kTop + tall + 60, "Dimensions of synthetic people beside ANSUR II's");
  double x = kLeft;
  for (const auto& sex : comparison.sexes) {
    const std::string who = sex.woman ? "women" : "men";
    const Panel means(svg, {x, kTop, kWide, tall}, {-1, 1, who + ": mean off, SD (discs: thirds of BMI)"},
                      {0, static_cast<double>(rows), "", false, 0});
    const Panel spreads(svg, {x + kWide + kGap, kTop, kWide, tall}, {0.6, 1.4, who + ": spread over ANSUR II's"},
                        {0, static_cast<double>(rows), "", false, 0});
    svg.line(means.at(0, 0), means.at(0, static_cast<double>(rows)), {kInk, 1});
    svg.line(spreads.at(1, 0), spreads.at(1, static_cast<double>(rows)), {kInk, 1});
    std::vector<DimensionComparison> all = sex.dimensions;
    all.insert(all.end(), sex.ratios.begin(), sex.ratios.end());
    const char* const shades[] = {kSky, kBlue, kInk};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double y = static_cast<double>(rows - i) - 0.5;
      if (sex.woman) svg.text({kLeft - 8, means.y(y) + 4}, all[i].name, {Lettering::Anchor::end, 11});
      const auto shown = [](double v) { return std::clamp(v, -1.0, 1.0); };
      for (std::size_t k = 0; k < 3; ++k)
        svg.disc(means.at(shown(all[i].residual_by_third[k]), y), 3, shades[k], 0.6);
      svg.rectangle({means.x(shown(all[i].residual_mean)) - 2, means.y(y) - 6}, 4, 12, kRed);
      svg.rectangle({spreads.x(std::clamp(all[i].spread, 0.6, 1.4)) - 2, spreads.y(y) - 6}, 4, 12, kRed);
    }
    x += 2 * (kWide + kGap);
  }
  return svg.file();
}

}  // namespace im2fit::lab
