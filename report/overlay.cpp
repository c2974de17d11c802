// SPDX-License-Identifier: Apache-2.0
#include "report/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "report/drawn_bones.h"

namespace im2fit {
namespace {

constexpr int kWantedHeight = 1200;
const Vec3f kLight = normalized({-0.35F, -0.55F, -1.0F});
constexpr Rgb kTint{96, 170, 255};
constexpr Rgb kBone{255, 255, 255};
constexpr Rgb kLeft{255, 120, 90};
constexpr Rgb kRight{90, 230, 130};
constexpr Rgb kMiddle{255, 220, 80};
constexpr Rgb kInk{240, 240, 240};
constexpr Rgb kSectionColours[] = {{255, 90, 160}, {255, 180, 60}, {120, 240, 240}, {200, 140, 255}, {180, 255, 110}};

class Painter {
 public:
  explicit Painter(const OverlayInput& input)
      : in_(input),
        scale_(std::max(1, kWantedHeight / std::max(1, input.intrinsics.height))),
        canvas_(input.intrinsics.width * scale_, input.intrinsics.height * scale_) {}

  Canvas paint() {
    find_range();
    for (int v = 0; v < in_.intrinsics.height; ++v)
      for (int u = 0; u < in_.intrinsics.width; ++u)
        canvas_.rectangle(u * scale_, v * scale_, scale_, scale_, ground_at(u, v));
    if (in_.has_joints) paint_skeleton();
    paint_sections();
    paint_captions();
    return std::move(canvas_);
  }

 private:
  bool person_at(int u, int v) const { return in_.mask.pixels != nullptr && in_.mask.at(u, v) != 0; }

  // Depth in mm: fused where there is some, else the frame's; 0 = none.
  float depth_at(int u, int v) const {
    if (in_.fused_q4.pixels != nullptr && person_at(u, v) && in_.fused_q4.at(u, v) != 0)
      return static_cast<float>(in_.fused_q4.at(u, v)) / 16.0F;
    return in_.frame.pixels != nullptr ? static_cast<float>(in_.frame.at(u, v)) : 0.0F;
  }

  void find_range() {
    for (int v = 0; v < in_.intrinsics.height; ++v)
      for (int u = 0; u < in_.intrinsics.width; ++u) {
        const float z = depth_at(u, v);
        if (z <= 0 || z > 10000) continue;
        near_mm_ = std::min(near_mm_, z);
        far_mm_ = std::max(far_mm_, z);
      }
  }

  // Light from above the camera: the slope of depth over two pixels gives the normal.
  float shade_at(int u, int v) const {
    const auto& k = in_.intrinsics;
    const int u0 = std::max(0, u - 1);
    const int u1 = std::min(k.width - 1, u + 1);
    const int v0 = std::max(0, v - 1);
    const int v1 = std::min(k.height - 1, v + 1);
    const float z = depth_at(u, v);
    const auto slope = [&](float a, float b, float step_px, float focal) {
      constexpr float kStepMm = 60.0F;  // a larger jump is an edge, not a slope
      if (a <= 0 || b <= 0 || std::abs(a - b) > kStepMm || step_px <= 0) return 0.0F;
      return (b - a) * focal / (step_px * z);
    };
    const float sx = slope(depth_at(u0, v), depth_at(u1, v), static_cast<float>(u1 - u0), k.fx);
    const float sy = slope(depth_at(u, v0), depth_at(u, v1), static_cast<float>(v1 - v0), k.fy);
    const Vec3f normal = normalized({sx, sy, -1.0F});
    return std::clamp(dot(normal, kLight), 0.15F, 1.0F);
  }

  Rgb ground_at(int u, int v) const {
    const float z = depth_at(u, v);
    if (z <= 0) return {18, 18, 24};
    const float nearness = 1.0F - std::clamp((z - near_mm_) / std::max(1.0F, far_mm_ - near_mm_), 0.0F, 1.0F);
    const float shade = shade_at(u, v);
    const auto grey = static_cast<std::uint8_t>(40 + 150 * (shade * (0.45F + 0.55F * nearness)));
    const Rgb ground{grey, grey, grey};
    if (!person_at(u, v)) return ground;
    const float bright = 0.25F + 0.75F * shade;
    const auto lit = [&](std::uint8_t c) { return static_cast<std::uint8_t>(static_cast<float>(c) * bright); };
    return mixed(ground, {lit(kTint.r), lit(kTint.g), lit(kTint.b)}, 0.8F);
  }

  std::pair<float, float> project(Vec3f p) const {
    const auto& k = in_.intrinsics;
    if (p.z <= 1) return {NAN, NAN};
    const auto s = static_cast<float>(scale_);
    return {(p.x * k.fx / p.z + k.cx + 0.5F) * s, (p.y * k.fy / p.z + k.cy + 0.5F) * s};
  }

  void paint_skeleton() {
    const float unit = static_cast<float>(canvas_.height()) / 400.0F;
    for (const auto& [from, to, coloured_as] : kDrawnBones) {
      const auto [x0, y0] = project(in_.joints[from]);
      const auto [x1, y1] = project(in_.joints[to]);
      canvas_.line(x0, y0, x1, y1, 1.6F * unit, {0, 0, 0}, 0.5F);
      canvas_.line(x0, y0, x1, y1, unit, kBone, 0.9F);
    }
    for (const Joint joint : kJointOrder) {
      const auto [x, y] = project(in_.joints[joint]);
      canvas_.disc(x, y, 2.6F * unit, {0, 0, 0}, 0.6F);
      canvas_.disc(x, y, 2.0F * unit, is_left(joint) ? kLeft : is_right(joint) ? kRight : kMiddle);
    }
  }

  float height_of(int u, int v, float z) const {
    const Vec3f p = unproject(in_.intrinsics, static_cast<float>(u), static_cast<float>(v), z);
    return dot(in_.floor.up, p) + in_.floor.camera_height_mm;
  }

  // A section is where the seen surface crosses its height: between a pixel and the one below it.
  void paint_section(const SectionLine& section, Rgb colour) {
    const auto& k = in_.intrinsics;
    const float unit = static_cast<float>(canvas_.height()) / 400.0F;
    const Vec3f middle = (in_.joints[Joint::NE] + in_.joints[Joint::TO]) * 0.5F;
    float right_x = -1;
    float right_y = 0;
    for (int u = 0; u < k.width; ++u)
      for (int v = 0; v + 1 < k.height; ++v) {
        if (!person_at(u, v) || !person_at(u, v + 1)) continue;
        const float z = depth_at(u, v);
        const float z_below = depth_at(u, v + 1);
        if (z <= 0 || z_below <= 0 || height_of(u, v, z) < section.height_mm ||
            height_of(u, v + 1, z_below) >= section.height_mm)
          continue;
        const float x_mm = unproject(k, static_cast<float>(u), static_cast<float>(v), z).x;
        if (std::abs(x_mm - middle.x) > section.half_width_mm) continue;
        const auto s = static_cast<float>(scale_);
        const float x = (static_cast<float>(u) + 0.5F) * s;
        const float y = (static_cast<float>(v) + 1.0F) * s;
        canvas_.disc(x, y, 0.9F * unit, colour);
        if (x > right_x) right_x = x, right_y = y;
      }
    if (right_x >= 0) labels_.push_back({section.label, colour, right_x, right_y});
  }

  void paint_sections() {
    if (!in_.floor.known || !in_.has_joints) return;
    std::size_t colour = 0;
    for (const auto& section : in_.sections)
      paint_section(section, kSectionColours[colour++ % std::size(kSectionColours)]);
    std::sort(labels_.begin(), labels_.end(), [](const Label& a, const Label& b) { return a.y < b.y; });
    const int scale = std::max(1, canvas_.height() / 480);
    int lowest = 0;  // labels do not overlap: each is pushed below the one before
    for (const Label& label : labels_) {
      const int width = Canvas::text_width(label.text, scale);
      const int height = Canvas::text_height(scale);
      const int x = canvas_.width() - width - 4 * scale;
      const int y = std::max(lowest, static_cast<int>(label.y) - height / 2);
      lowest = y + height + 4 * scale;
      const int middle = y + height / 2;
      canvas_.line(label.x, label.y, static_cast<float>(x - 2 * scale), static_cast<float>(middle),
                   static_cast<float>(scale) * 0.6F, label.colour, 0.7F);
      plate(x, y, label.text, scale, label.colour);
    }
  }

  void plate(int x, int y, const std::string& words, int scale, Rgb colour) {
    canvas_.rectangle(x - 2 * scale, y - 2 * scale, Canvas::text_width(words, scale) + 3 * scale,
                      Canvas::text_height(scale) + 4 * scale, {0, 0, 0}, 0.65F);
    canvas_.text(x, y, words, scale, colour);
  }

  void paint_captions() {
    const int scale = std::max(1, canvas_.height() / 480);
    int y = 5 * scale;
    for (const auto& caption : in_.captions) {
      plate(5 * scale, y, caption, scale, kInk);
      y += Canvas::text_height(scale) + 4 * scale;
    }
  }

  struct Label {
    std::string text;
    Rgb colour;
    float x = 0, y = 0;
  };
  const OverlayInput& in_;
  int scale_;
  Canvas canvas_;
  float near_mm_ = 1e9F, far_mm_ = 0;
  std::vector<Label> labels_;
};

}  // namespace

Canvas draw_overlay(const OverlayInput& input) {
  return Painter(input).paint();
}

}  // namespace im2fit
