// SPDX-License-Identifier: Apache-2.0
// draw_preview of overlay.h: sampled at the picture's own size, so that a terminal's hundred columns and a PNG come
// from the same strokes.
#include <algorithm>
#include <array>
#include <cmath>

#include "report/drawn_bones.h"
#include "report/overlay.h"

namespace im2fit {
namespace {

constexpr float kNearMm = 500.0F;  // brightness is absolute: a range fitted to each frame would flicker
constexpr float kFarMm = 5000.0F;
constexpr float kEdgeMm = 80.0F;  // a larger step of depth is an edge, not a slope
constexpr int kSlopeReachPx = 4;
constexpr int kSmallHeightPx = 320;  // below it an outline would be all there is of an arm
constexpr Rgb kNothing{16, 16, 22};
constexpr Rgb kTint{96, 150, 235};
constexpr Rgb kOutline{150, 225, 255};
constexpr Rgb kOrange{255, 170, 110};
constexpr Rgb kViolet{235, 140, 255};
constexpr Rgb kMiddle{245, 245, 245};
constexpr Rgb kInk{240, 240, 240};
constexpr Rgb kDimInk{150, 150, 150};

Rgb colour_of(Joint j) {
  return is_left(j) ? kOrange : is_right(j) ? kViolet : kMiddle;
}

// Red at 0, yellow at one half, green at 1.
Rgb colour_of(float confidence) {
  const float c = std::clamp(confidence, 0.0F, 1.0F);
  const auto ramp = [](float x) {
    return static_cast<std::uint8_t>(60 + std::lround(195 * std::clamp(x, 0.0F, 1.0F)));
  };
  return {ramp(2 - 2 * c), ramp(2 * c), 60};
}

class PreviewPainter {
 public:
  PreviewPainter(const PreviewInput& input, int height_px)
      : in_(input),
        scale_(static_cast<float>(height_px) / static_cast<float>(std::max(1, input.intrinsics.height))),
        canvas_(std::max(1, static_cast<int>(std::lround(static_cast<float>(input.intrinsics.width) * scale_))),
                std::max(1, height_px)),
        unit_(std::max(0.4F, static_cast<float>(canvas_.height()) / 320.0F)) {}

  Canvas paint(bool text) {
    for (int y = 0; y < canvas_.height(); ++y)
      for (int x = 0; x < canvas_.width(); ++x) canvas_.set(x, y, ground_at(x, y));
    if (in_.mask.pixels != nullptr) paint_outline();
    if (in_.has_joints) paint_skeleton();
    if (text) {
      paint_ids();
      paint_captions();
    }
    return std::move(canvas_);
  }

 private:
  int column(int x) const {
    return std::clamp(static_cast<int>((static_cast<float>(x) + 0.5F) / scale_), 0, in_.intrinsics.width - 1);
  }
  int row(int y) const {
    return std::clamp(static_cast<int>((static_cast<float>(y) + 0.5F) / scale_), 0, in_.intrinsics.height - 1);
  }
  float depth_at(int x, int y) const { return static_cast<float>(in_.depth.at(column(x), row(y))); }
  bool person_at(int x, int y) const {
    return x >= 0 && y >= 0 && x < canvas_.width() && y < canvas_.height() && in_.mask.at(column(x), row(y)) != 0;
  }

  // Light from the upper left, by the slope of depth over a few pixels: a single step of the sensor's depth is not a
  // slope.
  float light_at(int x, int y, float z) const {
    const auto reach = std::max(kSlopeReachPx, static_cast<int>(1.0F / scale_));
    const int u = column(x);
    const int v = row(y);
    const auto slope = [&](int u0, int v0, int u1, int v1, float focal_px) {
      const auto before = static_cast<float>(in_.depth.at(u0, v0));
      const auto after = static_cast<float>(in_.depth.at(u1, v1));
      const int step_px = u1 - u0 + v1 - v0;
      if (std::abs(before - z) > kEdgeMm || std::abs(after - z) > kEdgeMm || step_px == 0) return 0.0F;
      return (after - before) * focal_px / (static_cast<float>(step_px) * z);
    };
    const float sx =
        slope(std::max(0, u - reach), v, std::min(in_.intrinsics.width - 1, u + reach), v, in_.intrinsics.fx);
    const float sy =
        slope(u, std::max(0, v - reach), u, std::min(in_.intrinsics.height - 1, v + reach), in_.intrinsics.fy);
    return std::clamp(dot(normalized({sx, sy, -1.0F}), normalized({-0.35F, -0.55F, -1.0F})), 0.2F, 1.0F);
  }

  Rgb ground_at(int x, int y) const {
    const float z = depth_at(x, y);
    if (z <= 0) return kNothing;
    const float light = light_at(x, y, z);
    if (in_.mask.pixels != nullptr && person_at(x, y)) {
      const auto lit = [&](std::uint8_t c) { return static_cast<std::uint8_t>(static_cast<float>(c) * light); };
      return {lit(kTint.r), lit(kTint.g), lit(kTint.b)};
    }
    const float nearness = 1.0F - std::clamp((z - kNearMm) / (kFarMm - kNearMm), 0.0F, 1.0F);
    const auto grey = static_cast<std::uint8_t>(30 + 140 * light * (0.3F + 0.7F * nearness));
    return {grey, grey, grey};
  }

  void paint_outline() {
    for (int y = 0; y < canvas_.height(); ++y)
      for (int x = 0; x < canvas_.width(); ++x)
        if (person_at(x, y) &&
            !(person_at(x - 1, y) && person_at(x + 1, y) && person_at(x, y - 1) && person_at(x, y + 1)))
          canvas_.set(x, y, kOutline, canvas_.height() < kSmallHeightPx ? 0.35F : 1.0F);
  }

  std::pair<float, float> project(Vec3f p) const {
    const Intrinsics& k = in_.intrinsics;
    if (!(p.z > 1)) return {NAN, NAN};
    return {(p.x * k.fx / p.z + k.cx + 0.5F) * scale_, (p.y * k.fy / p.z + k.cy + 0.5F) * scale_};
  }

  bool inferred(Joint j) const { return (in_.inferred & joint_bit(joint_index(j))) != 0; }

  void paint_skeleton() {
    for (const auto& [from, to, coloured_as] : kDrawnBones) {
      const auto [x0, y0] = project(in_.joints[from]);
      const auto [x1, y1] = project(in_.joints[to]);
      const bool guess = inferred(from) || inferred(to);
      canvas_.line(x0, y0, x1, y1, 2.2F * unit_, {0, 0, 0}, 0.5F);
      canvas_.line(x0, y0, x1, y1, std::max(1.0F, 1.2F * unit_), colour_of(coloured_as), guess ? 0.45F : 1.0F);
    }
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto [x, y] = project(in_.joints.position_mm[j]);
      const Rgb colour = colour_of(in_.joints.confidence[j]);
      canvas_.disc(x, y, 3.2F * unit_, {0, 0, 0}, 0.7F);
      canvas_.disc(x, y, 2.5F * unit_, colour);
      if ((in_.inferred & joint_bit(j)) != 0) canvas_.disc(x, y, 1.5F * unit_, {0, 0, 0});
    }
  }

  int text_scale() const { return std::max(1, canvas_.height() / 400); }

  void plate(int x, int y, const std::string& words, Rgb colour) {
    const int scale = text_scale();
    canvas_.rectangle(x - 2 * scale, y - 2 * scale, Canvas::text_width(words, scale) + 3 * scale,
                      Canvas::text_height(scale) + 4 * scale, {0, 0, 0}, 0.65F);
    canvas_.text(x, y, words, scale, colour);
  }

  void paint_ids() {
    for (const User& user : in_.users) {
      if (user.id <= 0) continue;
      const int x = static_cast<int>(static_cast<float>(user.u_min + user.u_max) * 0.5F * scale_);
      const int y = static_cast<int>(static_cast<float>(user.v_min) * scale_) - Canvas::text_height(text_scale());
      plate(x, std::max(2 * text_scale(), y), std::to_string(user.id),
            user.id == in_.measured_user ? kOutline : kDimInk);
    }
  }

  void paint_captions() {
    const int scale = text_scale();
    int y = 5 * scale;
    for (const std::string& caption : in_.captions) {
      plate(5 * scale, y, caption, kInk);
      y += Canvas::text_height(scale) + 4 * scale;
    }
  }

  const PreviewInput& in_;
  float scale_;
  Canvas canvas_;
  float unit_;
};

}  // namespace

Canvas draw_preview(const PreviewInput& input, int height_px, bool text) {
  return PreviewPainter(input, height_px).paint(text);
}

}  // namespace im2fit
