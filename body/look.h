// SPDX-License-Identifier: Apache-2.0
// How a body looks: texture coordinates of its skin, the texture, eyes and hair (docs/formats-body.md). All of it
// lies beside the mesh that is measured and changes nothing of it: eyes stand on joints of the rig, hair on the skin.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "body/skeleton.h"
#include "core/status.h"
#include "core/vec3.h"
#include "kernels/skin/skin.h"

namespace im2fit {
class ContainerReader;
}

namespace im2fit::body {

class BodyModel;

// Records of the file, little-endian.
struct TexturePlace {  // 65535: 1; v downwards, as glTF has it
  std::uint16_t u = 0, v = 0;
};
struct EyeRecord {                                // lists of vertices: what counts is their means
  std::array<std::int32_t, 8> centre{}, front{};  // the eyeball's middle, a point it looks at
  std::array<std::int32_t, 22> rim{};             // the lids' inner edge, which touches the eyeball
  float radius = 0;                               // of the rim's mean distance from the middle
  float texture_u = 0, texture_v = 0;             // the pupil in the texture
  float texture_r = 0;                            // how far the eyeball, 75 degrees aside, reaches there
};
struct HairRecord {
  std::uint16_t vertex = 0;  // of the body
  std::uint16_t above = 0;   // bit 0: stands above the skin in a man's hair, bit 1: in a woman's; bit 2: kHairOverEar
  std::array<std::array<std::int16_t, 3>, 2> offset{};  // kHairUnitMm, from the vertex, head upright; man, woman
};
inline constexpr float kHairUnitMm = 0.01F;
// Of HairRecord::above: a woman's hair lies here evenly between the hair about it, whatever folds the skin has.
inline constexpr std::uint16_t kHairOverEar = 4;
inline constexpr int kTextureSideMin = 16, kTextureSideMax = 2048;  // pixels

// Views into a body file; empty where it has none.
struct Look {
  std::span<const std::array<TexturePlace, 4>> corners;  // of each quad of the body
  std::array<std::span<const std::byte>, 2> texture;     // PNG, square, RGB: a man's, a woman's
  std::span<const EyeRecord> eyes;                       // left, right
  std::span<const HairRecord> hair;                      // by ascending vertex
  bool empty() const { return corners.empty(); }
};
// The look of a parsed body file, checked; an empty one when the file has no section look_corners.
Result<Look> read_look(const ContainerReader& reader, std::size_t vertex_count, std::size_t quad_count,
                       const std::string& what);

// The body file `pack` without these sections and the start bodies: the part that trackers and indexes depend on.
// Errors: as a body file's.
Result<std::vector<std::byte>> shape_only(std::span<const std::byte> pack, const std::string& what);

enum class LookOf : std::uint8_t { man, woman };
LookOf look_of(float gender);  // Params::gender

struct TextureCoordinate {
  float u = 0, v = 0;  // 0..1, v downwards
};
// A surface to draw or to write: as many normals (unit), vertices and skin weights as positions. `texture` is empty
// where the body file has no look.
struct LookPart {
  std::vector<Vec3f> positions, normals;
  std::vector<TextureCoordinate> texture;
  std::vector<SkinRecord> skin;
  std::vector<std::array<std::int32_t, 4>> quads;
};
// `vertices`: the model's, at rest or posed. Where two texture coordinates meet at a vertex a copy of it follows the
// body's own, which come first in their order; `body_vertex` says whose copy each is.
struct SkinPart : LookPart {
  std::vector<std::int32_t> body_vertex;
};
SkinPart skin_part(const BodyModel& model, std::span<const Vec3f> vertices);
// Both eyeballs, as far as lids can show them. Empty without a look.
LookPart eyes_part(const BodyModel& model, std::span<const Vec3f> vertices);
// `head`: how the head is turned from rest. Empty without a look.
LookPart hair_part(const BodyModel& model, std::span<const Vec3f> vertices, const Mat3f& head, LookOf whose);

// Unit normals, area-weighted over the quads; one a vertex of `vertices`, up where no face touches it.
std::vector<Vec3f> vertex_normals(std::span<const Vec3f> vertices,
                                  std::span<const std::array<std::int32_t, 4>> quads);

}  // namespace im2fit::body
