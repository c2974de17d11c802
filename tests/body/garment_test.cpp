// SPDX-License-Identifier: Apache-2.0
// Garments as data and as meshes: their dimensions in each size, and errors that name faults of a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/file.h"
#include "garment/drape/garment_mesh.h"
#include "person/builtin_tape.h"
#include "person/garment_file.h"
#include "person/garment_fit.h"
#include "person/size_chart.h"

namespace im2fit {
namespace {

using body::CutBody;
using body::GarmentMesh;
using body::GarmentPattern;

const GarmentPattern& garment(const std::string& id) {
  const GarmentPattern* found = builtin_wardrobe().garment(id);
  EXPECT_NE(found, nullptr) << id;
  return *found;
}

CutBody body_of(const SizeRow& row, bool woman) {
  return body::cut_body(builtin_wardrobe().regression, woman, size_chest_mm(row));
}

TEST(Wardrobe, HasTheSixAndTheirFabrics) {
  const Wardrobe& wardrobe = builtin_wardrobe();
  std::set<std::string> ids;
  for (const GarmentPattern& g : wardrobe.garments) {
    ids.insert(g.id);
    EXPECT_NE(wardrobe.fabric(g.fabric), nullptr) << g.id;
    for (const std::string& name : g.names) EXPECT_FALSE(name.empty()) << g.id;
    for (const body::FitRegion& region : g.regions)
      EXPECT_GE(body::definition_index(builtin_tape(), region.measure), 0) << g.id << " " << region.measure;
  }
  EXPECT_EQ(ids, (std::set<std::string>{"t_shirt", "long_sleeved_shirt", "trousers", "shorts", "skirt", "dress"}));
  EXPECT_EQ(wardrobe.fabrics.size(), 3U);
}

TEST(Wardrobe, IsWhatTheFilesSay) {
  const std::string folder = IM2FIT_DATA_FOLDER;
  const auto of_files = read_shipped_wardrobe(folder);
  ASSERT_TRUE(of_files) << of_files.error().message;
  const std::string text = wardrobe_table(*of_files);
  EXPECT_TRUE(wardrobe_table(builtin_wardrobe()) == text)
      << "run im2fit-lab make wardrobe-table data > person/builtin_wardrobe.inc";
  const auto kept = read_file(folder + "/../person/builtin_wardrobe.inc");
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_TRUE(std::string(reinterpret_cast<const char*>(kept->data()), kept->size()) == text)
      << "person/builtin_wardrobe.inc was changed by hand";
  // What the table leaves out of a pattern would be missing from both.
  const CutBody body = body::cut_body(of_files->regression, true, 920);
  for (const GarmentPattern& pattern : of_files->garments) {
    const GarmentMesh filed = sew(pattern, body), built_in = sew(garment(pattern.id), body);
    ASSERT_EQ(filed.vertex_count(), built_in.vertex_count()) << pattern.id;
    EXPECT_EQ(filed.longer, built_in.longer) << pattern.id;
    EXPECT_EQ(filed.border, built_in.border) << pattern.id;
    for (std::size_t v = 0; v < filed.vertex_count(); ++v)
      ASSERT_TRUE(filed.flat[v].x == built_in.flat[v].x && filed.flat[v].y == built_in.flat[v].y) << pattern.id;
  }
}

// The chart's step, at the girth the chart is about.
TEST(Wardrobe, ASizeIsTheChartsStepWiderThanTheOneBefore) {
  for (const bool woman : {false, true}) {
    const SizeChart& chart = woman ? builtin_size_system().women : builtin_size_system().men;
    for (const char* id : {"t_shirt", "long_sleeved_shirt", "dress"})
      for (std::size_t i = 1; i < chart.rows.size(); ++i) {
        const float small = finished_girths(garment(id), body_of(chart.rows[i - 1], woman))[0];
        const float large = finished_girths(garment(id), body_of(chart.rows[i], woman))[0];
        EXPECT_NEAR(large - small, size_chest_mm(chart.rows[i]) - size_chest_mm(chart.rows[i - 1]), 0.5F)
            << id << " " << chart.rows[i].size;
      }
  }
}

float distance(body::Flat a, body::Flat b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

struct MeshFacts {
  int border_edges = 0, crowded_edges = 0, inverted = 0;
  float longest = 0, over_12_share = 0;
  int components_of_rims = 0;
};

MeshFacts facts_of(const GarmentMesh& mesh) {
  MeshFacts facts;
  std::map<std::pair<int, int>, int> count;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  std::map<int, std::vector<int>> rim;
  int over = 0;
  for (const auto& [edge, uses] : count) {
    const float length =
        distance(mesh.flat[static_cast<std::size_t>(edge.first)], mesh.flat[static_cast<std::size_t>(edge.second)]);
    facts.longest = std::max(facts.longest, length);
    over += length > 12.05F ? 1 : 0;
    facts.crowded_edges += uses > 2 ? 1 : 0;
    if (uses != 1) continue;
    ++facts.border_edges;
    rim[edge.first].push_back(edge.second);
    rim[edge.second].push_back(edge.first);
  }
  facts.over_12_share = static_cast<float>(over) / static_cast<float>(count.size());
  std::set<int> seen;
  for (const auto& [start, unused] : rim) {
    if (!seen.insert(start).second) continue;
    ++facts.components_of_rims;
    std::vector<int> open = {start};
    while (!open.empty()) {
      const int v = open.back();
      open.pop_back();
      for (const int n : rim[v])
        if (seen.insert(n).second) open.push_back(n);
    }
  }
  return facts;
}

// A shop turns legs up and does not lengthen them; nothing else changes.
TEST(Wardrobe, LegsAreTurnedUpForAShorterWearer) {
  const Wardrobe& wardrobe = builtin_wardrobe();
  const CutBody cut = cut_body(wardrobe.regression, true, 860);
  const auto leg = static_cast<std::size_t>(body::CutMeasure::inside_leg);
  EXPECT_EQ(body::turned_up(cut, cut[leg] + 50), cut);
  CutBody shorter = cut;
  shorter[leg] = cut[leg] - 50;
  EXPECT_EQ(body::turned_up(cut, cut[leg] - 50), shorter);
  const auto length = [&](const CutBody& person) {
    float low = 0;
    for (const body::Flat& f : sew(*wardrobe.garment("trousers"), person).flat) low = std::min(low, f.y);
    return -low;
  };
  EXPECT_NEAR(length(cut) - length(shorter), 50 * 0.95F, 1);
}

TEST(GarmentMesh, IsSewnOfEveryGarmentInEverySize) {
  const std::map<std::string, int> holes = {
      {"t_shirt", 4}, {"long_sleeved_shirt", 4}, {"dress", 4}, {"trousers", 3}, {"shorts", 3}, {"skirt", 2}};
  for (const bool woman : {false, true}) {
    const SizeChart& chart = woman ? builtin_size_system().women : builtin_size_system().men;
    for (const auto& [id, rims] : holes)
      for (const std::size_t row : {std::size_t{0}, std::size_t{2}, chart.rows.size() - 1}) {
        const GarmentMesh mesh = sew(garment(id), body_of(chart.rows[row], woman));
        const MeshFacts facts = facts_of(mesh);
        const std::string what = id + " " + chart.rows[row].size + (woman ? " women" : " men");
        EXPECT_EQ(facts.components_of_rims, rims) << what;  // neck, cuffs, hem: no tear beside them
        // Where a seam bends sharply, front and back may join its vertices by the same chord.
        EXPECT_LE(facts.crowded_edges, 12) << what;
        EXPECT_LT(facts.longest, 21.6F) << what;  // where lattice and outline meet
        EXPECT_LT(facts.over_12_share, 0.15F) << what;
        std::vector<int> uses(mesh.vertex_count(), 0);
        for (const auto& t : mesh.triangles)
          for (const auto v : t) ++uses[static_cast<std::size_t>(v)];
        EXPECT_EQ(std::count(uses.begin(), uses.end(), 0), 0) << what << ": loose vertices end as not-a-number";
      }
  }
}

TEST(GarmentMesh, HasTheVerticesAShirtNeeds) {
  const SizeChart& men = builtin_size_system().men;
  EXPECT_GE(sew(garment("t_shirt"), body_of(men.rows[2], false)).vertex_count(), 6000U);
}

// ---- Files

std::string shirt_with(const std::string& from, const std::string& to) {
  std::string text =
      "schema: im2fit.garment/1\n"
      "id: tube\n"
      "name: {en: \"Tube\"}\n"
      "hang: waist\n"
      "fabric: jersey\n"
      "lengths:\n"
      "  wide: {hip: 0.25, mm: 10}\n"
      "points:\n"
      "  low: {x: 0, y: -300}\n"
      "  low_side: {x: wide, y: low.y}\n"
      "  high_side: {x: wide, y: 50}\n"
      "  high: {x: 0, y: 50, back_y: 60}\n"
      "start: low\n"
      "outline:\n"
      "- {to: low_side, is: hem}\n"
      "- {to: high_side, is: seam}\n"
      "- {to: high, is: opening}\n"
      "regions:\n"
      "- {id: hip, measure: hip_girth, girth: {wide: 4}, tight_mm: 0, good_mm: [20, 60]}\n";
  if (const std::size_t at = text.find(from); !from.empty() && at != std::string::npos)
    text.replace(at, from.size(), to);
  return text;
}

TEST(GarmentFile, IsReadAndCut) {
  const auto tube = parse_garment(shirt_with("", ""), "tube.yaml");
  ASSERT_TRUE(tube) << tube.error().message;
  CutBody body{};
  body[static_cast<std::size_t>(body::CutMeasure::hip)] = 1000;
  EXPECT_FLOAT_EQ(finished_girths(*tube, body)[0], 1040);
  const GarmentMesh mesh = sew(*tube, body);
  float highest_front = 0, highest_back = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.layer[v] == body::kFrontLayer) highest_front = std::max(highest_front, mesh.flat[v].y);
    if (mesh.layer[v] == body::kBackLayer) highest_back = std::max(highest_back, mesh.flat[v].y);
  }
  EXPECT_FLOAT_EQ(highest_front, 50);
  EXPECT_FLOAT_EQ(highest_back, 60);
}

// A file of 1.5 kB may not keep a page's fitting room busy for minutes.
TEST(GarmentFile, WhatCannotBeSewnOrTakesTooLongIsRefused) {
  CutBody body{};
  body[static_cast<std::size_t>(body::CutMeasure::hip)] = 1000;
  const auto checked = [&](const std::string& from, const std::string& to) {
    const auto pattern = parse_garment(shirt_with(from, to), "tube.yaml");
    EXPECT_TRUE(pattern) << to << ": " << (pattern ? "" : pattern.error().message);
    const auto status = pattern ? check_cut(*pattern, body) : Status(Ok{});
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(checked("", ""), "");
  struct Fault {
    const char *from, *to, *message;
  };
  const Fault faults[] = {
      // Every number within its range, and 26 m2: it took minutes.
      {"wide: {hip: 0.25, mm: 10}\npoints:\n  low: {x: 0, y: -300}",
       "wide: {hip: 2.5}\npoints:\n  low: {x: 0, y: -2500}",
       "garment tube: it has 26 m2 of cloth, expected at most 8"},
      {"hip: 0.25", "hip: 10", "garment tube: point low_side lies more than 3000 mm from the middle"},
      // A bow tie: the sides change places.
      {"high_side: {x: wide, y: 50}", "high_side: {x: wide, y: -700}", "garment tube: the outline of the front"},
      {"y: 50, back_y: 60}", "y: 50, back_y: -900}", "garment tube: the outline of the back"},
      {"x: wide, y: low.y", "x: {wide: -1}, y: low.y", "garment tube: the outline of the front"},
  };
  for (const Fault& fault : faults) EXPECT_THAT(checked(fault.from, fault.to), testing::StartsWith(fault.message));
}

TEST(GarmentFile, EveryShippedGarmentCanBeSewnInEverySize) {
  for (const GarmentPattern& pattern : builtin_wardrobe().garments)
    for (const bool woman : {false, true})
      for (const SizeRow& row : (woman ? builtin_size_system().women : builtin_size_system().men).rows) {
        const auto status = check_cut(pattern, body_of(row, woman));
        EXPECT_TRUE(status) << status.error().message << " " << row.size;
      }
}

TEST(GarmentMesh, AGussetLetsInClothAboutItsPointAlone) {
  const auto plain = parse_garment(shirt_with("", ""), "tube.yaml");
  const auto let_in = parse_garment(
      shirt_with("regions:", "gusset: {at: high_side, more: 0.5, reach_mm: 80}\nregions:"), "tube.yaml");
  ASSERT_TRUE(plain && let_in) << let_in.error().message;
  CutBody body{};
  body[static_cast<std::size_t>(body::CutMeasure::hip)] = 1000;
  const GarmentMesh a = sew(*plain, body), b = sew(*let_in, body);
  ASSERT_EQ(a.triangles, b.triangles);
  float most = 1;
  for (const auto& t : b.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto from = static_cast<std::size_t>(t[k]), to = static_cast<std::size_t>(t[(k + 1) % 3]);
      const float longer = b.length_mm(from, to) / a.length_mm(from, to);
      const auto far = [&](std::size_t v) { return std::hypot(b.flat[v].x - 260, b.flat[v].y - 50) > 80; };
      EXPECT_GE(longer, 1);
      if (far(from) && far(to)) {
        EXPECT_FLOAT_EQ(longer, 1);
      }
      most = std::max(most, longer);
    }
  // 1.5 at the point itself, less at an edge's other end: (1 - 12 / 80)^2 of it.
  EXPECT_GT(most, 1.4F);
  EXPECT_LT(most, 1.5F);
}

TEST(GarmentFile, FaultsNameLineFieldAndWhatIsExpected) {
  struct Fault {
    const char *from, *to, *message;
  };
  const Fault faults[] = {
      {"im2fit.garment/1", "im2fit.garment/7", "tube.yaml line 1: schema is \"im2fit.garment/7\""},
      {"hang: waist", "hang: nose", "tube.yaml line 4: hang is \"nose\", expected shoulders or waist"},
      {"hip: 0.25", "nose: 0.25", "tube.yaml line 7: lengths.wide names \"nose\""},
      {"hip: 0.25", "low.y: 0.25", "tube.yaml line 7: lengths.wide names \"low.y\""},
      {"y: low.y", "y: lower.y", "tube.yaml line 10: points.low_side.y names \"lower.y\""},
      {"is: seam", "is: glue", "tube.yaml line 16: outline.is is \"glue\", expected seam, hem, opening or centre"},
      {"to: high,", "to: sky,", "tube.yaml line 17: outline.to is \"sky\", expected a point of `points`"},
      {"{to: high, is: opening}", "{to: low, is: opening}", "outline ends where it starts"},
      {"regions:", "gusset: {at: sky, more: 0.5, reach_mm: 80}\nregions:",
       "tube.yaml line 18: gusset.at is \"sky\", expected a point of `points`"},
      {"regions:", "gusset: {at: high, more: 2, reach_mm: 80}\nregions:", "tube.yaml line 18: gusset.more"},
      {"good_mm: [20, 60]", "good_mm: [60, 20]",
       "tube.yaml line 19: regions.hip.good_mm expected tight_mm <= from < to"},
      {"fabric: jersey\n", "fabric: jersey\ncolor: red\n", "tube.yaml line 6: file.color is not known"},
      {"- {to: low_side", "- {to low_side", "tube.yaml line"},
  };
  for (const Fault& fault : faults) {
    const auto read = parse_garment(shirt_with(fault.from, fault.to), "tube.yaml");
    ASSERT_FALSE(read) << fault.to;
    EXPECT_NE(read.error().message.find(fault.message), std::string::npos) << read.error().message;
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << read.error().message;
  }
}

// ---- Advice

GarmentFit fit_of(const std::string& id, const std::vector<BodyGirth>& girths, bool woman = false) {
  const SizeChart& chart = woman ? builtin_size_system().women : builtin_size_system().men;
  return fit_garment(garment(id), builtin_wardrobe().regression, chart, woman, girths);
}

// A body whose girths are those a size is cut for.
std::vector<BodyGirth> girths_of_size(const std::string& id, const SizeRow& row, float sd_mm) {
  std::vector<BodyGirth> girths;
  const CutBody body = body_of(row, false);
  const std::map<std::string, body::CutMeasure> measures = {
      {"chest_girth", body::CutMeasure::chest}, {"waist_girth", body::CutMeasure::waist},
      {"hip_girth", body::CutMeasure::hip},     {"upper_arm_girth", body::CutMeasure::upper_arm},
      {"wrist_girth", body::CutMeasure::wrist}, {"high_hip_girth", body::CutMeasure::high_hip},
      {"thigh_girth", body::CutMeasure::thigh}, {"calf_girth", body::CutMeasure::calf}};
  for (const body::FitRegion& region : garment(id).regions)
    girths.push_back({body[static_cast<std::size_t>(measures.at(region.measure))], sd_mm});
  return girths;
}

TEST(GarmentFit, ABodyOfASizeIsToldThatSize) {
  for (const GarmentPattern& pattern : builtin_wardrobe().garments)
    for (const SizeRow& row : builtin_size_system().men.rows) {
      const GarmentFit fit = fit_of(pattern.id, girths_of_size(pattern.id, row, 5));
      EXPECT_EQ(fit.sizes[fit.best].size, row.size) << pattern.id;
      EXPECT_FALSE(fit.none_fits) << pattern.id << " " << row.size;
      for (const RegionFit& region : fit.sizes[fit.best].regions) {
        EXPECT_EQ(region.verdict, FitVerdict::good) << pattern.id << " " << row.size << " ease " << region.ease_mm;
        EXPECT_NEAR(region.high_mm - region.low_mm, 2 * 1.96F * 5, 0.01F);
      }
    }
}

TEST(GarmentFit, SaysWhichOtherSizeAndWhyNot) {
  const SizeRow& m = builtin_size_system().men.rows[2];
  auto girths = girths_of_size("t_shirt", m, 5);
  girths[0].value_mm += 35;  // nearly L
  GarmentFit fit = fit_of("t_shirt", girths);
  EXPECT_EQ(fit.sizes[fit.best].size == "M" || fit.sizes[fit.best].size == "L", true);
  EXPECT_EQ(fit.sizes[fit.other].size == "M" || fit.sizes[fit.other].size == "L", true);
  EXPECT_NE(fit.best, fit.other);
  girths[0].value_mm = 1700;  // beyond the chart
  fit = fit_of("t_shirt", girths);
  EXPECT_EQ(fit.sizes[fit.best].size, "3XL");
  EXPECT_TRUE(fit.none_fits);
  EXPECT_EQ(fit.sizes[fit.best].regions[0].verdict, FitVerdict::tight);
  EXPECT_NE(advice_words(fit).find("no size fits"), std::string::npos) << advice_words(fit);
}

}  // namespace
}  // namespace im2fit
