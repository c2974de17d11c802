// SPDX-License-Identifier: Apache-2.0
// Changes of a rest mesh that no slider makes: at which height landmarks lie, and how broad, deep and angular
// sections are. With them a body has the proportions of measured people (train/population/proportions.h); MakeHuman's
// own trunks are rounder.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "core/vec3.h"

namespace im2fit::body {

class BodyModel;

enum class WarpValue : unsigned char {
  // How much higher a landmark lies, as a share of the stature. Floor and crown stay.
  knee_rise,
  crotch_rise,
  navel_rise,
  nipple_rise,
  shoulder_rise,
  neck_rise,
  head_rise,  // of the skull's base
  // Factors less one, each smoothly less away from its level. Front and back: depth before and behind the middle.
  // Square: how much farther out the four corners of a section lie.
  hip_breadth,
  hip_front,
  hip_back,
  hip_square,
  waist_breadth,
  waist_front,
  waist_back,
  waist_square,
  chest_breadth,
  chest_front,
  chest_back,
  chest_square,
  shoulder_breadth,
  neck_girth,
  head_breadth,
  head_length,
  thigh_girth,
  calf_girth,
  deltoid_girth,  // of the upper arm at its top
  upper_arm_girth,
  forearm_girth,
  // Factors less one of lengths.
  upper_arm_length,
  forearm_length,
};
inline constexpr std::size_t kWarpCount = 30;
// As the enum spells them; result.json names them so.
inline constexpr std::array<std::string_view, kWarpCount> kWarpNames = {
    "knee_rise",    "crotch_rise",      "navel_rise",      "nipple_rise",   "shoulder_rise",    "neck_rise",
    "head_rise",    "hip_breadth",      "hip_front",       "hip_back",      "hip_square",       "waist_breadth",
    "waist_front",  "waist_back",       "waist_square",    "chest_breadth", "chest_front",      "chest_back",
    "chest_square", "shoulder_breadth", "neck_girth",      "head_breadth",  "head_length",      "thigh_girth",
    "calf_girth",   "deltoid_girth",    "upper_arm_girth", "forearm_girth", "upper_arm_length", "forearm_length"};

struct Warp {
  std::array<float, kWarpCount> values{};
  float& operator[](WarpValue v) { return values[static_cast<std::size_t>(v)]; }
  float operator[](WarpValue v) const { return values[static_cast<std::size_t>(v)]; }
  bool is_none() const { return values == decltype(values){}; }
};

// Heights of the landmarks the warp moves, rest mesh, mm; rising from the floor on.
struct WarpLandmarks {
  float floor = 0, knee = 0, crotch = 0, buttock = 0, navel = 0, nipple = 0, shoulder = 0, neck = 0, head = 0,
        crown = 0;
};
WarpLandmarks warp_landmarks(const BodyModel& model, std::span<const Vec3f> rest);

// How the trunk's level section at one height is changed: the values of a WarpValue group.
struct SectionWarp {
  float breadth = 0, front = 0, back = 0, square = 0;
};
// The section before: its middle, where front and back part, and half its extents. x = 0 is the body's middle.
struct SectionFrame {
  float middle_z = 0, half_breadth = 100, half_depth = 100;
};
SectionFrame section_frame(const BodyModel& model, std::span<const Vec3f> rest, float y);
// How far a point of the section moves; level.
Vec3f section_move(const SectionWarp& warp, const SectionFrame& frame, Vec3f p);

// Changes a rest mesh of model.vertex_count() vertices, joints' and garments' helpers included. + - * / and sqrt
// only, so the mesh has the same bits on every machine. No allocation.
void apply_warp(const BodyModel& model, const Warp& warp, std::span<Vec3f> rest);

// Where some vertices of that mesh would be then. No allocation.
void warp_vertices(const BodyModel& model, const Warp& warp, std::span<const Vec3f> rest,
                   std::span<const std::int32_t> vertices, std::span<Vec3f> out);

// How far a value of 1 moves each of some vertices of a rest mesh without a warp: vertex by vertex, kWarpCount each.
// A warp's moves are linear in its values. No allocation.
void warp_slopes(const BodyModel& model, std::span<const Vec3f> rest, std::span<const std::int32_t> vertices,
                 std::span<Vec3f> out);

}  // namespace im2fit::body
