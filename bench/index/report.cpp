// SPDX-License-Identifier: Apache-2.0
#include "bench/index/report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "report/svg_plot.h"

namespace im2fit::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSmall = 50'000, kLarge = 5'000'000;

std::string number(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string duration(double us) {
  if (us < 99.95) return number(us, us < 9.95 ? 1 : 0) + " µs";
  if (us < 999.5) return number(us, 0) + " µs";
  const double ms = us / 1000;
  return number(ms, ms < 9.95 ? 2 : ms < 99.5 ? 1 : 0) + " ms";
}

std::string thousands(std::size_t n) {
  std::string text = std::to_string(n);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
    text.insert(static_cast<std::size_t>(at), ",");
  return text;
}

template <class Format>
std::string or_dash(const std::optional<double>& value, Format format) {
  return value ? format(*value) : "–";
}

const Row* find(const Measured& all, const std::string& reference, std::size_t models) {
  for (const Row& row : all.rows)
    if (row.reference == reference && row.models == models) return &row;
  return nullptr;
}

std::vector<std::size_t> sizes_of(const Measured& all) {
  std::vector<std::size_t> sizes;
  for (const Row& row : all.rows)
    if (sizes.empty() || sizes.back() != row.models) sizes.push_back(row.models);
  return sizes;
}

Target at_most(const std::string& what, double target, const std::string& unit, const std::optional<double>& measured,
               int digits) {
  if (!measured) return {what, "≤ " + number(target, digits) + unit, "not measured", {}};
  return {what, "≤ " + number(target, digits) + unit, number(*measured, digits) + unit, *measured <= target};
}

// Least gain over the judged measurements.
double least_gain(const Errors& theirs, const Errors& ours) {
  double least = theirs[0] / ours[0];
  for (std::size_t k = 1; k < ours.size(); ++k) least = std::min(least, theirs[k] / ours[k]);
  return least;
}

// Every measurement at least as well as ours.
bool as_accurate(const Row& theirs, const Row& ours) {
  for (std::size_t k = 0; k < ours.error.size(); ++k)
    if (theirs.error[k] > ours.error[k]) return false;
  return true;
}

void compare_with_references(const Measured& all, std::size_t models, std::vector<Target>& targets) {
  const Row* ours = find(all, "im2fit", models);
  if (ours == nullptr) return;
  const std::string at = " at " + thousands(models);
  std::string slower_than_us = "no reference is as accurate";
  bool met = true;
  const Row* fastest = nullptr;
  for (const Row& row : all.rows) {
    if (row.models != models || !row.p50_us || row.reference.starts_with("im2fit")) continue;
    if (fastest == nullptr || *row.p50_us < *fastest->p50_us) fastest = &row;
    if (!as_accurate(row, *ours)) continue;
    slower_than_us = row.reference + " is, and takes " + duration(*row.p50_us);
    met = met && *row.p50_us > *ours->p50_us && *row.p99_us > *ours->p99_us;
  }
  if (fastest == nullptr) return;
  targets.push_back({"faster than every reference of equal or less error" + at, "all", slower_than_us, met});
  targets.push_back({"the fastest reference of any error" + at + ", over ours, p50", "–",
                     number(*fastest->p50_us / *ours->p50_us, 1) + "x (" + fastest->reference + ")", std::nullopt});
}

Json errors_json(const Errors& errors) {
  Json out;
  for (std::size_t k = 0; k < errors.size(); ++k)
    out[std::string(kMeasurementTable[measurement_index(kJudged[k])].id)] = errors[k];
  return out;
}

void put(Json& json, const char* name, const std::optional<double>& value) {
  if (value) json[name] = *value;
}

Json row_json(const Row& row) {
  Json out = {{"peer", row.reference},
              {"note", row.note},
              {"models", row.models},
              {"densified", row.densified},
              {"asked", row.queries}};
  put(out, "build_s", row.build_s);
  put(out, "bytes_a_model", row.bytes_a_model);
  put(out, "p50_us", row.p50_us);
  put(out, "p99_us", row.p99_us);
  put(out, "recall_own_space", row.recall_own);
  put(out, "recall_raw_space", row.recall_raw);
  if (row.kind != "search") out["error_mm"] = errors_json(row.error);
  if (row.error_of_nearest) out["error_of_nearest_mm"] = errors_json(*row.error_of_nearest);
  return out;
}

std::string error_cells(const Errors& errors) {
  std::string text;
  for (const double e : errors) text += " " + number(e, 1) + " |";
  return text;
}

std::string search_table_of(const Measured& all) {
  std::string text =
      "\n## The search alone\nThe same neighbours in our projected space, found by others over the same places. "
      "Exact "
      "ones give the same answer as ours.\n\n| models | who (what) | build s | B/model | p50 | p99 | queries | "
      "neighbours found |\n|---:|---|---:|---:|---:|---:|---:|---:|\n";
  for (const Row& row : all.searches)
    text += "| " + thousands(row.models) + " | " + row.reference + " (" + row.note + ") | " +
            or_dash(row.build_s, [](double s) { return number(s, 1); }) + " | " +
            or_dash(row.bytes_a_model, [](double b) { return number(b, 1); }) + " | " +
            or_dash(row.p50_us, duration) + " | " + or_dash(row.p99_us, duration) + " | " +
            std::to_string(row.queries) + " | " + or_dash(row.recall_own, [](double v) { return number(v, 4); }) +
            " |\n";
  return text;
}

// The fastest that finds what ours finds: a reference of equal error, were our regression put behind it.
void compare_searches(const Measured& all, std::size_t models, std::vector<Target>& targets) {
  const Row* ours = nullptr;
  const Row* best = nullptr;
  for (const Row& row : all.searches) {
    if (row.models != models) continue;
    if (row.reference == "im2fit, int8") ours = &row;
    if (!row.reference.starts_with("im2fit") && (best == nullptr || *row.p50_us < *best->p50_us)) best = &row;
  }
  if (ours == nullptr || best == nullptr) return;
  const double gain = *best->p50_us / *ours->p50_us;
  targets.push_back(
      {"the search alone at " + thousands(models) + ": fastest reference over ours, p50", "> 1x",
       number(gain, 2) + "x (" + best->reference + ", finds " + number(100 * best->recall_own.value_or(0), 1) + " %)",
       gain > 1});
}

std::string size_line(const Measured& all, std::size_t models) {
  for (const Row& row : all.rows) {
    if (row.models != models) continue;
    if (row.densified == 0) return thousands(models) + " models, all rendered";
    return thousands(models) + " models: " + thousands(models - row.densified) + " rendered, " +
           thousands(row.densified) + " **densified** (mixed from them)";
  }
  return "";
}

std::string table_of(const Measured& all, std::size_t models) {
  std::string text =
      "\n**" + size_line(all, models) + "**\n\n" +
      "| method | build s | B/model | p50 | p99 | queries | recall own / raw | stature | chest | waist | "
      "hip mm |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  const auto share = [](double v) { return number(v, 3); };
  for (const Row& row : all.rows) {
    if (row.models != models) continue;
    text += "| " + row.reference + (row.note.empty() ? "" : " (" + row.note + ")") + " | " +
            or_dash(row.build_s, [](double s) { return number(s, 1); }) + " | " +
            or_dash(row.bytes_a_model, [](double b) { return number(b, b < 100 ? 1 : 0); }) + " | " +
            or_dash(row.p50_us, duration) + " | " + or_dash(row.p99_us, duration) + " | " +
            std::to_string(row.queries) + " | " + or_dash(row.recall_own, share) + " / " +
            or_dash(row.recall_raw, share) + " |" + error_cells(row.error) + "\n";
    if (row.error_of_nearest && row.reference == "im2fit")
      text +=
          "| – its nearest model, without the regression | | | | | | |" + error_cells(*row.error_of_nearest) + "\n";
  }
  return text;
}

using lab::Lettering;
using lab::Panel;
using lab::Svg;
using lab::SvgPoint;

// Colours that stay apart for most eyes (Okabe and Ito), and then some.
constexpr std::array<const char*, 10> kColours = {"#d55e00", "#e69f00", "#a0522d", "#000000", "#7f7f7f",
                                                  "#0072b2", "#56b4e9", "#009e73", "#cc79a7", "#6a3d9a"};

const lab::Axis kModels = {
    800,  6.5e6, "models in the index",
    true, 5,     {{1e3, "1,000"}, {1e4, "10,000"}, {5e4, "50,000"}, {5e5, "500,000"}, {5e6, "5,000,000"}}};
const lab::Axis kTime = {
    1e-3,
    1e3,
    "",
    true,
    6,
    {{1e-3, "1 µs"}, {1e-2, "10 µs"}, {1e-1, "100 µs"}, {1, "1 ms"}, {10, "10 ms"}, {100, "100 ms"}, {1e3, "1 s"}}};

std::vector<SvgPoint> points_of(const Panel& panel, const std::vector<const Row*>& rows,
                                std::optional<double> Row::*time) {
  std::vector<SvgPoint> points;
  for (const Row* row : rows)
    if (row->*time) points.push_back(panel.at(static_cast<double>(row->models), *(row->*time) / 1e3));
  return points;
}

// The targets: p50 at 50,000 and p99 at 5,000,000.
void draw_bars(Svg& svg, const Panel& panel) {
  for (const auto& [models, ms, words] :
       {std::tuple{5e4, 0.02, "p50 target, 20 µs"}, std::tuple{5e6, 1.0, "p99 target, 1 ms"}}) {
    const auto [x, y] = panel.at(models, ms);
    svg.line({x - 18, y}, {x + 18, y}, {lab::kRed, 3});
    svg.text({x + 18, y + 16}, words, {Lettering::Anchor::end, 12, lab::kRed});
  }
}

}  // namespace

std::vector<Target> targets_of(const Measured& all) {
  std::vector<Target> targets;
  const Row* small = find(all, "im2fit", kSmall);
  const Row* large = find(all, "im2fit", kLarge);
  const auto field = [](const Row* row, std::optional<double> Row::*f) { return row ? row->*f : std::nullopt; };
  targets.push_back(at_most("query at 50,000, p50", 20, " µs", field(small, &Row::p50_us), 1));
  targets.push_back(at_most("query at 5,000,000, p99", 1000, " µs", field(large, &Row::p99_us), 0));
  std::optional<double> growth50, growth99;
  if (small && large) {
    growth50 = *large->p50_us / *small->p50_us;
    growth99 = *large->p99_us / *small->p99_us;
  }
  targets.push_back(at_most("growth of p50 from 50,000 to 5,000,000", 10, "x", growth50, 1));
  targets.push_back(at_most("growth of p99 from 50,000 to 5,000,000", 10, "x", growth99, 1));
  targets.push_back(at_most("bytes a model at 5,000,000", 24, "", field(large, &Row::bytes_a_model), 2));
  for (const std::size_t models : sizes_of(all)) {
    const Row* ours = find(all, "im2fit", models);
    const Row* raw = find(all, "brute force, 501 float", models);
    if (ours == nullptr) continue;
    const std::string at = " at " + thousands(models);
    // Exact is 1.000x: the answers are the same to the bit.
    const double same = ours->recall_own.value_or(0);
    targets.push_back({"answers the same as by exhaustive search" + at, "error ≤ 1.02x",
                       number(100 * same, 2) + " % to the bit", same == 1.0});
    if (raw == nullptr) continue;
    const double gain = least_gain(raw->error, ours->error);
    targets.push_back(
        {"error of raw nearest over ours" + at + ", least of four", "≥ 2.5x", number(gain, 2) + "x", gain >= 2.5});
    compare_with_references(all, models, targets);
    compare_searches(all, models, targets);
  }
  return targets;
}

std::string json_of(const Measured& all) {
  Json out = {{"origin", all.origin},
              {"processor", all.processor},
              {"rendered_models", all.models_real},
              {"queries", all.queries},
              {"feature_values", all.feature_size},
              {"seconds", all.seconds},
              {"memory_peak_gb", all.memory_peak_gb}};
  for (const Row& row : all.rows) out["rows"].push_back(row_json(row));
  for (const Row& row : all.searches) out["searches"].push_back(row_json(row));
  for (const Target& target : targets_of(all)) {
    Json b = {{"what", target.what}, {"target", target.target}, {"measured", target.measured}};
    if (target.met) b["met"] = *target.met;
    out["targets"].push_back(b);
  }
  return out.dump(1) + "\n";
}

std::string markdown_of(const Measured& all, const std::string& plot_file) {
  std::string text =
      "<!-- SPDX-License-Identifier: Apache-2.0 -->\n<!-- Written by index_references. -->\n# The index beside "
      "reference implementations\n\n" +
      all.processor + ", processor time of one thread. " + all.origin + ": " + thousands(all.models_real) +
      " rendered models, " + thousands(all.queries) + " held-out people queried; features of " +
      thousands(all.feature_size) + " values, of which reference implementations take the paper's 501. Peak memory " +
      number(all.memory_peak_gb, 1) + " GB, " + number(all.seconds / 60, 1) +
      " minutes in all. What the words mean and how to rerun: [docs/notebook/"
      "index.md](../../docs/notebook/index.md#the-index-beside-its-reference-implementations).\n\n";
  text += "| what | target | measured | met |\n|---|---:|---:|---|\n";
  for (const Target& target : targets_of(all))
    text += "| " + target.what + " | " + target.target + " | " + target.measured + " | " +
            (target.met ? *target.met ? "yes" : "**no**" : "–") + " |\n";
  text += "\n![query time against models](" + plot_file + ")\n";
  for (const std::size_t models : sizes_of(all)) text += table_of(all, models);
  if (!all.searches.empty()) text += search_table_of(all);
  return text;
}

std::string plot_of(const Measured& all) {
  std::vector<std::string> references;
  std::map<std::string, std::vector<const Row*>> rows;
  for (const Row& row : all.rows) {
    if (!row.p50_us) continue;
    if (rows[row.reference].empty()) references.push_back(row.reference);
    rows[row.reference].push_back(&row);
  }
  constexpr double kLeft = 76, kTop = 44, kWidth = 560, kHeight = 440;
  Svg svg(980, kTop + kHeight + 60, "Query time against models");
  svg.text({kLeft, kTop - 16}, "time of one query, one thread: p50 drawn through, p99 dashed");
  const Panel panel(svg, {kLeft, kTop, kWidth, kHeight}, kModels, kTime);
  draw_bars(svg, panel);
  std::vector<lab::LineEnd> ends;
  for (std::size_t p = 0; p < references.size(); ++p) {
    const char* colour = kColours[p % kColours.size()];
    const auto& of = rows[references[p]];
    const auto p50 = points_of(panel, of, &Row::p50_us);
    svg.polyline(p50, {colour, references[p] == "im2fit" ? 3.5 : 1.8});
    svg.polyline(points_of(panel, of, &Row::p99_us), {colour, 1.2, "5 4"});
    for (const SvgPoint& point : p50) svg.disc(point, 3, colour);
    ends.push_back({p50.back(), references[p], colour});
  }
  name_line_ends(svg, ends, kLeft + kWidth + 24, kTop, kTop + kHeight);
  return svg.file();
}

}  // namespace im2fit::bench
