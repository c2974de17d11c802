// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <string_view>

#include "evaluation/population/ansur.h"

namespace im2fit::lab {
namespace {

struct Source {
  SurveyDimension dimension;
  std::string_view column;
  double man = 1, woman = 1;  // times the survey's value
};
// Relaxed over flexed.
constexpr double kArmMan = 0.92, kArmWoman = 0.95, kForearm = 0.97;
constexpr double kKgOfWeight = 0.1;
constexpr std::array kSources = {
    Source{SurveyDimension::stature, "stature"},
    Source{SurveyDimension::cervicale_height, "cervicaleheight"},
    Source{SurveyDimension::acromial_height, "acromialheight"},
    Source{SurveyDimension::chest_height, "chestheight"},
    Source{SurveyDimension::waist_height, "waistheightomphalion"},
    Source{SurveyDimension::buttock_height, "buttockheight"},
    Source{SurveyDimension::crotch_height, "crotchheight"},
    Source{SurveyDimension::trochanter_height, "trochanterionheight"},
    Source{SurveyDimension::knee_height, "kneeheightmidpatella"},
    Source{SurveyDimension::chest_breadth, "chestbreadth"},
    Source{SurveyDimension::chest_depth, "chestdepth"},
    Source{SurveyDimension::chest_girth, "chestcircumference"},
    Source{SurveyDimension::waist_breadth, "waistbreadth"},
    Source{SurveyDimension::waist_depth, "waistdepth"},
    Source{SurveyDimension::waist_girth, "waistcircumference"},
    Source{SurveyDimension::hip_breadth, "hipbreadth"},
    Source{SurveyDimension::hip_depth, "buttockdepth"},
    Source{SurveyDimension::hip_girth, "buttockcircumference"},
    Source{SurveyDimension::neck_girth, "neckcircumference"},
    Source{SurveyDimension::thigh_girth, "thighcircumference"},
    Source{SurveyDimension::lower_thigh_girth, "lowerthighcircumference"},
    Source{SurveyDimension::calf_girth, "calfcircumference"},
    Source{SurveyDimension::ankle_girth, "anklecircumference"},
    Source{SurveyDimension::upper_arm_girth, "bicepscircumferenceflexed", kArmMan, kArmWoman},
    Source{SurveyDimension::forearm_girth, "forearmcircumferenceflexed", kForearm, kForearm},
    Source{SurveyDimension::wrist_girth, "wristcircumference"},
    Source{SurveyDimension::acromion_breadth, "biacromialbreadth"},
    Source{SurveyDimension::deltoid_breadth, "bideltoidbreadth"},
    Source{SurveyDimension::upper_arm_length, "acromionradialelength"},
    Source{SurveyDimension::forearm_length, "radialestylionlength"},
    Source{SurveyDimension::hand_length, "handlength"},
    Source{SurveyDimension::head_breadth, "headbreadth"},
    Source{SurveyDimension::head_length, "headlength"},
    Source{SurveyDimension::crown_height, "tragiontopofhead"},
    Source{SurveyDimension::foot_length, "footlength"},
    Source{SurveyDimension::foot_breadth, "footbreadthhorizontal"},
    Source{SurveyDimension::weight, "weightkg", kKgOfWeight, kKgOfWeight},
};
constexpr std::size_t kAge = kSources.size();  // the last column

constexpr std::size_t column_of(SurveyDimension d) {
  for (std::size_t i = 0; i < kSources.size(); ++i)
    if (kSources[i].dimension == d) return i;
  return kSources.size();
}
constexpr std::size_t kStature = column_of(SurveyDimension::stature), kWeight = column_of(SurveyDimension::weight);

double mass_index(const std::vector<double>& row) {
  return row[kWeight] * kKgOfWeight / (row[kStature] * row[kStature] * 1e-6);
}

// log(value) on log(weight) and log(stature): the first coefficient.
double elasticity(const std::vector<std::vector<double>>& people, std::size_t column) {
  double w = 0, h = 0, y = 0;
  const auto n = static_cast<double>(people.size());
  for (const auto& row : people) {
    w += std::log(row[kWeight]) / n;
    h += std::log(row[kStature]) / n;
    y += std::log(row[column]) / n;
  }
  double ww = 0, hh = 0, wh = 0, wy = 0, hy = 0;
  for (const auto& row : people) {
    const double dw = std::log(row[kWeight]) - w, dh = std::log(row[kStature]) - h, dy = std::log(row[column]) - y;
    ww += dw * dw, hh += dh * dh, wh += dw * dh, wy += dw * dy, hy += dh * dy;
  }
  return (wy * hh - hy * wh) / (ww * hh - wh * wh);
}

// The breadth at which an ellipse of this depth has this perimeter.
double breadth_for(double perimeter, double depth) {
  double low = 1, high = perimeter;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (ellipse_perimeter(middle, depth) < perimeter ? low : high) = middle;
  }
  return low;
}

}  // namespace

double ellipse_perimeter(double breadth, double depth) {
  const double a = breadth / 2, b = depth / 2;
  const double h = (a - b) * (a - b) / ((a + b) * (a + b));
  return std::numbers::pi * (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
}

Result<AnsurRows> AnsurRows::load(const std::string& folder) {
  std::vector<std::string_view> columns;
  for (const Source& source : kSources) columns.push_back(source.column);
  columns.emplace_back("age");
  AnsurRows out;
  for (const bool woman : {false, true}) {
    auto rows = read_ansur_columns(folder, woman, columns);
    if (!rows)
      return Error{rows.error().code, rows.error().message +
                                          " (people of the family ansur are made to ANSUR II's dimensions: give the "
                                          "folder of its two files, ANSUR_II_{FEMALE,MALE}_Public.csv, by --ansur)"};
    Sex sex;
    for (std::size_t i = 0; i < rows->size(); ++i)
      if (held_out_row(woman, i)) sex.people.push_back(std::move((*rows)[i]));
    for (std::size_t c = 0; c < columns.size(); ++c) sex.elasticity.push_back(elasticity(sex.people, c));
    sex.by_mass_index.resize(sex.people.size());
    std::iota(sex.by_mass_index.begin(), sex.by_mass_index.end(), std::size_t{0});
    std::stable_sort(sex.by_mass_index.begin(), sex.by_mass_index.end(), [&](std::size_t a, std::size_t b) {
      return mass_index(sex.people[a]) < mass_index(sex.people[b]);
    });
    for (const auto& row : sex.people) {
      const double breadth = breadth_for(row[column_of(SurveyDimension::chest_girth)] / kChestOverEllipse,
                                         row[column_of(SurveyDimension::chest_depth)]);
      sex.chest_wider_mm +=
          (breadth - row[column_of(SurveyDimension::chest_breadth)]) / static_cast<double>(sex.people.size());
    }
    out.sexes_.push_back(std::move(sex));
  }
  return out;
}

WantedPerson AnsurRows::draw(bool woman, const AnsurSettings& settings, Rng& rng) const {
  const Sex& sex = sexes_[woman ? 1 : 0];
  const auto people = static_cast<int>(sex.people.size());
  // The same draws whichever way, so that the share changes only those it takes.
  const bool to_end = rng.uniform() < settings.end_share;
  const bool heavy = rng.uniform() < 0.5;
  const double index_wanted = heavy ? rng.uniform(32, 42) : rng.uniform(17, 19);
  const int any = rng.index(people), in_third = rng.index(people / 3);
  if (!to_end) return wanted_of(woman, sex.people[static_cast<std::size_t>(any)], settings, rng);
  const auto place = static_cast<std::size_t>(heavy ? people - 1 - in_third : in_third);
  std::vector<double> row = sex.people[sex.by_mass_index[place]];
  const double times = index_wanted / mass_index(row);
  for (std::size_t c = 0; c < kSources.size(); ++c)
    if (c != kStature) row[c] *= c == kWeight ? times : std::pow(times, sex.elasticity[c]);
  return wanted_of(woman, row, settings, rng);
}

std::array<std::size_t, 2> AnsurRows::between(bool woman, double index_low, double index_high) const {
  const Sex& sex = sexes_[woman ? 1 : 0];
  const auto first_from = [&](double index) {
    const auto place = std::partition_point(sex.by_mass_index.begin(), sex.by_mass_index.end(),
                                            [&](std::size_t row) { return mass_index(sex.people[row]) < index; });
    return static_cast<std::size_t>(place - sex.by_mass_index.begin());
  };
  return {first_from(index_low), first_from(index_high)};
}

std::size_t AnsurRows::count_between(bool woman, double index_low, double index_high) const {
  const auto [first, end] = between(woman, index_low, index_high);
  return end - first;
}

WantedPerson AnsurRows::draw_between(bool woman, double index_low, double index_high, const AnsurSettings& settings,
                                     Rng& rng) const {
  const Sex& sex = sexes_[woman ? 1 : 0];
  const auto [first, end] = between(woman, index_low, index_high);
  const auto place = first + static_cast<std::size_t>(rng.index(static_cast<int>(end - first)));
  return wanted_of(woman, sex.people[sex.by_mass_index[place]], settings, rng);
}

WantedPerson AnsurRows::wanted_of(bool woman, const std::vector<double>& row, const AnsurSettings& settings,
                                  Rng& rng) const {
  WantedPerson person;
  person.woman = woman;
  person.age_years = row[kAge];
  person.wanted.fill(std::numeric_limits<double>::quiet_NaN());
  const auto value = [&](SurveyDimension d) -> double& { return person.wanted[dimension_index(d)]; };
  for (std::size_t c = 0; c < kSources.size(); ++c)
    value(kSources[c].dimension) = row[c] * (woman ? kSources[c].woman : kSources[c].man);
  value(SurveyDimension::chest_breadth) += sexes_[woman ? 1 : 0].chest_wider_mm;
  for (const auto& [breadth, depth, girth] :
       {std::array{SurveyDimension::waist_breadth, SurveyDimension::waist_depth, SurveyDimension::waist_girth},
        std::array{SurveyDimension::hip_breadth, SurveyDimension::hip_depth, SurveyDimension::hip_girth}}) {
    const double square =
        settings.square_share > 0 ? std::clamp(rng.normal(settings.square_share, kSquareShareSd), 0.0, 1.0) : 0.0;
    const double pressed = std::min(settings.pressed_share, 1 - square);
    const double ellipse = ellipse_perimeter(value(breadth), value(depth));
    const double excess = std::max(0.0, value(girth) - ellipse);
    const double larger = 1 + pressed * excess / ellipse;
    value(breadth) *= larger;
    value(depth) *= larger;
    value(girth) = ellipse + (pressed + square) * excess;
  }
  return person;
}

}  // namespace im2fit::lab
