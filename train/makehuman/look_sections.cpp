// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/look_sections.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "train/makehuman/hair_cap.h"
#include "train/makehuman/skin_texture.h"

namespace im2fit::body::makehuman {
namespace {

// The left eye's inner edge of its lids. MakeHuman's own eyes reach 0.93 to 1.05 times as far forward as it lies from
// their middles (base mesh, 14 faces of both sexes, three origins and two ages).
constexpr int kLidFirst = 7750;
constexpr float kEyeball = 1.0F;

Vec3f base_mm(const Source& source, int vertex) {
  const auto& p = source.base_dm[index_of(vertex)];
  return {static_cast<float>(p[0] * kMmPerDm), static_cast<float>(p[1] * kMmPerDm),
          static_cast<float>(p[2] * kMmPerDm)};
}

// Middle of a joint of eight vertices, which `record` lists as the file numbers them.
Result<Vec3f> eye_joint(const LookInput& input, const std::string& joint, std::array<std::int32_t, 8>& record) {
  const auto list = joint_vertices(input.source.rig, joint);
  if (!list) return list.error();
  if (list->size() != record.size())
    return Error{ErrorCode::corrupt, "rig: joint '" + joint + "' is not the mean of 8 vertices"};
  Vec3f sum;
  for (std::size_t i = 0; i < record.size(); ++i) {
    record[i] = input.new_index[index_of((*list)[i])];
    if (record[i] < 0) return Error{ErrorCode::corrupt, "rig: joint '" + joint + "' uses a vertex that is not kept"};
    sum = sum + base_mm(input.source, (*list)[i]);
  }
  return sum * (1.0F / static_cast<float>(record.size()));
}

// The body vertex nearest to the mirror image of another: the base mesh is symmetric.
int mirrored(const Source& source, int vertex) {
  const Vec3f p = base_mm(source, vertex), image = {-p.x, p.y, p.z};
  int best = 0;
  for (int v = 1; v < kBodyFirstHelper; ++v)
    if (norm(base_mm(source, v) - image) < norm(base_mm(source, best) - image)) best = v;
  return best;
}

Result<EyeRecord> eye_record(const LookInput& input, const std::string& bone, const SkinTextures& textures) {
  EyeRecord record;
  const auto centre = eye_joint(input, bone + ":head", record.centre);
  if (!centre) return centre.error();
  const auto front = eye_joint(input, bone + ":tail", record.front);
  if (!front) return front.error();
  for (std::size_t i = 0; i < record.rim.size(); ++i) {
    const int left = kLidFirst + static_cast<int>(i);
    record.rim[i] = bone == "eye.L" ? left : mirrored(input.source, left);
  }
  record.radius = kEyeball;
  record.texture_u = textures.eye_u;
  record.texture_v = textures.eye_v;
  record.texture_r = textures.eye_r;
  return record;
}

std::uint16_t of_unit(float c) {
  return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(c, 0.0F, 1.0F)));
}

}  // namespace

Status add_look(const LookInput& input, ContainerWriter& writer) {
  const auto faces = input.source.groups.find("body"), places = input.source.corners.find("body");
  if (faces == input.source.groups.end() || places == input.source.corners.end())
    return Error{ErrorCode::corrupt, "base mesh: no texture coordinates of group 'body'"};
  std::vector<std::array<TexturePlace, 4>> corners;
  for (const auto& face : places->second) {
    auto& quad = corners.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      const TextureCorner& place = input.source.texture[static_cast<std::size_t>(face[k])];
      quad[k] = {of_unit(place[0]), of_unit(1 - place[1])};
    }
  }
  std::vector<Vec3f> body;
  std::vector<float> arm;
  std::vector<std::uint8_t> on_head;
  for (int v = 0; v < kBodyFirstHelper; ++v) {
    body.push_back(base_mm(input.source, v));
    const SegmentWeights& weights = input.segment_weights[index_of(v)];
    double total = 1e-9, of_arm = 0;
    for (const double w : weights) total += w;
    for (const Segment s : {Segment::left_upper_arm, Segment::left_lower_arm, Segment::left_hand,
                            Segment::right_upper_arm, Segment::right_lower_arm, Segment::right_hand})
      of_arm += weights[index_of(s)];
    arm.push_back(static_cast<float>(of_arm / total));
    on_head.push_back(weights[index_of(Segment::head)] + weights[index_of(Segment::neck)] > total / 2 ? 1 : 0);
  }
  auto textures = draw_skin_textures({body, arm, faces->second, corners}, input.texture_side);
  if (!textures) return textures.error();
  std::vector<EyeRecord> eyes;
  for (const char* bone : {"eye.L", "eye.R"}) {
    const auto record = eye_record(input, bone, *textures);
    if (!record) return record.error();
    eyes.push_back(*record);
  }
  writer.add_array<std::array<TexturePlace, 4>>("look_corners", corners);
  writer.add("look_man", std::move(textures->png[0]));
  writer.add("look_woman", std::move(textures->png[1]));
  writer.add_array<EyeRecord>("look_eyes", eyes);
  const std::vector<HairRecord> hair = hair_cap(body, on_head);
  writer.add_array<HairRecord>("look_hair", hair);
  return Ok{};
}

}  // namespace im2fit::body::makehuman
