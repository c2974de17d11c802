// SPDX-License-Identifier: Apache-2.0
// What a .i2b file holds, as views into its bytes (layout: docs/formats-body.md). For the files of this folder, for
// exporters and for renderers that dress the body; everyone else uses model.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/look.h"
#include "body/model.h"
#include "body/shape_space.h"
#include "body/start_bodies.h"
#include "core/file.h"
#include "kernels/blend/blend.h"
#include "kernels/skin/skin.h"

namespace im2fit::body {

inline constexpr std::string_view kBodyMagic = "I2BD";
inline constexpr std::uint32_t kBodyVersion = 3;
inline constexpr int kBodyVertexCount = 13380;  // MakeHuman's base mesh; helpers follow
inline constexpr std::size_t kTargetCountMax = 1024;
inline constexpr std::size_t kModifierCountMax = 1024;
inline constexpr float kDeltaUnitMm = 0.1F;    // one step of a stored target delta
inline constexpr float kModifierLimit = 2.0F;  // local modifiers are limited to +-this: the fatness set reaches 1.6

// The factors whose products weigh the macro targets (docs/makehuman.md, "Macro combination").
enum class Factor : std::uint8_t {
  male,
  female,
  young,
  old,
  african,
  asian,
  caucasian,
  muscle_min,
  muscle_average,
  muscle_max,
  weight_min,
  weight_average,
  weight_max,
  height_min,
  height_max,
  proportions_uncommon,
  proportions_ideal,
  cup_min,
  cup_average,
  cup_max,
  firmness_min,
  firmness_average,
  firmness_max,
};
inline constexpr std::size_t kFactorCount = 23;
inline constexpr std::uint8_t kNoFactor = 0xFF;

// Records of the file, little-endian.
struct TargetRecord {  // a range of runs
  std::uint32_t first_run = 0;
  std::uint32_t run_count = 0;
};
using RunRecord = BlendRun;
struct MacroRecord {
  std::uint16_t target = 0;
  std::array<std::uint8_t, 6> factors = {kNoFactor, kNoFactor, kNoFactor, kNoFactor, kNoFactor, kNoFactor};
};
struct ModifierRecord {  // targets of the negative and of the positive side, -1 for none; two for joined pairs
  std::array<std::int16_t, 2> low = {-1, -1};
  std::array<std::int16_t, 2> high = {-1, -1};
};
using im2fit::SkinRecord;
struct ListRecord {  // a joint: the plain mean of these vertices
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

// Vertices with a name. Acromion: the skin above and 20 mm outwards of the shoulder joint in the base mesh.
enum class Landmark : std::uint8_t {
  left_nipple,
  right_nipple,
  crotch,
  navel,
  c7,
  left_acromion,
  right_acromion,
};
inline constexpr std::size_t kLandmarkCount = 7;

// Joint lists in the file: heads of the 19 segments, their tails, then OpenNI's fifteen.
inline constexpr std::size_t kHeadLists = 0;
inline constexpr std::size_t kTailLists = kSegmentCount;
inline constexpr std::size_t kOpenNiLists = 2 * static_cast<std::size_t>(kSegmentCount);
inline constexpr std::size_t kListCount = kOpenNiLists + kJointCount;

struct BodyModel::Data {
  MappedFile mapped;
  std::vector<std::byte> owned;

  std::span<const Vec3f> base;  // mm
  std::span<const std::array<std::int32_t, 4>> quads;
  std::span<const std::array<std::int32_t, 4>> tights_quads;  // a shell 3-11 mm outside the body, for garments
  std::span<const std::array<std::int32_t, 4>> skirt_quads;
  std::span<const TargetRecord> targets;
  std::span<const RunRecord> runs;
  std::span<const std::int16_t> deltas;
  std::span<const MacroRecord> macros;
  std::span<const ModifierRecord> modifiers;
  std::span<const SkinRecord> skin;
  std::span<const ListRecord> lists;
  std::span<const std::int32_t> list_vertices;
  std::span<const std::int32_t> landmarks;

  Look look;
  ShapeSpace shape_space;
  StartBodies starts;
  std::vector<std::string> modifier_names;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::uint32_t> body_run_count;  // of each target: its runs from the first on that reach the body
  std::vector<std::uint8_t> triangle_is_arm;  // 1: arm (not shoulder) weight >= .5 on average

  std::int32_t landmark(Landmark l) const { return landmarks[static_cast<std::size_t>(l)]; }
};

Vec3f mean_of_list(const BodyModel::Data& data, std::size_t list, std::span<const Vec3f> vertices);

}  // namespace im2fit::body
