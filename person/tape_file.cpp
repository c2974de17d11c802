// SPDX-License-Identifier: Apache-2.0
#include "person/tape_file.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <set>
#include <utility>

#include "body/model_data.h"
#include "core/file.h"
#include "formats/yaml_fields.h"
#include "person/builtin_tape.h"

namespace im2fit {
namespace {

using body::PointRef;
using body::Tape;
using body::TapeDefinition;
using body::TapeKind;
using body::TapePlane;
using body::TapePoint;
using body::TapeSearch;
using body::TapeSide;
using yaml::expect_keys;
using yaml::id_of;
using yaml::number_of;
using yaml::refuse;
using yaml::shown;
using yaml::text_of;

constexpr std::size_t kListMax = 500;  // points, and measurements, of all files together

template <class Enum>
Enum word_of(const YAML::Node& node, const std::string& field, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<Enum>(i);
    const std::string name(name_of(value));
    if (node.IsScalar() && node.Scalar() == name) return value;
    all += (all.empty() ? "" : ", ") + name;
  }
  refuse(node, field, "is " + shown(node) + ", expected one of " + all);
}

Measurement value_of(const YAML::Node& node, const std::string& field, bool level) {
  std::string all;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const auto m = static_cast<Measurement>(i);
    if (level && (m < Measurement::neck_girth || m > Measurement::hip_girth)) continue;
    const std::string id(kMeasurementTable[i].id);
    if (node.IsScalar() && node.Scalar() == id) return m;
    all += (all.empty() ? "" : ", ") + id;
  }
  refuse(node, field, "is " + shown(node) + ", expected one of " + all);
}

class TapeReader {
 public:
  explicit TapeReader(Tape onto) : tape_(std::move(onto)) {}

  Tape read(const YAML::Node& root) {
    expect_keys(root, "file", {"schema", "points", "measurements"});
    yaml::expect_schema(root, "im2fit.tape/1");
    if (const YAML::Node points = root["points"]; points.IsDefined()) read_points(points);
    if (const YAML::Node all = root["measurements"]; all.IsDefined()) read_measurements(all);
    return std::move(tape_);
  }

 private:
  // Points.

  void read_points(const YAML::Node& points) {
    if (!points.IsMap()) refuse(points, "points", "is " + shown(points) + ", expected a field a point");
    for (const auto& item : points) {
      const std::string id = id_of(item.first, "points");
      if (point_index(tape_, id) >= 0) refuse(item.first, "points." + id, "appears twice");
      if (tape_.points.size() == kListMax)
        refuse(item.first, "points." + id, "is one too many, expected at most 500");
      tape_.points.push_back(point(id, item.second));
    }
  }

  TapePoint point(const std::string& id, const YAML::Node& node) {
    const std::string what = "points." + id;
    TapePoint p;
    p.id = id;
    if (!node.IsMap()) refuse(node, what, "is " + shown(node) + ", expected fields");
    if (node["vertex"].IsDefined()) {
      expect_keys(node, what, {"vertex"});
      vertices(p, node["vertex"], what + ".vertex");
    } else if (node["bone"].IsDefined()) {
      expect_keys(node, what, {"bone", "end"});
      bone(p, node, what);
    } else if (node["level"].IsDefined()) {
      expect_keys(node, what, {"level"});
      p.kind = TapePoint::Kind::level;
      p.level = value_of(node["level"], what + ".level", true);
    } else if (node["between"].IsDefined()) {
      expect_keys(node, what, {"between", "share"});
      const YAML::Node two = node["between"];
      if (!two.IsSequence() || two.size() != 2) refuse(two, what + ".between", "expected two points");
      p.kind = TapePoint::Kind::between;
      p.a = reference(two[0], what + ".between");
      p.b = reference(two[1], what + ".between");
      if (node["share"].IsDefined()) p.share = number_of(node["share"], what + ".share", -2, 3);
    } else if (node["at"].IsDefined()) {
      expect_keys(node, what, {"at", "height_of"});
      p.kind = TapePoint::Kind::at;
      p.a = reference(node["at"], what + ".at");
      if (!node["height_of"].IsDefined()) refuse(node, what + ".height_of", "is missing, expected a point");
      p.b = reference(node["height_of"], what + ".height_of");
    } else if (node["from"].IsDefined()) {
      expect_keys(node, what, {"from", "by_mm"});
      p.kind = TapePoint::Kind::moved;
      p.a = p.b = reference(node["from"], what + ".from");
      const YAML::Node by = node["by_mm"];
      if (!by.IsDefined() || !by.IsSequence() || by.size() != 3)
        refuse(by.IsDefined() ? by : node, what + ".by_mm", "expected [outwards, up, to the front] in mm");
      p.by = {number_of(by[0], what + ".by_mm", -1000, 1000), number_of(by[1], what + ".by_mm", -1000, 1000),
              number_of(by[2], what + ".by_mm", -1000, 1000)};
    } else if (node["skin"].IsDefined()) {
      expect_keys(node, what, {"skin", "of"});
      p.kind = TapePoint::Kind::skin;
      const YAML::Node toward = node["skin"];
      using Toward = TapePoint::Toward;
      const std::string word = toward.IsScalar() ? toward.Scalar() : "";
      if (word != "front" && word != "back" && word != "outside")
        refuse(toward, what + ".skin", "is " + shown(toward) + ", expected front, back or outside");
      p.toward = word == "front" ? Toward::front : word == "back" ? Toward::back : Toward::outside;
      p.paired = p.toward == Toward::outside;
      if (!node["of"].IsDefined()) refuse(node, what + ".of", "is missing, expected a point");
      p.a = p.b = reference(node["of"], what + ".of");
    } else {
      refuse(node, what, "has no place, expected vertex, bone, level, between, at, from or skin");
    }
    p.paired = p.paired || is_paired(p.a) || is_paired(p.b);
    return p;
  }

  static void vertices(TapePoint& p, const YAML::Node& node, const std::string& field) {
    const bool pair = node.IsSequence();
    if (pair && node.size() != 2) refuse(node, field, "expected one vertex, or the left and the right one");
    p.kind = TapePoint::Kind::vertex;
    p.paired = pair;
    for (std::size_t i = 0; i < (pair ? 2U : 1U); ++i) {
      const YAML::Node one = pair ? node[i] : node;
      int value = -1;
      if (!one.IsScalar() || !YAML::convert<int>::decode(one, value) || value < 0 || value >= body::kBodyVertexCount)
        refuse(one, field,
               "is " + shown(one) + ", expected a vertex of the body from 0 to " +
                   std::to_string(body::kBodyVertexCount - 1));
      p.vertex[i] = value;
    }
  }

  static void bone(TapePoint& p, const YAML::Node& node, const std::string& what) {
    const std::string name = text_of(node["bone"], what + ".bone");
    p.kind = TapePoint::Kind::bone;
    int found = 0;
    for (std::size_t s = 0; s < static_cast<std::size_t>(body::kSegmentCount); ++s) {
      const std::string_view segment = body::kSegmentNames[s];
      if (segment == name) {
        p.segment = {static_cast<body::Segment>(s), static_cast<body::Segment>(s)};
        found = 1;
      }
      for (const std::size_t side : {0U, 1U})
        if (segment == (side == 0 ? "left_" : "right_") + name) {
          p.segment[side] = static_cast<body::Segment>(s);
          found = 2;
        }
    }
    if (found == 0)
      refuse(node["bone"], what + ".bone", "is " + shown(node["bone"]) + ", expected a bone (docs/tape.md)");
    p.paired = found == 2;
    const YAML::Node end = node["end"];
    if (!end.IsDefined() || !end.IsScalar() || (end.Scalar() != "head" && end.Scalar() != "tail"))
      refuse(end.IsDefined() ? end : node, what + ".end", "is " + shown(end) + ", expected head or tail");
    p.tail = end.Scalar() == "tail";
  }

  PointRef reference(const YAML::Node& node, const std::string& field) const {
    std::string id = text_of(node, field);
    PointRef ref;
    for (const auto& [word, side] :
         {std::pair{"left ", PointRef::Side::left}, std::pair{"right ", PointRef::Side::right}})
      if (id.rfind(word, 0) == 0) {
        ref.side = side;
        id.erase(0, std::string_view(word).size());
      }
    ref.point = point_index(tape_, id);
    if (ref.point < 0) refuse(node, field, "is " + shown(node) + ", expected a point defined before it");
    if (ref.side != PointRef::Side::own && !tape_.points[static_cast<std::size_t>(ref.point)].paired)
      refuse(node, field, "is " + shown(node) + ", but that point has no sides");
    return ref;
  }
  bool is_paired(PointRef ref) const {
    return ref.point >= 0 && ref.side == PointRef::Side::own &&
           tape_.points[static_cast<std::size_t>(ref.point)].paired;
  }

  // Measurements.

  void read_measurements(const YAML::Node& all) {
    if (!all.IsSequence()) refuse(all, "measurements", "is " + shown(all) + ", expected a list");
    for (const YAML::Node& node : all) {
      if (tape_.definitions.size() == kListMax) refuse(node, "measurements", "are too many, expected at most 500");
      tape_.definitions.push_back(definition(node));
    }
  }

  TapeDefinition definition(const YAML::Node& node) {
    expect_keys(node, "measurement",
                {"id", "name", "kind", "value", "points", "plane", "search", "share", "from", "to", "side", "terms",
                 "iso_8559", "iso_7250", "astm_d5219", "source", "reason"});
    TapeDefinition d;
    if (!node["id"].IsDefined()) refuse(node, "measurement.id", "is missing");
    d.id = id_of(node["id"], "measurement.id");
    if (definition_index(tape_, d.id) >= 0) refuse(node["id"], "measurement.id", "\"" + d.id + "\" appears twice");
    names(d, node);
    for (const auto& [key, field] :
         {std::pair{"iso_8559", &d.iso_8559}, std::pair{"iso_7250", &d.iso_7250},
          std::pair{"astm_d5219", &d.astm_d5219}, std::pair{"source", &d.source}, std::pair{"reason", &d.reason}})
      if (node[key].IsDefined()) *field = text_of(node[key], d.id + "." + key);
    if (!node["kind"].IsDefined()) refuse(node, d.id + ".kind", "is missing");
    d.kind = word_of<TapeKind>(node["kind"], d.id + ".kind", 10);
    if (d.source.empty()) refuse(node, d.id + ".source", "is missing, expected the source of the definition");
    if (d.kind == TapeKind::value) {
      if (!node["value"].IsDefined())
        refuse(node, d.id + ".value", "is missing, expected one of the eleven measurements");
      d.value = value_of(node["value"], d.id + ".value", false);
    } else if (d.kind == TapeKind::refused) {
      if (d.reason.empty()) refuse(node, d.id + ".reason", "is missing, expected the reason why it is not measured");
    } else if (d.kind == TapeKind::sum) {
      terms(d, node);
    } else {
      geometry(d, node);
    }
    return d;
  }

  static void names(TapeDefinition& d, const YAML::Node& node) {
    const YAML::Node all = node["name"];
    if (!all.IsDefined()) refuse(node, d.id + ".name", "is missing, expected {en: ...}");
    std::set<std::string> languages(body::kTapeLanguages.begin(), body::kTapeLanguages.end());
    expect_keys(all, d.id + ".name", languages);
    for (std::size_t i = 0; i < body::kTapeLanguages.size(); ++i) {
      const std::string language(body::kTapeLanguages[i]);
      if (all[language].IsDefined()) d.names[i] = text_of(all[language], d.id + ".name." + language);
    }
    if (d.names[0].empty()) refuse(all, d.id + ".name.en", "is missing, expected a text");
  }

  void terms(TapeDefinition& d, const YAML::Node& node) const {
    const YAML::Node terms = node["terms"];
    if (!terms.IsDefined() || !terms.IsMap() || terms.size() == 0)
      refuse(terms.IsDefined() ? terms : node, d.id + ".terms", "expected {measurement: factor, ...}");
    for (const auto& item : terms) {
      const std::string id = id_of(item.first, d.id + ".terms");
      const int index = definition_index(tape_, id);
      if (index < 0) refuse(item.first, d.id + ".terms", "\"" + id + "\" is not a measurement defined before it");
      const TapeDefinition& term = tape_.definitions[static_cast<std::size_t>(index)];
      if (term.kind == TapeKind::refused || unit_of(term) != "mm")
        refuse(item.first, d.id + ".terms", "\"" + id + "\" is not a measured length");
      d.terms.push_back({index, number_of(item.second, d.id + ".terms." + id, -10, 10)});
    }
  }

  void geometry(TapeDefinition& d, const YAML::Node& node) const {
    const YAML::Node points = node["points"];
    const std::string field = d.id + ".points";
    if (!points.IsDefined()) refuse(node, field, "is missing, expected a list of points");
    if (!points.IsSequence()) refuse(points, field, "is " + shown(points) + ", expected a list of points");
    if (points.size() > body::kTapePointsMax) refuse(points, field, "has too many, expected at most 8");
    for (const YAML::Node& point : points) d.points.push_back(reference(point, field));
    const bool section = d.kind == TapeKind::girth || d.kind == TapeKind::contour || d.kind == TapeKind::breadth ||
                         d.kind == TapeKind::depth;
    if (node["plane"].IsDefined()) d.plane = word_of<TapePlane>(node["plane"], d.id + ".plane", 6);
    if (section && d.plane > TapePlane::points)
      refuse(node["plane"], d.id + ".plane", "is " + shown(node["plane"]) + ", expected level, line or points");
    if (d.kind == TapeKind::arc && d.plane == TapePlane::line)
      refuse(node["plane"], d.id + ".plane", "is \"line\", expected level, points, sagittal, upright or facing");
    std::size_t least = 1, most = 2;  // heights, level sections
    if (d.kind == TapeKind::length) least = 2, most = body::kTapePointsMax;
    if (d.kind == TapeKind::arc || (section && d.plane == TapePlane::points)) least = most = 3;
    if (section && d.plane == TapePlane::line) least = most = 2;
    if (d.points.size() < least || d.points.size() > most)
      refuse(points, field,
             "has " + std::to_string(d.points.size()) + " points, expected " + std::to_string(least) +
                 (most > least ? " to " + std::to_string(most) : ""));
    way(d, node, section);
    side(d, node);
  }

  static void way(TapeDefinition& d, const YAML::Node& node, bool section) {
    const bool has_way = section && d.plane != TapePlane::points && d.points.size() == 2;
    for (const char* key : {"search", "share", "from", "to"})
      if (node[key].IsDefined() && !has_way)
        refuse(node[key], d.id + "." + key, "is for a section on the way between two points");
    if (!has_way) d.share = 0;
    if (node["share"].IsDefined()) d.share = number_of(node["share"], d.id + ".share", -1, 2);
    if (node["search"].IsDefined()) d.search = word_of<TapeSearch>(node["search"], d.id + ".search", 3);
    if (node["from"].IsDefined()) d.search_from = number_of(node["from"], d.id + ".from", -1, 2);
    if (node["to"].IsDefined()) d.search_to = number_of(node["to"], d.id + ".to", -1, 2);
    if (!(d.search_from < d.search_to)) refuse(node, d.id + ".to", "expected more than from");
  }

  void side(TapeDefinition& d, const YAML::Node& node) const {
    if (node["side"].IsDefined()) d.side = word_of<TapeSide>(node["side"], d.id + ".side", 4);
    bool paired = false;
    for (const PointRef ref : d.points) paired = paired || is_paired(ref);
    if (paired && d.side == TapeSide::middle)
      refuse(node["side"].IsDefined() ? node["side"] : node, d.id + ".side",
             "expected left, right or mean: it uses points that are pairs");
  }

  Tape tape_;
};

}  // namespace

Result<Tape> parse_tape(const std::string& text, const std::string& what, Tape onto) {
  return yaml::read_fields<Tape>(text, what, "a tape in YAML (docs/tape.md)",
                                 [&](const YAML::Node& root) { return TapeReader(std::move(onto)).read(root); });
}

Result<Tape> load_tape(const std::string& path, Tape onto) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_tape(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), path, std::move(onto));
}

Result<Tape> load_tapes(const std::vector<std::string>& paths) {
  Tape tape = builtin_tape();
  for (const std::string& path : paths) {
    auto more = load_tape(path, std::move(tape));
    if (!more) return more.error();
    tape = std::move(*more);
  }
  return tape;
}

}  // namespace im2fit
