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
    take_depth();
    for (int v = 0; v < in_.intrinsics.height; ++v) paint_ground(v);
    if (in_.has_joints) paint_skeleton();
    paint_sections();
    paint_captions();
    return std::move(canvas_);
  }

 private:
  bool person_at(int u, int v) const { return in_.mask.pixels != nullptr && in_.mask.at(u, v) != 0; }

  // Depth in mm: fused where there is some, else the frame's; 0 = none.
  float depth_at(int u, int v) const { return depth_row(v)[u]; }
  const float* depth_row(int v) const {
    return depth_mm_.data() + static_cast<std::ptrdiff_t>(v) * in_.intrinsics.width;
  }

  void take_depth() {
    const auto& k = in_.intrinsics;
    depth_mm_.resize(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    left_ = k.width;
    top_ = k.height;
    float* out = depth_mm_.data();
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u, ++out) {
        const bool person = person_at(u, v);
        const bool fused = person && in_.fused_q4.pixels != nullptr && in_.fused_q4.at(u, v) != 0;
        const float z = fused ? static_cast<float>(in_.fused_q4.at(u, v)) / 16.0F
                              : (in_.frame.pixels != nullptr ? static_cast<float>(in_.frame.at(u, v)) : 0.0F);
        *out = z;
        if (person) {
          left_ = std::min(left_, u);
          right_ = std::max(right_, u + 1);
          top_ = std::min(top_, v);
          bottom_ = std::max(bottom_, v + 1);
        }
        if (z <= 0 || z > 10000) continue;
        near_mm_ = std::min(near_mm_, z);
        far_mm_ = std::max(far_mm_, z);
      }
  }

  static float slope(float a, float b, int step_px, float focal, float z) {
    constexpr float kStepMm = 60.0F;  // a larger jump is an edge, not a slope
    if (a <= 0 || b <= 0 || std::abs(a - b) > kStepMm || step_px <= 0) return 0.0F;
    return (b - a) * focal / (static_cast<float>(step_px) * z);
  }

  // Light from above the camera: the slope of depth over two pixels gives the normal.
  static float shade_of(float slope_x, float slope_y) {
    const Vec3f normal = normalized({slope_x, slope_y, -1.0F});
    return std::clamp(dot(normal, kLight), 0.15F, 1.0F);
  }

  Rgb ground(float z, float shade, bool person) const {
    const float nearness = 1.0F - std::clamp((z - near_mm_) / std::max(1.0F, far_mm_ - near_mm_), 0.0F, 1.0F);
    const auto grey = static_cast<std::uint8_t>(40 + 150 * (shade * (0.45F + 0.55F * nearness)));
    const Rgb ground{grey, grey, grey};
    if (!person) return ground;
    const float bright = 0.25F + 0.75F * shade;
    const auto lit = [&](std::uint8_t c) { return static_cast<std::uint8_t>(static_cast<float>(c) * bright); };
    return mixed(ground, {lit(kTint.r), lit(kTint.g), lit(kTint.b)}, 0.8F);
  }

  // A row of the frame, as `scale_` rows of the picture.
  void paint_ground(int v) {
    const auto& k = in_.intrinsics;
    const int v0 = std::max(0, v - 1), v1 = std::min(k.height - 1, v + 1);
    const float *above = depth_row(v0), *here = depth_row(v), *below = depth_row(v1);
    const std::span<Rgb> first = canvas_.row(v * scale_);
    Rgb* out = first.data();
    for (int u = 0; u < k.width; ++u) {
      Rgb colour{18, 18, 24};
      if (const float z = here[u]; z > 0) {
        const int u0 = std::max(0, u - 1), u1 = std::min(k.width - 1, u + 1);
        colour = ground(
            z, shade_of(slope(here[u0], here[u1], u1 - u0, k.fx, z), slope(above[u], below[u], v1 - v0, k.fy, z)),
            person_at(u, v));
      }
      out = std::fill_n(out, scale_, colour);
    }
    for (int i = 1; i < scale_; ++i) std::copy(first.begin(), first.end(), canvas_.row(v * scale_ + i).begin());
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
    for (int u = left_; u < right_; ++u)
      for (int v = top_; v + 1 < bottom_; ++v) {
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
  std::vector<float> depth_mm_;
  int left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // of the person, one beyond at right and bottom
  float near_mm_ = 1e9F, far_mm_ = 0;
  std::vector<Label> labels_;
};

}  // namespace

Canvas draw_overlay(const OverlayInput& input) {
  return Painter(input).paint();
}

}  // namespace im2fit
