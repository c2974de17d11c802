// SPDX-License-Identifier: Apache-2.0
// ratio 1 of the paper: the surface distance between the shoulders over the straight one. The paper does not say how
// the geodesic is found; here it is the surface line seen behind the straight line LS-RS, sampled every 1/24 of it
// (about 15 mm: shorter steps would count noise as length), averaged over about 16 x 16 mm, without its part along
// the spine: the line of sight to it is not level, and would add height that the section does not have.
#include <array>
#include <cmath>
#include <limits>

#include "perception/paper/plan.h"

namespace im2fit::paper_detail {
namespace {

constexpr int kSteps = 24;
constexpr float kPatchHalfMm = 8.0F;
constexpr int kPatchHalfPixelsMax = 8;
constexpr std::uint32_t kSurfaceQ4 = 60U * 16U;  // deeper than the patch's front by this is another surface

// The mean point of the nearest surface around a pixel; z = 0 where none is seen. Its own mean pixel goes with its
// mean depth: on a slanted surface the middle pixel's ray would lie beside it, and zigzags count as length.
Vec3f patch_point(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& k, int u, int v,
                  int half) {
  std::uint32_t nearest = 0xFFFFFFFFU;
  std::int32_t sum_z = 0, sum_u = 0, sum_v = 0, count = 0;
  const auto each = [&](auto visit) {
    for (int row = v - half; row <= v + half; ++row) {
      for (int column = u - half; column <= u + half; ++column) {
        if (row < 0 || column < 0 || row >= depth_q4.height || column >= depth_q4.width) continue;
        const std::uint32_t d = depth_q4.at(column, row);
        if (d != 0 && mask.at(column, row) != 0) visit(column, row, d);
      }
    }
  };
  each([&](int, int, std::uint32_t d) { nearest = d < nearest ? d : nearest; });
  each([&](int column, int row, std::uint32_t d) {
    if (d > nearest + kSurfaceQ4) return;
    sum_z += static_cast<std::int32_t>(d);
    sum_u += column;
    sum_v += row;
    ++count;
  });
  if (count == 0) return {};
  const auto mean = [&](std::int32_t sum) { return static_cast<float>(sum) / static_cast<float>(count); };
  return unproject(k, mean(sum_u), mean(sum_v), mean(sum_z) * (1.0F / 16.0F));
}

std::int32_t part(std::int32_t to, std::int32_t from) {
  const std::int32_t step = to - from;
  return step > INT16_MAX ? INT16_MAX : step < INT16_MIN ? INT16_MIN : step;
}

// The double root of a 32-bit number, unless whole, is 2^-17 or more from whole numbers: cutting it off is exact.
std::uint32_t nearest_root(std::uint32_t square) {
  const auto root = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(square)));
  return square - root * root > root ? root + 1 : root;
}

}  // namespace

std::uint32_t geodesic(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  std::uint32_t length = 0;
  for (int i = 1; i < count; ++i) {
    const std::int32_t dx = part(x[i], x[i - 1]), dy = part(y[i], y[i - 1]), dz = part(z[i], z[i - 1]);
    length += nearest_root(static_cast<std::uint32_t>(dx * dx) + static_cast<std::uint32_t>(dy * dy) +
                           static_cast<std::uint32_t>(dz * dz));
  }
  return length;
}

float surface_ratio(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& k,
                    const JointSet& joints) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Vec3f from = joints[Joint::LS], to = joints[Joint::RS], spine = body_frame(joints).u;
  Vec3f first, previous;
  std::array<std::int32_t, kSteps + 1> x, y, z;  // GeodesicMm raws
  int seen = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const Vec3f p = from + (to - from) * (static_cast<float>(i) / kSteps);
    if (!(p.z > 1.0F)) return kNan;
    const float u = p.x / p.z * k.fx + k.cx, v = p.y / p.z * k.fy + k.cy;
    if (!(u > -0.5F && v > -0.5F && u < static_cast<float>(k.width) - 0.5F &&
          v < static_cast<float>(k.height) - 0.5F)) {
      continue;
    }
    const float half = kPatchHalfMm * k.fx / p.z;
    const int half_pixels = half < kPatchHalfPixelsMax ? static_cast<int>(half + 0.5F) : kPatchHalfPixelsMax;
    const Vec3f seen_at =
        patch_point(depth_q4, mask, k, static_cast<int>(u + 0.5F), static_cast<int>(v + 0.5F), half_pixels);
    if (seen_at.z == 0.0F) continue;
    const Vec3f surface = seen_at - spine * dot(spine, seen_at);
    if (seen == 0) first = surface;
    previous = surface;
    const auto at = static_cast<std::size_t>(seen++);
    x[at] = GeodesicMm::from_real(double{surface.x}).raw();
    y[at] = GeodesicMm::from_real(double{surface.y}).raw();
    z[at] = GeodesicMm::from_real(double{surface.z}).raw();
  }
  const float straight = norm(previous - first);
  // Two thirds of the samples, over two thirds of the way: else it is not the chest that was seen.
  if (3 * seen < 2 * (kSteps + 1) || !(3.0F * straight > 2.0F * norm(to - from))) return kNan;
  const std::uint32_t length = geodesic(x.data(), y.data(), z.data(), seen);
  return static_cast<float>(static_cast<double>(length) / (1 << GeodesicMm::kFractionBits)) / straight;
}

}  // namespace im2fit::paper_detail
