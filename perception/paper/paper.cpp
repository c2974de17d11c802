// SPDX-License-Identifier: Apache-2.0
// The paper's measurements in fixed point.
//
// Scaling: coordinates Q21.10 mm, unit axes Q1.30, their products Q22.9 mm; sections as kernels/section, sums as
// ellipse.h.
#include "perception/paper/paper.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "perception/paper/plan.h"

namespace im2fit {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

BodyFrame body_frame(const JointSet& joints) {
  BodyFrame frame;
  if (!paper_detail::usable_joints(joints)) return frame;
  const Vec3f u = normalized(joints[Joint::TO] - joints[Joint::NE]);
  const Vec3f v = normalized(joints[Joint::RS] - joints[Joint::LS]);
  const Vec3f w = normalized(cross(u, v));
  if (!(norm(w) > 0.5F)) return frame;
  frame.u = u, frame.v = v, frame.w = w;
  const Vec3f d = normalized((joints[Joint::LH] + joints[Joint::RH]) * 0.5F - joints[Joint::TO]);
  if (!(norm(d) > 0.5F)) return frame;
  frame.lateral = norm(cross(u, d));  // sqrt(1 - (u.d)^2) without its cancellation
  frame.upright = frame.lateral < kUprightMax && dot(u, d) > 0;
  return frame;
}

PaperWorkspace::PaperWorkspace(int width, int height)
    : rays(width, height),
      spine(width, height),
      across(width, height),
      depth(width, height),
      point_capacity(std::min(kMomentPointsMax, width * height)),
      points(kPaperSectionCount * static_cast<std::size_t>(point_capacity + kSectionSlack)) {}

MeasurementValues to_values(const PaperMeasurements& m) {
  MeasurementValues values;
  values.fill(kNan);
  if (!m.valid) return values;
  const auto set = [&](Measurement id, float value) { values[measurement_index(id)] = value; };
  set(Measurement::stature, m.stature_mm);
  set(Measurement::sleeve_length, m.sleeve_mm);
  set(Measurement::leg_length, m.leg_mm);
  set(Measurement::shoulder_breadth, m.shoulder_mm);
  set(Measurement::neck_girth, m.neck_mm);
  set(Measurement::shoulder_girth, m.shoulder_girth_mm);
  set(Measurement::chest_girth, m.chest_mm);
  set(Measurement::waist_girth, m.waist_mm);
  set(Measurement::hip_girth, m.hip_mm);
  return values;
}

namespace paper_detail {

void set_girths(const std::array<float, kPaperSectionCount>& girths_mm, PaperMeasurements& m) {
  m.neck_mm = girths_mm[0];
  m.shoulder_girth_mm = girths_mm[1];
  m.chest_mm = girths_mm[2];
  m.waist_mm = girths_mm[3];
  m.hip_mm = girths_mm[4];
  m.hip_waist_ratio = m.hip_mm / m.waist_mm;
}

PaperMeasurements unmeasured() {
  PaperMeasurements m;
  m.stature_mm = m.sleeve_mm = m.leg_mm = m.shoulder_mm = m.chest_ratio = kNan;
  set_girths({kNan, kNan, kNan, kNan, kNan}, m);
  return m;
}

}  // namespace paper_detail
namespace {

using paper_detail::kEpsilonInverseSquared;
using Axis = Fixed<std::int32_t, 30>;
using ProductMm = decltype(Axis() * CoordinateMm());  // Q22.9

struct FixedAxis {
  Axis x, y, z;
};
FixedAxis fixed_axis(Vec3f a) {
  return {Axis::from_real(a.x), Axis::from_real(a.y), Axis::from_real(a.z)};
}
FixedPoint3 fixed_point(Vec3f p) {
  return {CoordinateMm::from_real(p.x), CoordinateMm::from_real(p.y), CoordinateMm::from_real(p.z)};
}
FixedPoint3 operator-(FixedPoint3 a, FixedPoint3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
ProductMm along(const FixedAxis& a, FixedPoint3 p) {
  return a.x * p.x + a.y * p.y + a.z * p.z;
}
auto squared_length(FixedPoint3 p) {
  return wide_product(p.x, p.x) + wide_product(p.y, p.y) + wide_product(p.z, p.z);
}
CoordinateMm length(FixedPoint3 p) {
  return square_root(squared_length(p));
}
float real(CoordinateMm value) {
  return static_cast<float>(value.real());
}

// |projection| / |d| < 1/10. The projection's square has 18 fraction bits, the length's 20.
bool nearly_perpendicular(ProductMm projection, FixedPoint3 d) {
  const std::int64_t square = wide_product(projection, projection).raw();
  return 4 * kEpsilonInverseSquared * square < squared_length(d).raw();
}

class Measurer {
 public:
  Measurer(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& k, const JointSet& joints,
           const BodyFrame& frame, PaperWorkspace& work)
      : depth_(depth_q4), mask_(mask), k_(k), joints_(joints), frame_(frame), work_(work) {
    set_camera(work_.rays, k);
  }

  float stature();
  void sleeve_and_leg(PaperMeasurements& m) const;
  std::array<float, kPaperSectionCount> girths();

 private:
  bool on_contour(int u, int v) const {
    return u == 0 || v == 0 || u == mask_.width - 1 || v == mask_.height - 1 || mask_.at(u - 1, v) == 0 ||
           mask_.at(u + 1, v) == 0 || mask_.at(u, v - 1) == 0 || mask_.at(u, v + 1) == 0;
  }
  CoordinateMm distance(Joint a, Joint b) const { return length(fixed_point(joints_[a]) - fixed_point(joints_[b])); }
  // The contour point of row v nearest to the axis, of those that count; false where there is none.
  bool nearest_on_contour(int v, const FixedAxis& lateral, FixedPoint3 torso, FixedPoint3& nearest) const;
  void collect_sections(const std::array<Vec3f, kPaperSectionCount>& centres, int* counts);
  float girth(const SectionPoint* points, int count, float z_mm) const;

  ImageView<const std::uint16_t> depth_;
  MaskView mask_;
  const Intrinsics& k_;
  const JointSet& joints_;
  const BodyFrame& frame_;
  PaperWorkspace& work_;
};

bool empty(const std::uint8_t* mask, int width) {
  int u = 0;
  for (; u + 8 <= width; u += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, mask + u, 8);
    if (eight != 0) return false;
  }
  for (; u < width; ++u)
    if (mask[u] != 0) return false;
  return true;
}

bool Measurer::nearest_on_contour(int v, const FixedAxis& lateral, FixedPoint3 torso, FixedPoint3& nearest) const {
  if (empty(mask_.row(v), mask_.width)) return false;
  ProductMm best = ProductMm::from_raw(std::numeric_limits<std::int32_t>::max());
  for (int u = 0; u < depth_.width; ++u) {
    if (mask_.at(u, v) == 0 || depth_.at(u, v) == 0 || !on_contour(u, v)) continue;
    const FixedPoint3 p = work_.rays.point(u, v, depth_.at(u, v), 4);
    const FixedPoint3 d = p - torso;
    ProductMm side = along(lateral, d);
    if (!nearly_perpendicular(side, d)) continue;
    if (side < ProductMm()) side = -side;
    if (side < best) {
      best = side;
      nearest = p;
    }
  }
  return best.raw() != std::numeric_limits<std::int32_t>::max();
}

// Eq. (3). Among several contour points of the top or bottom row the one nearest to the axis counts.
float Measurer::stature() {
  const FixedPoint3 torso = fixed_point(joints_[Joint::TO]);
  const FixedAxis lateral = fixed_axis(frame_.v);
  FixedPoint3 top, bottom;
  int top_row = 0, bottom_row = depth_.height - 1;
  while (top_row < depth_.height && !nearest_on_contour(top_row, lateral, torso, top)) ++top_row;
  while (bottom_row > top_row && !nearest_on_contour(bottom_row, lateral, torso, bottom)) --bottom_row;
  return top_row < bottom_row ? real(length(bottom - top)) : kNan;
}

void Measurer::sleeve_and_leg(PaperMeasurements& m) const {
  using enum Joint;
  const CoordinateMm sleeves =
      distance(LA, LE) + distance(LE, LS) + distance(LS, NE) + distance(RA, RE) + distance(RE, RS) + distance(RS, NE);
  const CoordinateMm legs = distance(LH, LK) + distance(LK, LF) + distance(RH, RK) + distance(RK, RF);
  m.sleeve_mm = 0.5F * real(sleeves);
  m.leg_mm = 0.5F * real(legs);
  m.shoulder_mm = real(distance(LS, RS));
}

void Measurer::collect_sections(const std::array<Vec3f, kPaperSectionCount>& centres_mm, int* counts) {
  // Across the section: v made perpendicular to u, and w.
  const Vec3f across = cross(frame_.w, frame_.u);
  work_.spine.set(work_.rays, frame_.u);
  work_.across.set(work_.rays, across);
  work_.depth.set(work_.rays, frame_.w);
  std::array<SectionCut, kPaperSectionCount> cuts;
  for (std::size_t s = 0; s < kPaperSectionCount; ++s) {
    cuts[s] = {form_offset(double{dot(frame_.u, centres_mm[s])}), form_offset(double{dot(across, centres_mm[s])}),
               form_offset(double{dot(frame_.w, centres_mm[s])})};
  }
  const SectionScan scan = {depth_,
                            mask_,
                            work_.spine.columns(),
                            work_.spine.rows(),
                            work_.across.columns(),
                            work_.across.rows(),
                            work_.depth.columns(),
                            work_.depth.rows(),
                            cuts.data(),
                            static_cast<int>(cuts.size())};
  section(scan, work_.points.data(), work_.point_capacity, counts);
}

float Measurer::girth(const SectionPoint* points, int count, float z_mm) const {
  struct Bin {
    std::int32_t count = 0, sum_y = 0;  // 32767 * 4095 < 2^27
  };
  std::array<Bin, PaperWorkspace::kBinCount> bins{};
  for (int i = 0; i < count; ++i) {
    Bin& bin = bins[static_cast<std::size_t>((points[i].x - paper_detail::kFirstUnit) / paper_detail::kUnitsPerBin)];
    ++bin.count;
    bin.sum_y += points[i].y;
  }
  const auto bin = [&](int b) -> const Bin& { return bins[static_cast<std::size_t>(b)]; };
  const paper_detail::BinRange range = paper_detail::connected_bins(
      paper_detail::hole_bins(z_mm, k_.fx), [&](int b) { return bin(b).count; },
      [&](int b) {
        constexpr double kUnit = 1.0 / (1 << SectionMm::kFractionBits);
        return static_cast<double>(bin(b).sum_y) / static_cast<double>(bin(b).count) * kUnit;
      });
  if (range.last < range.first) return kNan;
  EllipseSums sums;
  const int first = paper_detail::kFirstUnit + range.first * paper_detail::kUnitsPerBin;
  const int last = paper_detail::kFirstUnit + (range.last + 1) * paper_detail::kUnitsPerBin - 1;
  moments(points, count, first, last, sums.sum.data());
  const Ellipse ellipse = fit_ellipse(sums);
  return ellipse.valid ? static_cast<float>(ellipse.perimeter() / (1 << SectionMm::kFractionBits)) : kNan;
}

std::array<float, kPaperSectionCount> Measurer::girths() {
  const auto centres = paper_detail::section_centres(joints_);
  std::array<int, kPaperSectionCount> counts;
  collect_sections(centres, counts.data());
  std::array<float, kPaperSectionCount> out;
  for (std::size_t s = 0; s < kPaperSectionCount; ++s) {
    const std::size_t at = s * static_cast<std::size_t>(work_.point_capacity + kSectionSlack);
    out[s] = girth(work_.points.data() + at, counts[s], centres[s].z);
  }
  return out;
}

}  // namespace

PaperMeasurements measure_paper(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                                const JointSet& joints, PaperWorkspace& work) {
  PaperMeasurements m = paper_detail::unmeasured();
  const BodyFrame frame = body_frame(joints);
  if (!(norm(frame.w) > 0)) return m;
  Measurer measurer(depth_q4, mask, intrinsics, joints, frame, work);
  m.stature_mm = measurer.stature();
  measurer.sleeve_and_leg(m);
  paper_detail::set_girths(measurer.girths(), m);
  m.chest_ratio = paper_detail::surface_ratio(depth_q4, mask, intrinsics, joints);
  m.valid = !std::isnan(m.stature_mm);
  return m;
}

}  // namespace im2fit
