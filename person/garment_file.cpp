// SPDX-License-Identifier: Apache-2.0
#include "person/garment_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "body/tape.h"
#include "core/file.h"
#include "formats/yaml_fields.h"
#include "person/source_literals.h"
#include "person/wardrobe_row.h"

namespace im2fit {
namespace {

using body::EdgeKind;
using body::GarmentPattern;
using body::LinearForm;
using yaml::expect_keys;
using yaml::id_of;
using yaml::needed;
using yaml::number_of;
using yaml::refuse;
using yaml::shown;
using yaml::text_of;

constexpr std::size_t kListMax = 64;  // lengths, points, edges, regions
constexpr float kPlaceMaxMm = 3000;
constexpr float kFactorMax = 10;
constexpr std::size_t kColumns = 118;  // of a line of the table
const char* const kGarmentKind = "a garment in YAML (docs/garments.md)";

template <class T>
void expect_room(const std::vector<T>& list, const YAML::Node& node, const std::string& field) {
  if (list.size() >= kListMax) refuse(node, field, "is one too many, expected at most " + std::to_string(kListMax));
}

class GarmentReader {
 public:
  GarmentPattern read(const YAML::Node& root) {
    expect_keys(root, "file",
                {"schema", "id", "name", "hang", "legs", "fabric", "colour", "lengths", "points", "start", "outline",
                 "gusset", "regions"});
    yaml::expect_schema(root, "im2fit.garment/1");
    g_.id = id_of(needed(root, "id", "id", "a word"), "id");
    names(root);
    const YAML::Node hang = needed(root, "hang", "hang", "shoulders or waist");
    const std::string word = text_of(hang, "hang");
    if (word != "shoulders" && word != "waist")
      refuse(hang, "hang", "is " + shown(hang) + ", expected shoulders or waist");
    g_.hang = word == "waist" ? body::Hang::waist : body::Hang::shoulders;
    if (const YAML::Node legs = root["legs"]; legs.IsDefined() && !YAML::convert<bool>::decode(legs, g_.legs))
      refuse(legs, "legs", "is " + shown(legs) + ", expected true or false");
    g_.fabric = id_of(needed(root, "fabric", "fabric", "the id of a fabric"), "fabric");
    colour(root);
    lengths(root);
    points(root);
    outline(root);
    gusset(root);
    regions(root);
    return std::move(g_);
  }

 private:
  void names(const YAML::Node& root) {
    const YAML::Node all = needed(root, "name", "name", "{en: ...}");
    expect_keys(all, "name", {body::kTapeLanguages.begin(), body::kTapeLanguages.end()});
    for (std::size_t i = 0; i < body::kTapeLanguages.size(); ++i) {
      const std::string language(body::kTapeLanguages[i]);
      if (all[language].IsDefined()) g_.names[i] = text_of(all[language], "name." + language);
    }
    if (g_.names[0].empty()) refuse(all, "name.en", "is missing, expected a text");
  }

  void colour(const YAML::Node& root) {
    const YAML::Node node = root["colour"];
    if (!node.IsDefined()) return;
    if (!node.IsSequence() || node.size() != 3) refuse(node, "colour", "expected [red, green, blue], 0 to 1 each");
    for (std::size_t i = 0; i < 3; ++i) g_.colour[i] = number_of(node[i], "colour", 0, 1);
  }

  void lengths(const YAML::Node& root) {
    const YAML::Node all = root["lengths"];
    if (!all.IsDefined()) return;
    if (!all.IsMap()) refuse(all, "lengths", "is " + shown(all) + ", expected a field a length");
    for (const auto& item : all) {
      const std::string id = id_of(item.first, "lengths");
      const std::string field = "lengths." + id;
      expect_room(g_.length_ids, item.first, field);
      if (measure(id) >= 0 || length(id) >= 0) refuse(item.first, field, "is a name already taken");
      LinearForm form = form_of(item.second, field);
      for (const LinearForm::Term& term : form.terms)
        if (term.of == LinearForm::Of::point_x || term.of == LinearForm::Of::point_y)
          refuse(item.second, field, "uses a point; expected measures and earlier lengths");
      g_.length_ids.push_back(id);
      g_.lengths.push_back(std::move(form));
    }
  }

  void points(const YAML::Node& root) {
    const YAML::Node all = needed(root, "points", "points", "a field a point");
    if (!all.IsMap()) refuse(all, "points", "is " + shown(all) + ", expected a field a point");
    for (const auto& item : all) {
      body::PatternPoint p;
      p.id = id_of(item.first, "points");
      const std::string field = "points." + p.id;
      expect_room(g_.points, item.first, field);
      if (point(p.id) >= 0) refuse(item.first, field, "appears twice");
      expect_keys(item.second, field, {"x", "y", "back_x", "back_y"});
      p.x = form_of(needed(item.second, "x", field + ".x", "a length"), field + ".x");
      p.y = form_of(needed(item.second, "y", field + ".y", "a length"), field + ".y");
      const YAML::Node bx = item.second["back_x"], by = item.second["back_y"];
      p.has_back = bx.IsDefined() || by.IsDefined();
      p.back_x = bx.IsDefined() ? form_of(bx, field + ".back_x") : p.x;
      p.back_y = by.IsDefined() ? form_of(by, field + ".back_y") : p.y;
      g_.points.push_back(std::move(p));
    }
  }

  void outline(const YAML::Node& root) {
    g_.start = point_of(needed(root, "start", "start", "a point"), "start");
    const YAML::Node all = needed(root, "outline", "outline", "a list of edges");
    if (!all.IsSequence() || all.size() < 2) refuse(all, "outline", "expected a list of at least two edges");
    for (const YAML::Node& node : all) {
      expect_room(g_.edges, node, "outline");
      expect_keys(node, "outline", {"to", "is", "via"});
      body::PatternEdge edge;
      edge.to = point_of(needed(node, "to", "outline.to", "a point"), "outline.to");
      const YAML::Node is = needed(node, "is", "outline.is", "seam, hem, opening or centre");
      const std::string word = text_of(is, "outline.is");
      constexpr std::pair<const char*, EdgeKind> kKinds[] = {{"seam", EdgeKind::seam},
                                                             {"hem", EdgeKind::hem},
                                                             {"opening", EdgeKind::opening},
                                                             {"centre", EdgeKind::centre}};
      const auto* found =
          std::find_if(std::begin(kKinds), std::end(kKinds), [&](const auto& k) { return word == k.first; });
      if (found == std::end(kKinds))
        refuse(is, "outline.is", "is " + shown(is) + ", expected seam, hem, opening or centre");
      edge.kind = found->second;
      if (const YAML::Node via = node["via"]; via.IsDefined()) {
        if (!via.IsSequence() || via.size() > 2) refuse(via, "outline.via", "expected a list of one or two points");
        for (const YAML::Node& one : via) edge.via.push_back(point_of(one, "outline.via"));
      }
      g_.edges.push_back(std::move(edge));
    }
    const bool closed = g_.edges.back().to == g_.start;
    if (g_.legs && !closed) refuse(all, "outline", "does not end where it starts: legs have a seam along the centre");
    if (!g_.legs && closed) refuse(all, "outline", "ends where it starts; expected both ends on the fold, at x = 0");
  }

  void gusset(const YAML::Node& root) {
    const YAML::Node node = root["gusset"];
    if (!node.IsDefined()) return;
    expect_keys(node, "gusset", {"at", "more", "reach_mm"});
    g_.gusset.at = point_of(needed(node, "at", "gusset.at", "a point"), "gusset.at");
    g_.gusset.more = number_of(needed(node, "more", "gusset.more", "a share"), "gusset.more", 0, 1);
    g_.gusset.reach_mm = number_of(needed(node, "reach_mm", "gusset.reach_mm", "mm"), "gusset.reach_mm", 1, 500);
  }

  void regions(const YAML::Node& root) {
    const YAML::Node all = needed(root, "regions", "regions", "a list");
    if (!all.IsSequence()) refuse(all, "regions", "is " + shown(all) + ", expected a list");
    for (const YAML::Node& node : all) {
      expect_room(g_.regions, node, "regions");
      expect_keys(node, "regions", {"id", "measure", "girth", "tight_mm", "good_mm"});
      body::FitRegion region;
      region.id = id_of(needed(node, "id", "regions.id", "a word"), "regions.id");
      const std::string field = "regions." + region.id;
      region.measure = id_of(needed(node, "measure", field + ".measure", "a measurement of the tape"), field);
      region.girth = form_of(needed(node, "girth", field + ".girth", "a length"), field + ".girth");
      region.tight_mm =
          number_of(needed(node, "tight_mm", field + ".tight_mm", "mm"), field + ".tight_mm", -500, 500);
      const YAML::Node good = needed(node, "good_mm", field + ".good_mm", "[from, to] in mm");
      if (!good.IsSequence() || good.size() != 2) refuse(good, field + ".good_mm", "expected [from, to] in mm");
      region.good_low_mm = number_of(good[0], field + ".good_mm", -500, 2000);
      region.good_high_mm = number_of(good[1], field + ".good_mm", -500, 2000);
      if (!(region.tight_mm <= region.good_low_mm && region.good_low_mm < region.good_high_mm))
        refuse(good, field + ".good_mm", "expected tight_mm <= from < to");
      g_.regions.push_back(std::move(region));
    }
  }

  // A number, a name, or {name: factor, ..., mm: constant}. Names: measures, lengths, POINT.x and POINT.y.
  LinearForm form_of(const YAML::Node& node, const std::string& field) const {
    LinearForm form;
    if (node.IsScalar()) {
      if (float value = 0; YAML::convert<float>::decode(node, value)) {
        form.mm = number_of(node, field, -kPlaceMaxMm, kPlaceMaxMm);
        return form;
      }
      form.terms.push_back(term_of(node, node.Scalar(), 1, field));
      return form;
    }
    if (!node.IsMap()) refuse(node, field, "is " + shown(node) + ", expected a number, a name or {name: factor}");
    for (const auto& item : node) {
      const std::string name = text_of(item.first, field);
      if (name == "mm") {
        form.mm = number_of(item.second, field + ".mm", -kPlaceMaxMm, kPlaceMaxMm);
        continue;
      }
      const float factor = number_of(item.second, field + "." + name, -kFactorMax, kFactorMax);
      form.terms.push_back(term_of(item.first, name, factor, field));
    }
    return form;
  }

  LinearForm::Term term_of(const YAML::Node& node, const std::string& name, float factor,
                           const std::string& field) const {
    if (const int m = measure(name); m >= 0) return {LinearForm::Of::measure, m, factor};
    if (const int l = length(name); l >= 0) return {LinearForm::Of::length, l, factor};
    if (name.size() > 2 && name[name.size() - 2] == '.')
      if (const int p = point(name.substr(0, name.size() - 2)); p >= 0) {
        if (name.back() == 'x') return {LinearForm::Of::point_x, p, factor};
        if (name.back() == 'y') return {LinearForm::Of::point_y, p, factor};
      }
    refuse(node, field, "names \"" + name + "\", expected a measure of bodies.yaml, or a length or point before it");
  }

  static int measure(const std::string& id) {
    for (std::size_t i = 0; i < body::kCutMeasureCount; ++i)
      if (body::kCutMeasureNames[i] == id) return static_cast<int>(i);
    return -1;
  }
  int length(const std::string& id) const {
    const auto at = std::find(g_.length_ids.begin(), g_.length_ids.end(), id);
    return at == g_.length_ids.end() ? -1 : static_cast<int>(at - g_.length_ids.begin());
  }
  int point(const std::string& id) const {
    for (std::size_t i = 0; i < g_.points.size(); ++i)
      if (g_.points[i].id == id) return static_cast<int>(i);
    return -1;
  }
  int point_of(const YAML::Node& node, const std::string& field) const {
    const int found = point(text_of(node, field));
    if (found < 0) refuse(node, field, "is " + shown(node) + ", expected a point of `points`");
    return found;
  }

  GarmentPattern g_;
};

std::vector<body::Fabric> read_fabrics(const YAML::Node& root) {
  expect_keys(root, "file", {"schema", "fabrics"});
  yaml::expect_schema(root, "im2fit.fabrics/1");
  const YAML::Node all = needed(root, "fabrics", "fabrics", "a list");
  if (!all.IsSequence()) refuse(all, "fabrics", "is " + shown(all) + ", expected a list");
  std::vector<body::Fabric> out;
  for (const YAML::Node& node : all) {
    expect_room(out, node, "fabrics");
    expect_keys(node, "fabrics",
                {"id", "source", "weight_g_m2", "stretch_warp_n_m", "stretch_weft_n_m", "bending_un_m", "friction"});
    body::Fabric f;
    f.id = id_of(needed(node, "id", "fabrics.id", "a word"), "fabrics.id");
    const auto value = [&](const char* key, float low, float high) {
      const std::string field = f.id + "." + key;
      return number_of(needed(node, key, field, "a number"), field, low, high);
    };
    f.weight_g_m2 = value("weight_g_m2", 10, 2000);
    f.stretch_warp_n_m = value("stretch_warp_n_m", 10, 100000);
    f.stretch_weft_n_m = value("stretch_weft_n_m", 10, 100000);
    f.bending_un_m = value("bending_un_m", 0.1F, 1000);
    f.friction = value("friction", 0, 2);
    out.push_back(std::move(f));
  }
  return out;
}

body::CutRegression read_cut_regression(const YAML::Node& root) {
  expect_keys(root, "file", {"schema", "men", "women"});
  yaml::expect_schema(root, "im2fit.bodies/1");
  body::CutRegression regression;
  const std::set<std::string> names(body::kCutMeasureNames.begin() + 1, body::kCutMeasureNames.end());
  for (const std::size_t sex : {0U, 1U}) {
    const std::string word = sex == 0 ? "men" : "women";
    const YAML::Node all = needed(root, word, word, "a field a measure");
    expect_keys(all, word, names);
    for (std::size_t i = 1; i < body::kCutMeasureCount; ++i) {
      const std::string name(body::kCutMeasureNames[i]);
      const std::string field = word + "." + name;
      const YAML::Node line = needed(all, name, field, "{mm: ..., chest: ...}");
      expect_keys(line, field, {"mm", "chest"});
      regression.lines[sex][i].mm = number_of(needed(line, "mm", field + ".mm", "mm"), field + ".mm", -3000, 3000);
      regression.lines[sex][i].per_chest =
          number_of(needed(line, "chest", field + ".chest", "a share of the chest girth"), field + ".chest", -5, 5);
    }
  }
  return regression;
}

Result<std::string> text_of_file(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace

Result<GarmentPattern> parse_garment(const std::string& text, const std::string& what) {
  return yaml::read_fields<GarmentPattern>(text, what, kGarmentKind,
                                           [](const YAML::Node& root) { return GarmentReader().read(root); });
}

Result<GarmentPattern> load_garment(const std::string& path) {
  const auto text = text_of_file(path);
  if (!text) return text.error();
  return parse_garment(*text, path);
}

Result<std::vector<body::Fabric>> parse_fabrics(const std::string& text, const std::string& what) {
  return yaml::read_fields<std::vector<body::Fabric>>(text, what, kGarmentKind, read_fabrics);
}

Result<body::CutRegression> parse_cut_regression(const std::string& text, const std::string& what) {
  return yaml::read_fields<body::CutRegression>(text, what, kGarmentKind, read_cut_regression);
}

Result<Wardrobe> read_shipped_wardrobe(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (std::filesystem::directory_iterator it(folder + "/garments", failed), end; !failed && it != end;
       it.increment(failed))
    if (it->path().extension() == ".yaml" && it->path().filename() != "bodies.yaml")
      names.push_back(it->path().string());
  if (failed) return Error{ErrorCode::io, folder + "/garments: " + failed.message()};
  std::sort(names.begin(), names.end());
  Wardrobe wardrobe;
  for (const std::string& name : names) {
    auto garment = load_garment(name);
    if (!garment) return garment.error();
    wardrobe.garments.push_back(std::move(*garment));
  }
  const std::string fabrics_path = folder + "/fabrics/fabrics.yaml",
                    regression_path = folder + "/garments/bodies.yaml";
  const auto fabrics_text = text_of_file(fabrics_path), regression_text = text_of_file(regression_path);
  if (!fabrics_text) return fabrics_text.error();
  if (!regression_text) return regression_text.error();
  auto fabrics = parse_fabrics(*fabrics_text, fabrics_path);
  if (!fabrics) return fabrics.error();
  wardrobe.fabrics = std::move(*fabrics);
  const auto regression = parse_cut_regression(*regression_text, regression_path);
  if (!regression) return regression.error();
  wardrobe.regression = *regression;
  return wardrobe;
}

std::string wardrobe_table(const Wardrobe& wardrobe) {
  WardrobeRow row;
  put_wardrobe(row, wardrobe);
  std::string text =
      "// Made of data/garments/ and data/fabrics/ by im2fit-lab make wardrobe-table; see person/wardrobe.h.\n"
      "// clang-format off\n";
  const auto add = [&](const char* type, const char* name, const auto& values, const auto& literal) {
    text += std::string("constexpr ") + type + " " + name + "[] = {";
    std::size_t column = kColumns;
    for (const auto& value : values) {
      const std::string word = literal(value) + ",";
      column += word.size() + 1;
      text += column > kColumns ? "\n    " : " ";
      if (column > kColumns) column = 4 + word.size();
      text += word;
    }
    text += "\n};\n";
  };
  add("float", "kNumbers", row.numbers, float_literal);
  add("int", "kWholes", row.wholes, [](int value) { return std::to_string(value); });
  add("std::string_view", "kTexts", row.texts, quoted_literal);
  return text + "// clang-format on\n";
}

}  // namespace im2fit
