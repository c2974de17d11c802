// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <charconv>
#include <string_view>

#include "person/builtin_tape.h"
#include "person/source_literals.h"
#include "person/tape_file.h"

namespace im2fit {
namespace {

using body::PointRef;
using body::TapeDefinition;
using body::TapePoint;

std::string boolean(bool value) {
  return value ? "true" : "false";
}

std::string measurement(Measurement m) {
  return "Measurement::" + std::string(kMeasurementTable[measurement_index(m)].id);
}

std::string segment(body::Segment s) {
  return "Segment::" + std::string(body::kSegmentNames[static_cast<std::size_t>(s)]);
}

std::string reference(PointRef ref) {
  constexpr std::array<std::string_view, 3> kSides = {"own", "left", "right"};
  return "{" + std::to_string(ref.point) + ", Side::" + std::string(kSides[static_cast<std::size_t>(ref.side)]) + "}";
}

std::string point_row(const TapePoint& p) {
  constexpr std::array<std::string_view, 7> kKinds = {"vertex", "bone", "level", "between", "at", "moved", "skin"};
  constexpr std::array<std::string_view, 3> kTowards = {"front", "back", "outside"};
  return "    {" + quoted_literal(p.id) + ", Kind::" + std::string(kKinds[static_cast<std::size_t>(p.kind)]) + ", " +
         boolean(p.paired) + ", {" + std::to_string(p.vertex[0]) + ", " + std::to_string(p.vertex[1]) + "}, {" +
         segment(p.segment[0]) + ", " + segment(p.segment[1]) + "}, " + boolean(p.tail) + ", " +
         measurement(p.level) + ", " + reference(p.a) + ", " + reference(p.b) + ", " + float_literal(p.share) +
         ", {" + float_literal(p.by.x) + ", " + float_literal(p.by.y) + ", " + float_literal(p.by.z) +
         "}, Toward::" + std::string(kTowards[static_cast<std::size_t>(p.toward)]) + "},\n";
}

constexpr const char* kZero = " \"\\0\"";

std::string definition_row(const TapeDefinition& d) {
  // All texts in one literal, each with a zero behind it.
  std::string row = "    {" + quoted_literal(d.id) + kZero;
  for (const std::string& name : d.names) row += " " + quoted_literal(name) + kZero;
  row += "\n     " + quoted_literal(d.iso_8559) + kZero + " " + quoted_literal(d.iso_7250) + kZero + " " +
         quoted_literal(d.astm_d5219) + kZero + "\n     " + quoted_literal(d.source) + kZero + " " +
         quoted_literal(d.reason) + kZero + "sv,\n     TapeKind::" + std::string(name_of(d.kind)) + ", " +
         measurement(d.value) + ", " + std::to_string(d.points.size()) + ", {{";
  for (std::size_t i = 0; i < d.points.size(); ++i) row += (i > 0 ? ", " : "") + reference(d.points[i]);
  row += "}}, TapePlane::" + std::string(name_of(d.plane)) + ", TapeSearch::" + std::string(name_of(d.search)) +
         ", " + float_literal(d.share) + ", " + float_literal(d.search_from) + ", " + float_literal(d.search_to) +
         ", TapeSide::" + std::string(name_of(d.side)) + ", " + std::to_string(d.terms.size()) + ", {{";
  for (std::size_t i = 0; i < d.terms.size(); ++i)
    row +=
        (i > 0 ? ", {" : "{") + std::to_string(d.terms[i].definition) + ", " + float_literal(d.terms[i].factor) + "}";
  return row + "}}},\n";
}

}  // namespace

Result<std::string> tape_table(const body::Tape& tape) {
  std::string text =
      "// Made of data/tape/ by im2fit-lab make tape-table; see person/builtin_tape.h.\n"
      "// clang-format off\n"
      "constexpr PointRow kPoints[] = {\n";
  for (const TapePoint& p : tape.points) text += point_row(p);
  text += "};\nconstexpr DefinitionRow kDefinitions[] = {\n";
  for (const TapeDefinition& d : tape.definitions) {
    if (d.terms.size() > kBuiltinTapeTermsMax)
      return Error{ErrorCode::unsupported, d.id + " sums " + std::to_string(d.terms.size()) +
                                               " terms; raise kBuiltinTapeTermsMax of person/builtin_tape.h"};
    text += definition_row(d);
  }
  return text + "};\n";
}

Result<body::Tape> read_shipped_tape(const std::string& folder) {
  body::Tape tape;
  for (const char* part : {"points", "heights", "girths", "lengths"}) {
    auto more = load_tape(folder + "/" + part + ".yaml", std::move(tape));
    if (!more) return more;
    tape = std::move(*more);
  }
  return tape;
}

}  // namespace im2fit
