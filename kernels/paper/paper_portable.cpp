// SPDX-License-Identifier: Apache-2.0
// The paper's measurements in fixed point.
//
// Scaling: coordinates Q21.10 mm, unit axes Q1.30, their products Q22.9 mm; section points in 1/8 mm, at most 512 mm
// from the section's centre, summed exactly in 64 bits.
#include <cmath>
#include <limits>

#include "kernels/paper/plan.h"

namespace im2fit {
namespace {

using paper_detail::kEpsilonInverseSquared;
using Axis = Fixed<std::int32_t, 30>;
using ProductMm = decltype(Axis() * CoordinateMm());  // Q22.9
using SectionMm = Fixed<std::int32_t, 3>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

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
    work_.rays.set(k);
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
  void gather_sections(const std::array<Vec3f, kPaperSectionCount>& centres);
  float girth(std::size_t section, float z_mm) const;

  ImageView<const std::uint16_t> depth_;
  MaskView mask_;
  const Intrinsics& k_;
  const JointSet& joints_;
  const BodyFrame& frame_;
  PaperWorkspace& work_;
};

// Eq. (3). Among several contour points of the top or bottom row the one nearest to the axis counts.
float Measurer::stature() {
  const FixedPoint3 torso = fixed_point(joints_[Joint::TO]);
  const FixedAxis lateral = fixed_axis(frame_.v);
  FixedPoint3 top, bottom;
  int top_row = -1, bottom_row = -1;
  for (int v = 0; v < depth_.height; ++v) {
    ProductMm best = ProductMm::from_raw(std::numeric_limits<std::int32_t>::max());
    FixedPoint3 nearest;
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
    if (best.raw() == std::numeric_limits<std::int32_t>::max()) continue;
    if (top_row < 0) {
      top_row = v;
      top = nearest;
    }
    bottom_row = v;
    bottom = nearest;
  }
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

void Measurer::gather_sections(const std::array<Vec3f, kPaperSectionCount>& centres_mm) {
  // Across the section: v made perpendicular to u, and w.
  const FixedAxis up = fixed_axis(frame_.u), across = fixed_axis(cross(frame_.w, frame_.u)),
                  depth = fixed_axis(frame_.w);
  // A point of the section is at most sqrt(2) * 512 mm from its centre, a tenth of that off its plane.
  const ProductMm off_plane_max = ProductMm::from_real(0.1 * 1.4143 * paper_detail::kSectionHalfMm);
  std::array<FixedPoint3, kPaperSectionCount> centres;
  std::array<ProductMm, kPaperSectionCount> heights;
  std::array<std::int64_t, kPaperSectionCount> counts{};
  for (std::size_t s = 0; s < kPaperSectionCount; ++s) {
    centres[s] = fixed_point(centres_mm[s]);
    heights[s] = along(up, centres[s]);
    work_.sections[s].fill(EllipseSums());
  }
  for (int v = 0; v < depth_.height; ++v) {
    const std::uint16_t* depths = depth_.row(v);
    const std::uint8_t* masks = mask_.row(v);
    for (int u = 0; u < depth_.width; ++u) {
      if (masks[u] == 0 || depths[u] == 0) continue;
      const FixedPoint3 p = work_.rays.point(u, v, depths[u], 4);
      const ProductMm height = along(up, p);
      for (std::size_t s = 0; s < kPaperSectionCount; ++s) {
        const ProductMm off_plane = height - heights[s];
        if (off_plane > off_plane_max || off_plane < -off_plane_max) continue;
        const FixedPoint3 d = p - centres[s];
        if (!nearly_perpendicular(off_plane, d)) continue;
        const std::int32_t x = rescale<SectionMm::kFractionBits>(along(across, d)).raw();
        const std::int32_t y = rescale<SectionMm::kFractionBits>(along(depth, d)).raw();
        if (std::abs(x) > EllipseSums::kCoordinateMax || std::abs(y) > EllipseSums::kCoordinateMax) continue;
        if (counts[s] == EllipseSums::kPointsMax) continue;
        ++counts[s];
        constexpr int kUnitsPerBin = paper_detail::kBinMm << SectionMm::kFractionBits;
        const int bin = (x + paper_detail::kSectionHalfMm * (1 << SectionMm::kFractionBits)) / kUnitsPerBin;
        work_.sections[s][static_cast<std::size_t>(bin)].add(x, y);
      }
    }
  }
}

float Measurer::girth(std::size_t section, float z_mm) const {
  const auto& bins = work_.sections[section];
  const auto bin = [&](int b) -> const EllipseSums& { return bins[static_cast<std::size_t>(b)]; };
  const paper_detail::BinRange range = paper_detail::connected_bins(
      paper_detail::hole_bins(z_mm, k_.fx), [&](int b) { return bin(b).count(); },
      [&](int b) {
        constexpr double kUnit = 1.0 / (1 << SectionMm::kFractionBits);
        return static_cast<double>(bin(b).sum_y()) / static_cast<double>(bin(b).count()) * kUnit;
      });
  EllipseSums sums;
  for (int b = range.first; b <= range.last; ++b) sums.add(bin(b));
  const Ellipse ellipse = fit_ellipse(sums);
  return ellipse.valid ? static_cast<float>(ellipse.perimeter() / (1 << SectionMm::kFractionBits)) : kNan;
}

std::array<float, kPaperSectionCount> Measurer::girths() {
  const auto centres = paper_detail::section_centres(joints_);
  gather_sections(centres);
  std::array<float, kPaperSectionCount> out;
  for (std::size_t s = 0; s < kPaperSectionCount; ++s) out[s] = girth(s, centres[s].z);
  return out;
}

}  // namespace

PaperMeasurements measure_paper_portable(ImageView<const std::uint16_t> depth_q4, MaskView mask,
                                         const Intrinsics& intrinsics, const JointSet& joints, PaperWorkspace& work) {
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

PaperMeasurements measure_paper(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                                const JointSet& joints, PaperWorkspace& work) {
  return measure_paper_portable(depth_q4, mask, intrinsics, joints, work);
}

}  // namespace im2fit
