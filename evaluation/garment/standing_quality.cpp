// SPDX-License-Identifier: Apache-2.0
#include "evaluation/garment/standing_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "evaluation/garment/drape_quality.h"
#include "evaluation/garment/triangle_pixels.h"

namespace im2fit::lab {
namespace {

using body::Cloth;
using body::GarmentMesh;
using body::Outfit;

constexpr float kCoverReachMm = 60;  // farther cloth covers nothing: it hangs before it
constexpr float kCoverCosine = 0.2F;
constexpr float kCoverRimMm = 15;    // skin whose cloth is so near to a rim may be seen beside it
constexpr float kCrossedRimMm = 15;  // cloth so near to a rim may show its inside: the caps over openings are rough
constexpr float kMarginMm = 20;      // about the garment

enum Kind : std::uint8_t { kNothing, kSkin, kCoveredSkin, kOutside, kInside, kInsideAtRim, kCap };

class Picture {
 public:
  Picture(PictureView view, Vec3f low, Vec3f high) : view_(view), middle_((low + high) * 0.5F) {
    const Vec3f half = (high - low) * 0.5F;
    const float aside = std::sqrt(half.x * half.x + half.z * half.z) + kMarginMm;
    width_ = static_cast<int>(2 * aside / kStandingPixelMm) + 1;
    height_ = static_cast<int>(2 * (half.y + kMarginMm) / kStandingPixelMm) + 1;
    nearest_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), -1e9F);
    what_.assign(nearest_.size(), kNothing);
  }

  // `outside`: what is seen where the triangle goes anticlockwise for the viewer, else `inside`; kNothing: not drawn.
  void fill(Vec3f p, Vec3f q, Vec3f r, Kind outside, Kind inside) {
    const Vec3f a = seen(p), b = seen(q), c = seen(r);
    const Kind kind = doubled_area_px(a, b, c) < 0 ? outside : inside;
    if (kind == kNothing) return;
    for_each_pixel(width_, height_, a, b, c, [&](std::size_t at, float z) {
      if (z <= nearest_[at]) return;
      nearest_[at] = z;
      what_[at] = kind;
    });
  }

  void count(std::size_t view, StandingQuality& quality) const {
    for (std::size_t i = 0; i < what_.size(); ++i) {
      const std::uint8_t what = what_[i];
      quality.cloth_px += what == kOutside || what == kInside || what == kInsideAtRim ? 1 : 0;
      if (what != kCoveredSkin && what != kInside) continue;
      ++(what == kCoveredSkin ? quality.skin_px : quality.crossed_px);
      quality.faults.push_back({view, place(i), what == kCoveredSkin});
    }
  }

 private:
  Vec3f seen(Vec3f v) const {
    const Vec3f p = v - middle_;
    return {static_cast<float>(width_) / 2 + (view_.cosine * p.x - view_.sine * p.z) / kStandingPixelMm,
            static_cast<float>(height_) / 2 - p.y / kStandingPixelMm, view_.sine * p.x + view_.cosine * p.z};
  }
  Vec3f place(std::size_t i) const {
    const auto column = static_cast<int>(i % static_cast<std::size_t>(width_)),
               row = static_cast<int>(i / static_cast<std::size_t>(width_));
    const float x = (static_cast<float>(column) + 0.5F - static_cast<float>(width_) / 2) * kStandingPixelMm;
    const float y = (static_cast<float>(height_) / 2 - static_cast<float>(row) - 0.5F) * kStandingPixelMm;
    return middle_ +
           Vec3f{view_.cosine * x + view_.sine * nearest_[i], y, view_.cosine * nearest_[i] - view_.sine * x};
  }

  PictureView view_;
  Vec3f middle_;
  int width_ = 0, height_ = 0;
  std::vector<float> nearest_;
  std::vector<std::uint8_t> what_;
};

// Vertices of cloth that follow one another lie near each other: a box about each few of them.
struct Box {
  static constexpr std::size_t kVertices = 32;
  Vec3f low{1e9F, 1e9F, 1e9F}, high{-1e9F, -1e9F, -1e9F};
  float squared_to(Vec3f p) const {
    const float x = std::max({low.x - p.x, p.x - high.x, 0.0F}), y = std::max({low.y - p.y, p.y - high.y, 0.0F}),
                z = std::max({low.z - p.z, p.z - high.z, 0.0F});
    return x * x + y * y + z * z;
  }
};

std::vector<Box> boxes_of(const Cloth& cloth) {
  std::vector<Box> boxes;
  for (std::size_t c = 0; c < cloth.mesh().vertex_count(); ++c) {
    if (c % Box::kVertices == 0) boxes.emplace_back();
    const Vec3f p = cloth.position(c);
    Box& box = boxes.back();
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return boxes;
}

// 1 for each of the body's vertices that the garment should cover and that pictures do not leave out.
std::vector<std::uint8_t> covered(const body::BodyModel& model, const Outfit& outfit, const Cloth& cloth,
                                  std::span<const std::uint8_t> hidden, Vec3f low, Vec3f high) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(model.body_vertex_count()));
  const std::vector<Box> boxes = boxes_of(cloth);
  const body::BodySurface& skin = outfit.skin();
  for (const std::int32_t v : skin.vertices()) {
    const auto i = static_cast<std::size_t>(v);
    const Vec3f p = outfit.body()[i], n = skin.normal(true)[i];
    const bool far = p.x < low.x - kCoverReachMm || p.x > high.x + kCoverReachMm || p.y < low.y - kCoverReachMm ||
                     p.y > high.y + kCoverReachMm || p.z < low.z - kCoverReachMm || p.z > high.z + kCoverReachMm;
    if (far) continue;
    if (hidden[i] != 0) {
      out[i] = 1;
      continue;
    }
    // An arm beside the trunk is covered by its sleeve alone.
    const bool arm = (skin.limbs(v) & body::kTrunk) == 0 && (skin.limbs(v) & (body::kLeftArm | body::kRightArm)) != 0;
    float best = kCoverReachMm * kCoverReachMm;
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      if (boxes[b].squared_to(p) >= best) continue;
      const std::size_t end = std::min(cloth.mesh().vertex_count(), (b + 1) * Box::kVertices);
      for (std::size_t c = b * Box::kVertices; c < end; ++c) {
        const Vec3f d = cloth.position(c) - p;
        const float squared = dot(d, d);
        if (squared >= best || (cloth.limbs(c) & skin.limbs(v)) == 0 || dot(cloth.normals()[c], n) < kCoverCosine)
          continue;
        best = squared;
        const bool sleeve = !arm || (cloth.limbs(c) & body::kTrunk) == 0;
        out[i] = sleeve && cloth.mesh().rim_mm[c] > kCoverRimMm ? 1 : 0;
      }
    }
  }
  return out;
}

void judge_hems(const GarmentMesh& mesh, std::span<const Rim> rims, std::span<const Vec3f> places,
                StandingQuality& quality) {
  std::size_t points = 0, level = 0;
  for (const Rim& rim : rims) {
    std::vector<Vec3f> hem;
    std::vector<std::size_t> vertices;
    for (const std::int32_t v : rim.vertices) {
      const auto at = static_cast<std::size_t>(v);
      if ((mesh.border[at] & body::kOnHem) == 0) continue;
      hem.push_back(places[at]);
      vertices.push_back(at);
    }
    if (hem.size() < 8 || 2 * hem.size() < rim.vertices.size()) continue;  // a neck or waist with a hem's corner
    const std::vector<float> above = above_plane_mm(hem);
    for (std::size_t i = 0; i < above.size(); ++i) {
      ++points;
      level += std::fabs(above[i]) <= kHemOffMm ? 1U : 0U;
      quality.hem_off_mm = std::max(quality.hem_off_mm, std::fabs(above[i]));
      quality.hem_points.push_back({mesh.flat[vertices[i]], mesh.layer[vertices[i]], above[i]});
    }
  }
  quality.hem_share = points > 0 ? static_cast<float>(level) / static_cast<float>(points) : 1;
}

}  // namespace

PictureView standing_view(std::size_t view) {
  constexpr float k = 0.70710678F;
  constexpr std::array<PictureView, kStandingViews> views = {
      {{1, 0}, {k, k}, {0, 1}, {-k, k}, {-1, 0}, {-k, -k}, {0, -1}, {k, -k}}};
  return views[view];
}

// Least squares of the height over x and z, both from their means.
std::vector<float> above_plane_mm(const std::vector<Vec3f>& points) {
  Vec3f mean{};
  for (const Vec3f& p : points) mean = mean + p * (1 / static_cast<float>(points.size()));
  double xx = 0, xz = 0, zz = 0, xy = 0, zy = 0;
  for (const Vec3f& p : points) {
    const Vec3f d = p - mean;
    const double x = d.x, y = d.y, z = d.z;
    xx += x * x;
    xz += x * z;
    zz += z * z;
    xy += x * y;
    zy += z * y;
  }
  const double area = xx * zz - xz * xz;
  const double a = area > 0 ? (xy * zz - zy * xz) / area : 0, b = area > 0 ? (zy * xx - xy * xz) / area : 0;
  const double upright = 1 / std::sqrt(1 + a * a + b * b);
  std::vector<float> above;
  for (const Vec3f& p : points) {
    const Vec3f d = p - mean;
    above.push_back(static_cast<float>(
        (static_cast<double>(d.y) - a * static_cast<double>(d.x) - b * static_cast<double>(d.z)) * upright));
  }
  return above;
}

StandingQuality judge_standing(const body::BodyModel& model, const Outfit& outfit, std::size_t index) {
  const Cloth& cloth = outfit.cloth(index);
  const GarmentMesh& mesh = cloth.mesh();
  std::vector<Vec3f> places(mesh.vertex_count());
  outfit.shown(index, places);
  Vec3f low = places[0], high = low;
  for (const Vec3f& p : places) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(model.body_vertex_count()));
  outfit.hidden_skin(hidden);
  const auto skin = outfit.body().first(hidden.size());
  const auto cover = covered(model, outfit, cloth, hidden, low, high);

  StandingQuality quality;
  quality.rim_mm = rim_roughness_mm(mesh, places);
  const std::vector<Rim> rims = rims_of(mesh);
  judge_hems(mesh, rims, places, quality);
  for (std::size_t view = 0; view < kStandingViews; ++view) {
    Picture picture(standing_view(view), low, high);
    for (const auto& t : model.body_triangles()) {
      const auto v = [&](std::size_t k) { return static_cast<std::size_t>(t[k]); };
      if (hidden[v(0)] != 0 && hidden[v(1)] != 0 && hidden[v(2)] != 0) continue;
      const bool all = cover[v(0)] != 0 && cover[v(1)] != 0 && cover[v(2)] != 0;
      picture.fill(skin[v(0)], skin[v(1)], skin[v(2)], all ? kCoveredSkin : kSkin, kNothing);
    }
    for (const auto& t : mesh.triangles) {
      const auto v = [&](std::size_t k) { return static_cast<std::size_t>(t[k]); };
      const float rim = std::min({mesh.rim_mm[v(0)], mesh.rim_mm[v(1)], mesh.rim_mm[v(2)]});
      picture.fill(places[v(0)], places[v(1)], places[v(2)], kOutside, rim > kCrossedRimMm ? kInside : kInsideAtRim);
    }
    // Openings, closed: what lies behind is seen through them.
    for (const Rim& rim : rims) {
      Vec3f middle{};
      for (const std::int32_t v : rim.vertices)
        middle = middle + places[static_cast<std::size_t>(v)] * (1 / static_cast<float>(rim.vertices.size()));
      for (std::size_t i = 0; i < rim.vertices.size(); ++i)
        picture.fill(middle, places[static_cast<std::size_t>(rim.vertices[i])],
                     places[static_cast<std::size_t>(rim.vertices[(i + 1) % rim.vertices.size()])], kCap, kCap);
    }
    picture.count(view, quality);
  }
  return quality;
}

}  // namespace im2fit::lab
