// SPDX-License-Identifier: Apache-2.0
#include "person/size_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/rng.h"

namespace im2fit {
namespace {

constexpr double kNormal95 = 1.959963984540054;  // half width of the 95 % interval, in standard deviations
constexpr int kBodies = 1024;                    // a share is then right to 1.6 %
constexpr std::uint64_t kBodiesSeed = 59;

SizeSystem parse_builtin() {
  // The text is ours and a test parses it; a fault here would be a fault of the build.
  auto men = parse_size_chart(kBuiltinMenChart, "built-in men's chart");
  auto women = parse_size_chart(kBuiltinWomenChart, "built-in women's chart");
  return men && women ? SizeSystem{std::move(*men), std::move(*women)} : SizeSystem{};
}

void add(SizeAnswer& answer, const std::string& size, double probability) {
  for (SizeAnswer::Entry& entry : answer.entries) {
    if (entry.size != size) continue;
    entry.probability += probability;
    return;
  }
  answer.entries.push_back({size, probability});
}

// Where a chart leaves a gap between two sizes, or they overlap, each takes its half.
double upper_edge(const SizeChart& chart, std::size_t row, std::size_t measure) {
  const double high = static_cast<double>(chart.rows[row].range(measure).high_mm);
  if (row + 1 == chart.rows.size()) return high;
  return 0.5 * (high + static_cast<double>(chart.rows[row + 1].range(measure).low_mm));
}

struct Measured {
  std::size_t measure = 0;  // of the chart
  double mean_mm = 0, sd_mm = 0;
};

void add_by_one(SizeAnswer& answer, const SizeChart& chart, const Measured& body, double share) {
  const auto below = [&](double girth_mm) { return normal_cdf((girth_mm - body.mean_mm) / body.sd_mm); };
  double previous = below(static_cast<double>(chart.rows.front().range(body.measure).low_mm));
  add(answer, "<" + chart.rows.front().size, share * previous);
  for (std::size_t i = 0; i < chart.rows.size(); ++i) {
    const double next = below(upper_edge(chart, i, body.measure));
    add(answer, chart.rows[i].size, share * (next - previous));
    previous = next;
  }
  add(answer, ">" + chart.rows.back().size, share * (1 - previous));
}

// A body within the size's range fits; a size further away it is tight.
body::FitRegion region_of(const SizeRange& range, const std::string& id) {
  body::FitRegion region;
  region.id = region.measure = id;
  const float half = (range.high_mm - range.low_mm) / 2;
  region.good_low_mm = -half;
  region.good_high_mm = half;
  region.tight_mm = -3 * half;
  return region;
}

// [size][measure in `body`]
using Regions = std::vector<std::vector<body::FitRegion>>;
float middle_of(const SizeRange& range) {
  return (range.low_mm + range.high_mm) / 2;
}

// Where a body takes the smallest size and is below all its ranges, or the largest and is above one by a size, no
// size is its own.
std::string label_of(const SizeChart& chart, const Regions& regions, std::size_t size,
                     const std::vector<double>& eases_mm) {
  bool all_loose = true, tight = false;
  for (std::size_t m = 0; m < eases_mm.size(); ++m) {
    all_loose = all_loose && eases_mm[m] > regions[size][m].good_high_mm;
    tight = tight || eases_mm[m] < regions[size][m].tight_mm;
  }
  if (size == 0 && all_loose) return "<" + chart.rows.front().size;
  if (size + 1 == chart.rows.size() && tight) return ">" + chart.rows.back().size;
  return chart.rows[size].size;
}

Regions regions_of(const SizeChart& chart, const std::vector<Measured>& body) {
  Regions regions;
  for (const SizeRow& row : chart.rows) {
    regions.emplace_back();
    for (const Measured& one : body)
      regions.back().push_back(region_of(row.range(one.measure), chart.measures[one.measure]));
  }
  return regions;
}

void add_by_several(SizeAnswer& answer, const SizeChart& chart, const std::vector<Measured>& body, double share) {
  const Regions regions = regions_of(chart, body);
  add(answer, "<" + chart.rows.front().size, 0);
  for (const SizeRow& row : chart.rows) add(answer, row.size, 0);
  add(answer, ">" + chart.rows.back().size, 0);
  Rng rng(kBodiesSeed);
  std::vector<double> value(body.size()), ease(body.size()), best_ease(body.size());
  for (int i = 0; i < kBodies; ++i) {
    for (std::size_t m = 0; m < body.size(); ++m)
      value[m] = body[m].mean_mm + body[m].sd_mm * static_cast<double>(rng.fast_normal());
    std::size_t best = 0;
    double least = 0;
    for (std::size_t size = 0; size < chart.rows.size(); ++size) {
      double cost = 0;
      for (std::size_t m = 0; m < body.size(); ++m) {
        ease[m] = static_cast<double>(middle_of(chart.rows[size].range(body[m].measure))) - value[m];
        cost += fit_cost(regions[size][m], ease[m]);
      }
      if (size > 0 && cost >= least) continue;
      least = cost;
      best = size;
      best_ease = ease;
    }
    add(answer, label_of(chart, regions, best, best_ease), share / kBodies);
  }
}

GarmentFit reason_of(const SizeChart& chart, const std::vector<Measured>& body, const std::string& best) {
  const Regions regions = regions_of(chart, body);
  GarmentFit fit;
  fit.chart = chart.name;
  std::vector<BodyGirth> girths;
  girths.reserve(body.size());
  for (const Measured& one : body) {
    fit.region_ids.push_back(chart.measures[one.measure]);
    girths.push_back({static_cast<float>(one.mean_mm), static_cast<float>(one.sd_mm)});
  }
  SizeChoice choice(fit);
  std::size_t place = 0;
  for (std::size_t i = 0; i < chart.rows.size(); ++i) {
    std::vector<float> middles;
    middles.reserve(body.size());
    for (const Measured& one : body) middles.push_back(middle_of(chart.rows[i].range(one.measure)));
    if (chart.rows[i].size == best || ">" + chart.rows[i].size == best) place = i;
    choice.add({chart.rows[i].size, 0, 0, {}}, regions[i], middles, girths);
  }
  choice.choose_among_all(place);
  return fit;
}

// What the body has of the chart's measures; the others are left out.
std::vector<Measured> measured_of(const SizeChart& chart, const MeasureLookup& lookup, SizeAnswer& answer) {
  std::vector<Measured> body;
  for (std::size_t m = 0; m < chart.measures.size(); ++m) {
    const std::string& id = chart.measures[m];
    const auto found = lookup(id);
    if (!found) {
      if (std::find(answer.left_out.begin(), answer.left_out.end(), id) == answer.left_out.end())
        answer.left_out.push_back(id);
      continue;
    }
    const double width = static_cast<double>(found->high) - static_cast<double>(found->low);
    // An interval of no width still leaves the tape's own millimetre.
    body.push_back({m, static_cast<double>(found->value), std::max(width / (2 * kNormal95), 1.0)});
  }
  return body;
}

}  // namespace

Result<SizeSystem> make_size_system(std::vector<SizeChart> charts) {
  if (charts.size() == 1 && charts[0].sex == ChartSex::any) return SizeSystem{charts[0], charts[0]};
  if (charts.size() == 2 && charts[0].name == charts[1].name) {
    if (charts[0].sex == ChartSex::women && charts[1].sex == ChartSex::men) std::swap(charts[0], charts[1]);
    if (charts[0].sex == ChartSex::men && charts[1].sex == ChartSex::women)
      return SizeSystem{std::move(charts[0]), std::move(charts[1])};
  }
  return Error{ErrorCode::invalid_argument,
               "size charts: give one chart of sex any, or a men's and a women's chart of the same name"};
}

const SizeSystem& builtin_size_system() {
  static const SizeSystem system = parse_builtin();
  return system;
}

double normal_cdf(double x) {
  if (x < 0) return 1 - normal_cdf(-x);
  const double sum =
      1 + x * (0.0498673470 +
               x * (0.0211410061 + x * (0.0032776263 + x * (0.0000380036 + x * (0.0000488906 + x * 0.0000053830)))));
  const double square = sum * sum;
  const double fourth = square * square;
  const double eighth = fourth * fourth;
  return 1 - 0.5 / (eighth * eighth);
}

const SizeChart& SizeSystem::cut_by(bool woman) const {
  const SizeChart& own = woman ? women : men;
  if (own.has_chest()) return own;
  const SizeSystem& builtin = builtin_size_system();
  return woman ? builtin.women : builtin.men;
}

SizeAnswer size_answer(const SizeSystem& system, const MeasureLookup& lookup, float female) {
  const double share = std::clamp(static_cast<double>(female), 0.0, 1.0);
  SizeAnswer answer;
  answer.chart = system.men.name;
  const std::vector<Measured> bodies[] = {measured_of(system.men, lookup, answer),
                                          measured_of(system.women, lookup, answer)};
  // A chart that nothing was measured of leaves all to the other.
  const double shares[] = {bodies[1].empty() ? 1 : 1 - share, bodies[0].empty() ? 1 : share};
  for (std::size_t i = 0; i < 2; ++i) {
    const SizeChart& chart = i == 0 ? system.men : system.women;
    if (bodies[i].empty() || chart.rows.empty()) continue;
    if (bodies[i].size() == 1 && chart.measures.size() == 1)
      add_by_one(answer, chart, bodies[i].front(), shares[i]);
    else
      add_by_several(answer, chart, bodies[i], shares[i]);
  }
  double best = -1;
  for (const SizeAnswer::Entry& entry : answer.entries) {
    if (entry.probability <= best) continue;
    best = entry.probability;
    answer.best = entry.size;
  }
  // Of the likelier sex's chart; where that has no such size, of the other's.
  const auto has_best = [&](const SizeChart& chart) {
    return std::any_of(chart.rows.begin(), chart.rows.end(),
                       [&](const SizeRow& row) { return row.size == answer.best || ">" + row.size == answer.best; });
  };
  std::size_t likelier = share > 0.5 ? 1 : 0;
  if (!has_best(likelier == 1 ? system.women : system.men)) likelier = 1 - likelier;
  const SizeChart& chart = likelier == 1 ? system.women : system.men;
  if (has_best(chart) && chart.measures.size() > 1 && !bodies[likelier].empty() && !chart.rows.empty())
    answer.reason = reason_of(chart, bodies[likelier], answer.best);
  return answer;
}

std::string size_advice_words(const GarmentFit& reason) {
  const SizeFit &best = reason.sizes[reason.best], &other = reason.sizes[reason.other];
  std::string words = reason.none_fits ? best.size + " is the nearest, and no size fits" : best.size + " fits";
  if (reason.other == reason.best) return words;
  std::string place = reason.region_ids[reason.other_region];
  std::replace(place.begin(), place.end(), '_', ' ');
  const auto off = [&](const SizeFit& size) {
    const auto mm = std::lround(size.regions[reason.other_region].ease_mm);
    return std::to_string(std::labs(mm)) + " mm " + (mm < 0 ? "smaller" : "larger");
  };
  return words + "; then " + other.size + ": its " + place + " is made for a body " + off(other) + ", that of " +
         best.size + " for one " + off(best);
}

SizeAnswer size_probabilities(const SizeSystem& system, const index::IntervalEstimate& chest_mm, float female) {
  const auto lookup = [&](std::string_view id) {
    return id == "chest_girth" ? std::optional(chest_mm) : std::optional<index::IntervalEstimate>();
  };
  return size_answer(system, lookup, female);
}

}  // namespace im2fit
