// SPDX-License-Identifier: Apache-2.0
#include "person/builtin_tape.h"

namespace im2fit {
namespace {

using body::PointRef;
using body::Segment;
using body::TapeKind;
using body::TapePlane;
using body::TapeSearch;
using body::TapeSide;
using Side = body::PointRef::Side;
using Kind = body::TapePoint::Kind;
using Toward = body::TapePoint::Toward;
using std::string_view_literals::operator""sv;

// As TapePoint and TapeDefinition, in the order of their fields, with nothing to construct before main().
struct PointRow {
  std::string_view id;
  Kind kind;
  bool paired;
  std::array<std::int32_t, 2> vertex;
  std::array<Segment, 2> segment;
  bool tail;
  Measurement level;
  PointRef a, b;
  float share;
  Vec3f by;
  Toward toward;
};
// In the order of the definition's fields, whatever that costs in padding.
struct DefinitionRow {  // NOLINT(clang-analyzer-optin.performance.Padding)
  // id, names, iso_8559, iso_7250, astm_d5219, source and reason, each with a zero behind it. A pointer costs the
  // shared library 32 bytes and more where it is loaded anywhere: one for a row, not eleven.
  std::string_view texts;
  TapeKind kind;
  Measurement value;
  std::size_t point_count;
  std::array<PointRef, body::kTapePointsMax> points;
  TapePlane plane;
  TapeSearch search;
  float share, search_from, search_to;
  TapeSide side;
  std::size_t term_count;
  std::array<body::TapeTerm, kBuiltinTapeTermsMax> terms;
};
#include "person/builtin_tape.inc"

body::TapePoint point_of(const PointRow& row) {
  return {std::string(row.id), row.kind, row.paired, row.vertex, row.segment, row.tail,
          row.level,           row.a,    row.b,      row.share,  row.by,      row.toward};
}

// Takes the first text off a row's.
std::string next_text(std::string_view& texts) {
  const std::size_t end = texts.find('\0');
  std::string text(texts.substr(0, end));
  texts.remove_prefix(end + 1);
  return text;
}

body::TapeDefinition definition_of(const DefinitionRow& row) {
  body::TapeDefinition d;
  std::string_view texts = row.texts;
  d.id = next_text(texts);
  for (auto& name : d.names) name = next_text(texts);
  d.iso_8559 = next_text(texts);
  d.iso_7250 = next_text(texts);
  d.astm_d5219 = next_text(texts);
  d.source = next_text(texts);
  d.reason = next_text(texts);
  d.kind = row.kind;
  d.value = row.value;
  d.points.assign(row.points.begin(), row.points.begin() + static_cast<std::ptrdiff_t>(row.point_count));
  d.plane = row.plane;
  d.search = row.search;
  d.share = row.share;
  d.search_from = row.search_from;
  d.search_to = row.search_to;
  d.side = row.side;
  d.terms.assign(row.terms.begin(), row.terms.begin() + static_cast<std::ptrdiff_t>(row.term_count));
  return d;
}

body::Tape make_tape() {
  body::Tape tape;
  for (const PointRow& row : kPoints) tape.points.push_back(point_of(row));
  for (const DefinitionRow& row : kDefinitions) tape.definitions.push_back(definition_of(row));
  return tape;
}

}  // namespace

const body::Tape& builtin_tape() {
  static const body::Tape tape = make_tape();
  return tape;
}

}  // namespace im2fit
