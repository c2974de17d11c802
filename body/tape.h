// SPDX-License-Identifier: Apache-2.0
// The tape: measurements as data. A definition names points of the body and what is measured between or round them;
// docs/tape.md has every field. person/tape_file.h parses text into a Tape; this directory reads no text.
//
// body/measure.h measures the eleven values of core/measurement.h here too, so each has a single definition.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/measure.h"
#include "body/model.h"
#include "core/measurement.h"

namespace im2fit::body {

// A point of the list, of one side when it is one of a pair.
struct PointRef {
  enum class Side : std::uint8_t { own, left, right };
  int point = -1;
  Side side = Side::own;  // own: that of the measurement, or of the point, that refers to it
};

struct TapePoint {
  enum class Kind : std::uint8_t {
    vertex,   // of the mesh
    bone,     // an end of a bone
    level,    // the middle of the section in which a girth of the eleven is taken
    between,  // share of the way from a to b
    at,       // a, at the height of b
    moved,    // a, moved by millimetres: outwards (of the left side: to the left), up, to the front
    skin,     // where a ray from a leaves the body
  };
  enum class Toward : std::uint8_t { front, back, outside };  // outside: sideways, of a pair
  std::string id;
  Kind kind = Kind::vertex;
  bool paired = false;
  std::array<std::int32_t, 2> vertex{};  // left, right; the first alone without a pair
  std::array<Segment, 2> segment{};
  bool tail = false;
  Measurement level = Measurement::waist_girth;
  PointRef a, b;
  float share = 0.5F;
  Vec3f by;
  Toward toward = Toward::front;
};

enum class TapeKind : std::uint8_t {
  value,    // one of the eleven
  height,   // of points[0] above the floor, or above points[1]
  breadth,  // of the section, sideways
  depth,    // of the section, front to back
  girth,    // round the convex hull of the section
  contour,  // round the section along the skin
  arc,      // over the skin from points[0] by points[1] to points[2], hollows bridged
  length,   // straight from point to point
  sum,      // of other measurements
  refused,  // not measured, and why
};
// The plane of a section or an arc.
enum class TapePlane : std::uint8_t {
  level,     // horizontal, through points[0]; with a second, on the way to it
  line,      // perpendicular to the line from points[0] to points[1], on the way
  points,    // through three points
  sagittal,  // through points[0], perpendicular to the left-right axis
  upright,   // of an arc: through both ends, upright
  facing,    // of an arc: through both ends, not turned to a side
};
enum class TapeSearch : std::uint8_t { none, smallest, largest };
enum class TapeSide : std::uint8_t { middle, left, right, mean };

inline constexpr std::size_t kTapePointsMax = 8;
inline constexpr std::array<std::string_view, 5> kTapeLanguages = {"en", "de", "es", "fr", "zh"};

struct TapeTerm {
  int definition = -1;  // an earlier one of the list
  float factor = 1;
};

struct TapeDefinition {
  std::string id;
  std::array<std::string, kTapeLanguages.size()> names;  // in kTapeLanguages' order; "" where a user gave none
  std::string iso_8559, iso_7250, astm_d5219;            // numbers; "" where there is none
  std::string source;                                    // of the definition, in words
  std::string reason;                                    // refused: why
  TapeKind kind = TapeKind::value;
  Measurement value = Measurement::stature;
  std::vector<PointRef> points;
  TapePlane plane = TapePlane::level;
  TapeSearch search = TapeSearch::none;
  float share = 0.5F;                    // along the way; without a search
  float search_from = 0, search_to = 1;  // shares, of a search
  TapeSide side = TapeSide::middle;
  std::vector<TapeTerm> terms;
};

struct Tape {
  std::vector<TapePoint> points;  // those a point refers to stand before it
  std::vector<TapeDefinition> definitions;
};
int point_index(const Tape& tape, std::string_view id);       // -1: none
int definition_index(const Tape& tape, std::string_view id);  // -1: none
std::string_view unit_of(const TapeDefinition& definition);   // "mm" or "kg"
std::string_view name_of(TapeKind kind);
std::string_view name_of(TapePlane plane);
std::string_view name_of(TapeSide side);
std::string_view name_of(TapeSearch search);

// Where a measurement runs, in the mesh's axes: lines of points, closed ones end where they began.
using TapeLines = std::vector<std::vector<Vec3f>>;

// Puts a tape round bodies, in the relaxed pose of body/measure.h. Not shareable between threads; the model must
// outlive it. Memory is kept from body to body. + - * / and sqrt only: the same bits on every machine.
class TapeMeasurer {
 public:
  explicit TapeMeasurer(const BodyModel& model);
  TapeMeasurer(TapeMeasurer&&) noexcept;
  TapeMeasurer& operator=(TapeMeasurer&&) noexcept;
  ~TapeMeasurer();
  // out: a place a definition. Not-a-number: refused, or the body has no such section. About 30 ms for the shipped.
  void measure(const Tape& tape, const Params& params, std::span<float> out);
  // The same of a rest mesh that parameters alone do not make. `rest_vertices`: all of the model's.
  void measure_rest_mesh(const Tape& tape, std::span<const Vec3f> rest_vertices, float gender, std::span<float> out);
  // The same for a body that `body` has measured already. `body` must keep it until the last call of lines() and
  // mesh().
  void measure(const Tape& tape, const Measurer& body, std::span<float> out);
  // Of the body measured last.
  TapeLines lines(const Tape& tape, int definition);
  std::span<const Vec3f> mesh() const;  // posed, all vertices of the model

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit::body
