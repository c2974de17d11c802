// SPDX-License-Identifier: Apache-2.0
// Pictures of meshes as they look in daylight, from several sides: bodies in clothes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/look.h"
#include "core/status.h"
#include "core/vec3.h"
#include "garment/drape/outfit.h"
#include "report/canvas.h"

namespace im2fit {

// A picture laid on a surface, decoded from PNG.
class Texture {
 public:
  // At most body::kTextureSideMax pixels a side. Errors: corrupt.
  static Result<Texture> decode(std::span<const std::byte> png);
  // Linear light, 0..1, between the four nearest pixels. `u`, `v`: 0..1, v downwards; beyond, the edge goes on.
  std::array<float, 3> at(float u, float v) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::uint8_t> rgb_;
};

using LinearColour = std::array<float, 3>;  // 0..1, linear light

struct PictureMesh {
  std::span<const Vec3f> positions, normals;  // mm, y up, +z to the viewer of the first view
  std::span<const std::array<std::int32_t, 3>> triangles;
  LinearColour colour{};
  std::span<const LinearColour> colours;   // a vertex each; empty: `colour`
  std::span<const std::uint8_t> left_out;  // a vertex each: 1, triangles of three such are not drawn; empty: all are
  bool two_sided = false;                  // the inside is drawn too, darker
  std::span<const body::TextureCoordinate> coordinates =
      {};  // a vertex each, with `texture`, whose colours are then the mesh's
  const Texture* texture = nullptr;
};

struct PictureView {
  float cosine = 1, sine = 0;  // of the turn about the upright axis: front 1, 0; from the person's left 0, 1
};
inline constexpr PictureView kFrontView{1, 0}, kSlantView{0.70710678F, 0.70710678F}, kLeftView{0, 1},
    kBackView{-1, 0};

struct PictureFrame {
  int width = 260, height = 560;  // pixels, of a view
  float low_mm = -60, high_mm = 1900;
  float middle_x_mm = 0, middle_z_mm = 0;
};
// The views side by side.
Canvas draw_meshes(std::span<const PictureMesh> meshes, std::span<const PictureView> views,
                   const PictureFrame& frame);

// A body in clothes as its last frame ended, hidden skin left out. `colours`: a garment each. Eyes, hair and the
// skin's texture are those of the body file; without them the skin has one colour.
Canvas draw_outfit(const body::BodyModel& model, const body::Outfit& outfit, body::LookOf whose,
                   std::span<const LinearColour> colours, std::span<const PictureView> views,
                   const PictureFrame& frame);

}  // namespace im2fit
