// SPDX-License-Identifier: Apache-2.0
#include "train/population/drawn_people.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "body/measure.h"
#include "core/rng.h"
#include "train/population/proportions.h"
#include "train/population/shape_spread.h"
#include "train/population/solve.h"

namespace im2fit::body {
namespace {

constexpr std::array<AgeGroup, 4> kMen = {{{18, 25, 0.13, 176.7, 0.3, 83.4, 0.7},
                                           {25, 45, 0.36, 176.8, 0.3, 87.6, 0.8},
                                           {45, 65, 0.35, 175.8, 0.3, 88.8, 0.9},
                                           {65, 75, 0.16, 174.4, 0.3, 87.1, 0.6}}};
constexpr std::array<AgeGroup, 4> kWomen = {{{18, 25, 0.13, 162.8, 0.3, 71.1, 0.9},
                                             {25, 45, 0.35, 163.2, 0.3, 75.3, 1.0},
                                             {45, 65, 0.35, 162.3, 0.3, 76.9, 1.1},
                                             {65, 75, 0.17, 160.0, 0.2, 74.9, 0.6}}};

// Family tags keep the families' seed spaces apart: the same seed and index never meet.
constexpr std::array<std::uint64_t, 3> kFamilyTag = {0x7061706572000001ULL, 0x747261696E000002ULL,
                                                     0x68656C646F757403ULL};
enum Stream : std::uint64_t { kBuildStream = 0x9001, kShapeStream = 0x9002, kProportionsStream = 0x9005 };
constexpr int kAttemptCount = 8;

double limited_normal(Rng& rng, double sd_max) {
  return std::clamp(rng.normal(), -sd_max, sd_max);
}

// Marsaglia and Tsang 2000; shapes below one by the usual boost.
double gamma_draw(Rng& rng, double shape) {
  if (shape < 1) return gamma_draw(rng, shape + 1) * std::pow(1 - rng.uniform(), 1 / shape);
  const double d = shape - 1.0 / 3;
  const double c = 1 / std::sqrt(9 * d);
  while (true) {
    const double x = rng.normal();
    const double t = 1 + c * x;
    const double v = t * t * t;
    if (v > 0 && std::log(1 - rng.uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
  }
}

// Training: mostly one origin. Held out: mixtures, another centre. The paper's: MakeHuman's even mixture.
std::array<float, 3> draw_race(Family family, Rng& rng) {
  if (family == Family::paper) return {1.0F / 3, 1.0F / 3, 1.0F / 3};
  const std::array<double, 3> shape =
      family == Family::training ? std::array<double, 3>{0.5, 0.4, 1.2} : std::array<double, 3>{2.0, 2.5, 2.0};
  std::array<double, 3> draw{};
  double sum = 1e-12;
  for (std::size_t i = 0; i < 3; ++i) sum += draw[i] = gamma_draw(rng, shape[i]);
  return {static_cast<float>(draw[0] / sum), static_cast<float>(draw[1] / sum),
          static_cast<float>(1 - draw[0] / sum - draw[1] / sum)};
}

float draw_gender(Family family, bool woman, Rng& rng) {
  const double reach = family == Family::paper ? 0 : family == Family::training ? 0.05 : 0.15;
  const double mixed = rng.uniform(0, 1) * reach;
  return static_cast<float>(woman ? mixed : 1 - mixed);
}

float slider(Rng& rng, double mean, double sd, double low, double high) {
  return static_cast<float>(std::clamp(rng.normal(mean, sd), low, high));
}

// MakeHuman's hips grow with weight by 6.4 mm a kilogram in men and 7.4 in women where ANSUR II's grow by 5.0
// and 6.3: local modifiers by body mass index take off the excess of the heavy and add to the light.
struct ByMass {
  const char* modifier;
  double per_index;  // value a kg/m^2 above kMiddleIndex
};
constexpr ByMass kByMass[] = {{"measure/measure-hips-circ", -0.05}, {"buttocks/buttocks-volume", -0.03}};
constexpr double kMiddleIndex = 26;
constexpr double kIndexLess = 8, kIndexMore = 14;  // farther from the middle it stays

void shape_by_mass(const BodyModel& model, double mass_index, std::vector<float>& modifiers) {
  for (const ByMass& row : kByMass) {
    const int index = model.modifier_index(row.modifier);
    if (index < 0) continue;
    modifiers[static_cast<std::size_t>(index)] +=
        static_cast<float>(row.per_index * std::clamp(mass_index - kMiddleIndex, -kIndexLess, kIndexMore));
  }
}

Params draw_params(const BodyModel& model, Family family, const Drawn& drawn, const Build& build, int attempt) {
  Rng rng = Rng::for_item(drawn.seed, kShapeStream, static_cast<std::uint64_t>(attempt));
  Params p;
  p.gender = draw_gender(family, drawn.woman, rng);
  p.age_years = static_cast<float>(build.age_years);
  p.race = draw_race(family, rng);
  const double metres = build.stature_mm / 1000;
  const double bmi = build.weight_kg / (metres * metres);
  // Much mass needs little muscle (the weight slider saturates); each failed attempt goes on
  // in the direction that reaches farther.
  const double muscle = (drawn.woman ? 0.42 : 0.48) - 0.025 * (bmi - 24) - 0.04 * attempt;
  const bool varied = family != Family::paper;
  p.muscle = slider(rng, muscle, varied ? 0.13 : 0.05, 0.0, 0.9);
  p.proportions = slider(rng, 0.55, varied ? 0.09 : 0.05, 0.3, 0.8);
  p.cup = slider(rng, 0.5, varied ? 0.2 : 0.05, 0.05, 0.95);
  p.firmness = slider(rng, 0.55, varied ? 0.2 : 0.05, 0.05, 0.95);
  if (varied) {
    const SpreadUse use = family == Family::training ? SpreadUse::training : SpreadUse::held_out;
    p.modifiers = draw_modifiers(model, use, drawn.woman, rng);
    shape_by_mass(model, bmi, p.modifiers);
  } else {
    p.modifiers.assign(model.modifier_names().size(), 0.0F);
  }
  return p;
}

// Logarithms and cosines may differ in their last bit between machines; sliders on a coarse grid do not.
float gridded(float slider) {
  return std::round(slider * 65536) / 65536;
}

void put_on_grid(Params& p) {
  for (float* slider : {&p.gender, &p.age_years, &p.muscle, &p.proportions, &p.cup, &p.firmness})
    *slider = gridded(*slider);
  p.race = {gridded(p.race[0]), gridded(p.race[1]), 0};
  p.race[2] = 1 - p.race[0] - p.race[1];
  for (float& modifier : p.modifiers) modifier = gridded(modifier);
}

void give_proportions(const BodyModel& model, const Build& build, Drawn& drawn) {
  Rng rng = Rng::for_item(drawn.seed, kProportionsStream, 0);
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(drawn.params, rest);
  drawn.params.warp = draw_warp(model, drawn.woman, build, rng, rest);
}

std::uint64_t seed_of_person(Family family, std::uint64_t seed, std::uint64_t number) {
  return Rng::for_item(seed, kFamilyTag[static_cast<std::size_t>(family)], number).next();
}

bool is_woman(std::uint64_t number) {
  return (number & 1) != 0;
}

Status check_version(std::uint32_t version) {
  if (version == kPopulationVersion) return Ok{};
  return Error{ErrorCode::unsupported, "the index' people are of version " + std::to_string(version) +
                                           " of the population, this program draws version " +
                                           std::to_string(kPopulationVersion) + "; build the index again"};
}

}  // namespace

std::span<const AgeGroup> age_groups(bool woman) {
  return woman ? kWomen : kMen;
}

Build draw_build(Family family, bool woman, std::uint64_t person_seed) {
  Rng rng = Rng::for_item(person_seed, kBuildStream, 0);
  const auto groups = age_groups(woman);
  double left = rng.uniform();
  std::size_t g = 0;
  while (g + 1 < groups.size() && left >= groups[g].share) left -= groups[g++].share;
  const AgeGroup& group = groups[g];
  Build b;
  b.age_years = rng.uniform(group.age_low, group.age_high);
  const double tall = limited_normal(rng, 3);
  if (family == Family::paper) {
    b.stature_mm = 10 * (group.stature_cm + group.stature_error_cm * tall);
    b.weight_kg = group.weight_kg + group.weight_error_kg * limited_normal(rng, 3);
    return b;
  }
  b.stature_mm = 10 * (group.stature_cm + (woman ? 7.0 : 7.5) * tall);
  const double relative = 20 / group.weight_kg;
  const double log_variance = std::log(1 + relative * relative);
  const double with_stature = woman ? 0.28 : 0.42;
  const double own = limited_normal(rng, 3);
  const double z = with_stature * tall + std::sqrt(1 - with_stature * with_stature) * own;
  b.weight_kg = group.weight_kg * std::exp(std::sqrt(log_variance) * z - log_variance / 2);
  const double square_metres = b.stature_mm * b.stature_mm * 1e-6;
  b.weight_kg = std::clamp(b.weight_kg, 16.5 * square_metres, 45 * square_metres);
  return b;
}

// Girth by tape over the ellipse of the calliper's breadth and depth, means of ANSUR II; a mesh's own over its own.
constexpr double kWaistTapeOverEllipse = 1.057, kHipTapeOverEllipse = 1.093, kMeshOverEllipse = 1.01;

Warp draw_warp(const BodyModel& model, bool woman, const Build& build, Rng& rng, std::span<const Vec3f> rest,
               double tape_share, double girth_sd) {
  std::array<double, kDimensionCount> z{};
  for (double& value : z) value = limited_normal(rng, 2.6);
  Dimensions wanted = likely_dimensions(woman, build.stature_mm, build.weight_kg, build.age_years, z);
  if (tape_share != 1 || girth_sd > 0) {
    const auto scale = [&](Dimension girth, double excess) {
      wanted[girth] *=
          (1 - (1 - tape_share) * (1 - kMeshOverEllipse / excess)) * (1 + girth_sd * limited_normal(rng, 2.5));
    };
    scale(Dimension::waist_girth, kWaistTapeOverEllipse);
    scale(Dimension::buttock_girth, kHipTapeOverEllipse);
    scale(Dimension::chest_girth, kMeshOverEllipse);
  }
  return warp_to(model, rest, wanted, draw_variety(rng));
}

Drawn draw_person(const BodyModel& model, Family family, std::uint64_t seed, std::uint64_t number) {
  Drawn drawn;
  drawn.seed = seed_of_person(family, seed, number);
  drawn.woman = is_woman(number);
  const Build build = draw_build(family, drawn.woman, drawn.seed);
  const double stature_mm = std::round(build.stature_mm * 256) / 256,
               weight_kg = std::round(build.weight_kg * 4096) / 4096;
  // Stature and weight stay as drawn (else there would be too few heavy people); the rest is redrawn until they can
  // be met. After the last attempt the nearest body stands in: its truth is measured like every other's.
  for (int attempt = 0; attempt < kAttemptCount; ++attempt) {
    drawn.params = draw_params(model, family, drawn, build, attempt);
    put_on_grid(drawn.params);
    if (solve_stature_and_weight(model, drawn.params, stature_mm, weight_kg)) break;
  }
  if (family == Family::training) give_proportions(model, build, drawn);
  return drawn;
}

Result<Params> params_of_person(const BodyModel& model, std::uint32_t version, std::uint64_t seed,
                                std::uint64_t number) {
  if (auto ok = check_version(version); !ok) return ok.error();
  return draw_person(model, Family::training, seed, number).params;
}

Result<float> age_of_person(std::uint32_t version, std::uint64_t seed, std::uint64_t number) {
  if (auto ok = check_version(version); !ok) return ok.error();
  const std::uint64_t own = seed_of_person(Family::training, seed, number);
  return gridded(static_cast<float>(draw_build(Family::training, is_woman(number), own).age_years));
}

}  // namespace im2fit::body
