// SPDX-License-Identifier: Apache-2.0
// A garment as a tailor draws it: a flat outline whose points are sums of body measurements, so that one drawing is
// cut in every size. Text becomes a GarmentPattern in person/garment_file.h; docs/garments.md has every field.
//
// Axes of a pattern: x outwards from the centre line to the wearer's left, y up along the grain, mm. Sleeves
// are drawn 30 degrees below level and legs 7 degrees from upright: nearer to how people stand than to how they are
// dressed (garment/drape/dressing_pose.h), or cloth stands off arms that hang and hips.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace im2fit::body {

// What a size is cut for, mm: ids of data/garments/bodies.yaml.
enum class CutMeasure : std::uint8_t {
  chest,
  waist,
  high_hip,
  hip,
  thigh,
  knee,
  calf,
  upper_arm,
  wrist,
  neck,
  shoulder,    // acromion to acromion
  arm,         // acromion, elbow, wrist
  inside_leg,  // crotch to floor
  stature,
  shoulder_x,        // of the shoulder joint from the middle
  shoulder_to_neck,  // height of the skin beside the neck above the shoulder joint
  shoulder_top,      // height of the skin over the shoulder joint above it
  hip_x,             // of the hip joint from the middle
  hip_to_crotch,     // height of the hip joint above the crotch
  hip_to_high_hip,   // height of the high hip above the hip joint
};
inline constexpr std::size_t kCutMeasureCount = 20;
extern const std::array<std::string_view, kCutMeasureCount> kCutMeasureNames;
using CutBody = std::array<float, kCutMeasureCount>;

// The mean body of a size: each measure is a straight line over the chest girth of the chart, by sex.
struct CutRegression {
  struct Line {
    float mm = 0, per_chest = 0;
  };
  std::array<std::array<Line, kCutMeasureCount>, 2> lines{};  // men, women
};
CutBody cut_body(const CutRegression& regression, bool woman, float chest_mm);
// As a shop turns legs up: cut for no longer legs than the wearer has.
CutBody turned_up(CutBody body, float inside_leg_mm);

// A sum of measures, earlier lengths and earlier points' coordinates, each times a factor, and a constant.
struct LinearForm {
  enum class Of : std::uint8_t { measure, length, point_x, point_y };
  struct Term {
    Of of = Of::measure;
    int index = 0;
    float factor = 1;
  };
  float mm = 0;
  std::vector<Term> terms;
};

// Of these angles.
inline constexpr float kSleeveCosine = 0.86602540F, kSleeveSine = 0.50000000F;
inline constexpr float kLegTangent = 0.12278456F;

enum class EdgeKind : std::uint8_t {
  centre,   // the middle: a fold, or the seam that joins left and right; both panels' own line
  seam,     // joins front and back: one line for both
  hem,      // free, turned over
  opening,  // free, held by a band: neck, waist
};

struct PatternPoint {
  std::string id;
  LinearForm x, y;        // of the front panel
  bool has_back = false;  // the back panel's differs
  LinearForm back_x, back_y;
};
struct PatternEdge {
  EdgeKind kind = EdgeKind::seam;
  int to = 0;            // point; the edge begins where the one before it ended
  std::vector<int> via;  // none: straight; one, two: control points of a quadratic, cubic Bezier curve
};

enum class Hang : std::uint8_t { shoulders, waist };

// A region in which the ease of a size is reported: finished girth less the body's.
struct FitRegion {
  std::string id;                           // "chest"
  std::string measure;                      // of the tape (docs/tape.md), "chest_girth"
  LinearForm girth;                         // finished
  float tight_mm = 0;                       // less ease than this binds
  float good_low_mm = 0, good_high_mm = 0;  // as it is meant to be worn
};

// Extra cloth about a point of the outline, as a tailor adds a gusset so that arms can rise. Lengths at the point are
// 1 + `more` times the drawn length, falling with distance to the drawn length at `reach_mm`.
struct Gusset {
  int at = -1;  // point; -1: none
  float more = 0, reach_mm = 0;
};

inline constexpr std::size_t kGarmentLanguages = 5;  // body::kTapeLanguages' order
struct GarmentPattern {
  std::string id;
  std::array<std::string, kGarmentLanguages> names;
  Hang hang = Hang::shoulders;
  bool legs = false;   // a leg's panels left and right of a centre seam, else the centre is a fold
  std::string fabric;  // id of a fabric
  std::array<float, 3> colour = {0.5F, 0.5F, 0.5F};  // linear, for pictures and avatars
  std::vector<std::string> length_ids;
  std::vector<LinearForm> lengths;
  std::vector<PatternPoint> points;
  int start = 0;
  std::vector<PatternEdge> edges;  // of the left half, anticlockwise, closed (a fold: by the centre line)
  Gusset gusset;
  std::vector<FitRegion> regions;
};

// Cloth as data: data/fabrics/*.yaml.
struct Fabric {
  std::string id;
  float weight_g_m2 = 170;
  float stretch_warp_n_m = 400, stretch_weft_n_m = 400;  // force for its own length, per width
  float bending_un_m = 4.8F;                             // flexural rigidity, micro newton metre
  float friction = 0.4F;                                 // on skin, and on other cloth
  float thickness_mm = 0.6F;
};

struct Flat {
  float x = 0, y = 0;
};

// A pattern in one size: numbers.
struct CutPattern {
  struct Line {
    EdgeKind kind = EdgeKind::seam;
    std::vector<Flat> front, back;  // from end to end, evenly spaced, as many points in both of a seam
  };
  std::vector<Line> lines;      // closed; of the left half
  Flat gusset_at;               // of the pattern's gusset
  std::vector<float> girth_mm;  // a region each
};
// Edges no longer than `edge_mm`.
CutPattern cut(const GarmentPattern& pattern, const CutBody& body, float edge_mm);
// Whether it can be sewn and draped in this size: points within kPatternMaxMm of the origin, front and back
// anticlockwise without crossing themselves, and no more cloth than kClothMaxM2: draping takes time in proportion to
// it. Errors: invalid_argument; the message names the garment and the panel or point.
Status check_cut(const GarmentPattern& pattern, const CutBody& body);
inline constexpr float kPatternMaxMm = 3000, kOutlineMaxMm = 16000, kClothMaxM2 = 8;
// Of the regions alone.
std::vector<float> finished_girths(const GarmentPattern& pattern, const CutBody& body);

}  // namespace im2fit::body
