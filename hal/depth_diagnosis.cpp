// SPDX-License-Identifier: Apache-2.0
#include "hal/depth_diagnosis.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

// A person to measure stands 1 to 4 m away, before a wall that is rarely beyond 8 m.
constexpr int kRoomMinMm = 600, kRoomMaxMm = 8000;
// Of neighbouring pixels with depth, those that differ by more than a sixteenth: 2 to 8 % in rooms (outlines), 60 %
// and more where the bytes of a value are swapped.
constexpr double kRoughMax = 0.25;

struct Pair {
  std::uint16_t value, right;
};

// Pairs of neighbours that both have depth, every second row and column at most.
std::vector<Pair> pairs_of(DepthView depth) {
  std::vector<Pair> pairs;
  for (int v = 0; v < depth.height; v += 2)
    for (int u = 0; u + 1 < depth.width; u += 2)
      if (depth.at(u, v) != 0 && depth.at(u + 1, v) != 0) pairs.push_back({depth.at(u, v), depth.at(u + 1, v)});
  return pairs;
}

// The pairs read another way.
struct Reading {
  double median = 0;
  double rough = 0;
  bool is_room() const { return rough <= kRoughMax && median >= kRoomMinMm && median <= kRoomMaxMm; }
};

template <class Read>
Reading read_as(const std::vector<Pair>& pairs, const Read& read) {
  std::vector<double> values;
  std::size_t rough = 0;
  for (const Pair& pair : pairs) {
    const double a = read(pair.value), b = read(pair.right);
    values.push_back(a);
    rough += std::abs(a - b) > std::max(a, b) / 16 ? 1 : 0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return {*middle, static_cast<double>(rough) / static_cast<double>(pairs.size())};
}

template <class Holds>
double share_of(const std::vector<Pair>& pairs, const Holds& holds) {
  const auto count = std::count_if(pairs.begin(), pairs.end(), [&](const Pair& p) { return holds(p.value); });
  return static_cast<double>(count) / static_cast<double>(pairs.size());
}

// What 16-bit values may mean, in millimetres, and its name.
struct Unit {
  double mm;
  const char* name;
};
constexpr std::array<Unit, 6> kUnits = {{{0.1, "0.1 mm units"},
                                         {0.2, "fifths of a millimetre"},
                                         {0.25, "quarters of a millimetre"},
                                         {0.5, "half millimetres"},
                                         {10, "centimetres"},
                                         {1000, "metres"}}};
constexpr double kUsualMm = 2700;  // of the middle of a picture: people stand 2 to 2.5 m away, before a wall

std::string number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

DepthDiagnosis other_unit(double median, const UnitJudge& judge) {
  const auto unusual = [&](const Unit& unit) {
    const double ratio = median * unit.mm / kUsualMm;
    return ratio < 1 ? 1 / ratio : ratio;
  };
  const Unit* best = nullptr;
  float best_score = 0;
  for (const Unit& unit : kUnits) {
    if (median * unit.mm < kRoomMinMm || median * unit.mm > kRoomMaxMm) continue;
    const float score = judge ? judge(static_cast<float>(unit.mm)) : 0;
    const bool better =
        best == nullptr || score > best_score || (score == best_score && unusual(unit) < unusual(*best));
    if (!better) continue;
    best = &unit;
    best_score = score;
  }
  if (best == nullptr)
    return {DiagnosisCode::unit, 0, 0,
            "the middle value is " + std::to_string(static_cast<int>(median)) +
                ", expected 600 to 8000 millimetres; see --unit"};
  return {DiagnosisCode::unit, static_cast<float>(best->mm), 0,
          std::string("values look like ") + best->name + "; try --unit " + number(best->mm)};
}

// Of values that might be millimetres: another unit only where it is sure.
constexpr float kSureScore = 0.5F;
DepthDiagnosis sure_unit(double median, const UnitJudge& judge) {
  float best = 0;
  const DepthDiagnosis found = other_unit(median, [&](float unit_mm) {
    const float score = judge(unit_mm);
    best = std::max(best, score);
    return score;
  });
  return best >= kSureScore ? found : DepthDiagnosis{};
}

// Every second value is the high half of a float of millimetres (256 to 8192) or metres (0.5 to 8).
bool are_floats(DepthView depth) {
  constexpr int kMmMin = 0x4380, kMmMax = 0x4600, kMetreMin = 0x3F00, kMetreMax = 0x4100;
  for (const int first : {0, 1}) {
    std::size_t some = 0, millimetres = 0, metres = 0;
    for (int v = 0; v < depth.height; v += 2)
      for (int u = first; u < depth.width; u += 2) {
        const int value = depth.at(u, v);
        some += value != 0 ? 1 : 0;
        millimetres += value >= kMmMin && value < kMmMax ? 1 : 0;
        metres += value >= kMetreMin && value < kMetreMax ? 1 : 0;
      }
    if (some > 0 && 10 * std::max(millimetres, metres) > 9 * some) return true;
  }
  return false;
}

DepthDiagnosis other_values(const std::vector<Pair>& pairs, const UnitJudge& judge) {
  const Reading plain = read_as(pairs, [](std::uint16_t v) { return v; });
  // Eleven bits, 2047 for no answer, and disparity instead of depth: a Kinect's raw picture.
  const bool eleven_bits = share_of(pairs, [](std::uint16_t v) { return v > 2047; }) == 0;
  if (eleven_bits && share_of(pairs, [](std::uint16_t v) { return v == 2047; }) > 0.01)
    return {DiagnosisCode::raw_disparity, 0, 0,
            "values look like a Kinect's raw disparity (11 bits, 2047: no data); record depth in millimetres"};
  if (plain.is_room()) return judge && judge(1) < kSureScore ? sure_unit(plain.median, judge) : DepthDiagnosis{};
  const auto swapped = [](std::uint16_t v) { return ((v & 0xFF) << 8) | (v >> 8); };
  // Few metres or centimetres have nothing in their high byte.
  if (share_of(pairs, [](std::uint16_t v) { return v > 255; }) > 0.9 && read_as(pairs, swapped).is_room())
    return {DiagnosisCode::bytes_swapped, 0, 0,
            "bytes look swapped; PGM and PNG have the high byte first: write the files again"};
  if (share_of(pairs, [](std::uint16_t v) { return (v & 7) != 0; }) < 0.001 &&
      read_as(pairs, [](std::uint16_t v) { return v >> 3; }).is_room())
    return {DiagnosisCode::player_bits, 0.125F, 0,
            "values look shifted by three bits (a player's number below the depth); try --unit 0.125"};
  if (share_of(pairs, [](std::uint16_t v) { return v >= 0x2000; }) > 0.2 &&
      read_as(pairs, [](std::uint16_t v) { return v & 0x1FFF; }).is_room() && plain.rough > kRoughMax)
    return {DiagnosisCode::confidence_bits, 0, 0,
            "confidence bits look set above 13 bits of depth (Android's DEPTH16); clear them when recording"};
  if (plain.rough > kRoughMax)
    return {DiagnosisCode::no_depth_picture, 0, 0,
            "neighbouring values differ more than in a depth picture; is this another kind of picture?"};
  return other_unit(plain.median, judge);
}

// Mean depth of a strip an eighth of the picture wide; 0: hardly any.
double strip(DepthView depth, int u0, int u1, int v0, int v1) {
  double sum = 0;
  int count = 0, all = 0;
  for (int v = v0; v < v1; v += 2)
    for (int u = u0; u < u1; u += 2, ++all) {
      sum += depth.at(u, v);
      count += depth.at(u, v) != 0 ? 1 : 0;
    }
  return 4 * count > all ? sum / count : 0;
}

// The floor before a person is nearer than all else, along the lower edge; along another one the camera is turned.
DepthDiagnosis turned(DepthView depth) {
  const int w = depth.width, h = depth.height;
  if (w < 16 || h < 16) return {};
  const double below = strip(depth, 0, w, h - h / 8, h), above = strip(depth, 0, w, 0, h / 8);
  const double left = strip(depth, 0, w / 8, 0, h), right = strip(depth, w - w / 8, w, 0, h);
  constexpr double kNearer = 0.75;
  struct Edge {
    double near, far, others;
    int degrees;
  };
  const auto least = [](double a, double b) { return a == 0 ? b : b == 0 ? a : std::min(a, b); };
  for (const Edge& edge : {Edge{right, left, least(below, above), 90}, Edge{left, right, least(below, above), 270},
                           Edge{above, below, least(left, right), 180}})
    if (edge.near > 0 && edge.far > 0 && edge.near < kNearer * edge.far && edge.near < edge.others)
      return {DiagnosisCode::rotated, 0, edge.degrees,
              "the picture looks turned; try --rotate " + std::to_string(edge.degrees)};
  return {};
}

}  // namespace

DepthDiagnosis depth_diagnosis(DepthView depth, const UnitJudge& judge) {
  if (depth.pixels == nullptr) return {};
  if (are_floats(depth))
    return {DiagnosisCode::float_values, 0, 0,
            "values look like 32-bit floating point, read as 16-bit integers; write 16-bit millimetres"};
  const std::vector<Pair> pairs = pairs_of(depth);
  const std::size_t looked_at =
      static_cast<std::size_t>((depth.width + 1) / 2) * static_cast<std::size_t>((depth.height + 1) / 2);
  if (50 * pairs.size() < looked_at)
    return {DiagnosisCode::little_depth, 0, 0, "the last picture is nearly without depth"};
  DepthDiagnosis values = other_values(pairs, judge);
  return values.code != DiagnosisCode::none ? values : turned(depth);
}

DepthDiagnosis intrinsics_diagnosis(const Intrinsics& k) {
  if (!(k.fx > 0 && k.fy > 0) || k.width < 1 || k.height < 1) return {};
  switch (lens_fault(k)) {
    case LensFault::centre_turned:
      return {DiagnosisCode::centre, 0, 0,
              "cx and cy look like those of the picture before it was turned; give the calibration of the upright "
              "picture, or rotate the source"};
    case LensFault::field_of_view:
      return {DiagnosisCode::field_of_view, 0, 0,
              std::string("the field of view of fx and fy is ") +
                  (widest_field_deg(k) < kFieldMinDeg ? "under 25" : "over 130") +
                  " degrees; are they pixels of a picture of this size?"};
    case LensFault::none:
    case LensFault::centre_elsewhere:  // a cropped picture may have it, and people are found in it
      break;
  }
  return {};
}

}  // namespace im2fit::hal
