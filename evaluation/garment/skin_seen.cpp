// SPDX-License-Identifier: Apache-2.0
#include "evaluation/garment/skin_seen.h"

#include <algorithm>
#include <cmath>

#include "report/dressed_picture.h"

namespace im2fit::lab {
namespace {

constexpr float kPixelMm = 3;
constexpr float kThroughMm = 40;  // deeper folds are rare; the cloth on the other side of a wrist is farther
constexpr int kWidth = 680, kHeight = 860;  // arms out, and up
enum : std::uint8_t { kNothing, kSkin, kCoveredSkin, kCloth };

struct Picture {
  std::vector<float> nearest = std::vector<float>(std::size_t{kWidth} * kHeight, -1e9F);
  std::vector<float> cloth = nearest;  // the nearest of the cloth alone
  std::vector<std::uint8_t> what = std::vector<std::uint8_t>(std::size_t{kWidth} * kHeight, kNothing);

  // Pixels and millimetres towards the viewer.
  void fill(Vec3f a, Vec3f b, Vec3f c, std::uint8_t kind) {
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (area == 0) return;
    const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
    const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
    const int x0 = std::max(0, static_cast<int>(std::ceil(x_low - 0.5F)));
    const int x1 = std::min(kWidth - 1, static_cast<int>(std::floor(x_high - 0.5F)));
    const int y0 = std::max(0, static_cast<int>(std::ceil(y_low - 0.5F)));
    const int y1 = std::min(kHeight - 1, static_cast<int>(std::floor(y_high - 0.5F)));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const float px = static_cast<float>(x) + 0.5F, py = static_cast<float>(y) + 0.5F;
        const float s = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
        const float t = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
        if (s < 0 || t < 0 || s + t > 1) continue;
        const float z = a.z + s * (b.z - a.z) + t * (c.z - a.z);
        const auto at = static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
        if (kind == kCloth) cloth[at] = std::max(cloth[at], z);
        if (z <= nearest[at]) continue;
        nearest[at] = z;
        what[at] = kind;
      }
  }
};

}  // namespace

std::vector<std::uint8_t> covered_skin(const body::BodyModel& model, const body::Outfit& outfit) {
  std::vector<std::uint8_t> covered(static_cast<std::size_t>(model.body_vertex_count()));
  outfit.hidden_skin(covered);
  return covered;
}

SkinSeen look_for_skin(const body::BodyModel& model, const body::Outfit& outfit,
                       std::span<const std::uint8_t> covered) {
  const auto skin = outfit.body().first(static_cast<std::size_t>(model.body_vertex_count()));
  Vec3f low = skin[0], high = skin[0];
  for (const Vec3f& p : skin) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3f middle = (low + high) * 0.5F;
  std::vector<std::vector<Vec3f>> cloth(outfit.size());
  for (std::size_t i = 0; i < outfit.size(); ++i) {
    cloth[i].resize(outfit.cloth(i).mesh().vertex_count());
    outfit.shown(i, cloth[i]);
  }
  SkinSeen seen;
  const auto hidden = covered_skin(model, outfit);
  for (const PictureView& view : {kFrontView, kLeftView, kBackView, kSlantView})
    for (const bool drawn : {false, true}) {
      Picture picture;
      const auto at = [&](Vec3f v) {
        const Vec3f p = v - middle;
        return Vec3f{kWidth / 2.0F + (view.cosine * p.x - view.sine * p.z) / kPixelMm,
                     kHeight / 2.0F - p.y / kPixelMm, view.sine * p.x + view.cosine * p.z};
      };
      for (const auto& t : model.body_triangles()) {
        const auto v = [&](std::size_t k) { return static_cast<std::size_t>(t[k]); };
        const auto all = [&](std::span<const std::uint8_t> of) {
          return of[v(0)] != 0 && of[v(1)] != 0 && of[v(2)] != 0;
        };
        if (drawn && all(hidden)) continue;
        picture.fill(at(skin[v(0)]), at(skin[v(1)]), at(skin[v(2)]), all(covered) ? kCoveredSkin : kSkin);
      }
      for (std::size_t i = 0; i < outfit.size(); ++i)
        for (const auto& t : outfit.cloth(i).mesh().triangles) {
          const auto v = [&](std::size_t k) { return cloth[i][static_cast<std::size_t>(t[k])]; };
          picture.fill(at(v(0)), at(v(1)), at(v(2)), kCloth);
        }
      int through = 0, bare = 0;
      for (std::size_t i = 0; i < picture.what.size(); ++i) {
        if (picture.what[i] != kCoveredSkin) continue;
        ++(picture.nearest[i] - picture.cloth[i] < kThroughMm ? through : bare);
      }
      if (drawn) {
        seen.drawn_px += through;
        continue;
      }
      seen.cloth_px += static_cast<int>(std::count(picture.what.begin(), picture.what.end(), kCloth));
      seen.through_px += through;
      seen.bare_px += bare;
    }
  return seen;
}

}  // namespace im2fit::lab
