// SPDX-License-Identifier: Apache-2.0
// VRMC_vrm 1.0 (vrm-consortium, specification/VRMC_vrm-1.0): meta and humanoid.
#include "report/vrm_avatar.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

namespace im2fit {
namespace {

using body::Segment;
using Json = nlohmann::json;

// The nodes of a .glb are the segments in order.
constexpr std::pair<const char*, Segment> kHumanBones[] = {{"hips", Segment::pelvis},
                                                           {"spine", Segment::abdomen},
                                                           {"chest", Segment::chest},
                                                           {"neck", Segment::neck},
                                                           {"head", Segment::head},
                                                           {"leftShoulder", Segment::left_shoulder},
                                                           {"leftUpperArm", Segment::left_upper_arm},
                                                           {"leftLowerArm", Segment::left_lower_arm},
                                                           {"leftHand", Segment::left_hand},
                                                           {"rightShoulder", Segment::right_shoulder},
                                                           {"rightUpperArm", Segment::right_upper_arm},
                                                           {"rightLowerArm", Segment::right_lower_arm},
                                                           {"rightHand", Segment::right_hand},
                                                           {"leftUpperLeg", Segment::left_upper_leg},
                                                           {"leftLowerLeg", Segment::left_lower_leg},
                                                           {"leftFoot", Segment::left_foot},
                                                           {"rightUpperLeg", Segment::right_upper_leg},
                                                           {"rightLowerLeg", Segment::right_lower_leg},
                                                           {"rightFoot", Segment::right_foot}};

// Arms stretched out level; all else as it rests.
body::Pose t_pose(const body::Skeleton& rest) {
  body::Pose pose;
  const auto stretch = [&](Segment segment, float aside) {
    const auto s = static_cast<std::size_t>(segment);
    pose.rotation[s] = body::rotation_between(normalized(rest.tail[s] - rest.head[s]), {aside, 0, 0});
  };
  for (const Segment s : {Segment::left_upper_arm, Segment::left_lower_arm, Segment::left_hand}) stretch(s, 1);
  for (const Segment s : {Segment::right_upper_arm, Segment::right_lower_arm, Segment::right_hand}) stretch(s, -1);
  return pose;
}

constexpr std::size_t kHeadBytes = 12, kChunkHeadBytes = 8;

std::uint32_t number_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

void append(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}
void append_number(std::vector<std::byte>& out, std::size_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  append(out, std::as_bytes(std::span(&number, 1)));
}

Json vrm_extension() {
  Json bones = Json::object();
  for (const auto& [name, segment] : kHumanBones) bones[name]["node"] = static_cast<int>(segment);
  Json meta = {{"name", "im2fit avatar"}, {"licenseUrl", "https://vrm.dev/licenses/1.0/"}};
  meta["authors"].push_back("im2fit");
  Json vrm = {{"specVersion", "1.0"}, {"meta", meta}};
  vrm["humanoid"]["humanBones"] = bones;
  return vrm;
}

}  // namespace

bool is_vrm_name(const std::string& path) {
  return path.size() > 4 && path.ends_with(".vrm");
}

Result<std::vector<std::byte>> vrm_of(const body::Avatar& avatar, const body::Figure& figure) {
  std::vector<Vec3f> rest(figure.rest.size());
  body::skin(*avatar.model, figure.rest, figure.skeleton, t_pose(figure.skeleton), rest);
  const body::Avatar bare = {avatar.model, avatar.params, {}};
  const auto stretched = body::make_figure(bare, rest);
  if (!stretched) return stretched.error();
  const std::vector<std::byte> glb = body::glb_of(bare, *stretched);

  // The tree stands in the first chunk.
  const std::size_t tree_bytes = number_at(glb, kHeadBytes), tree_at = kHeadBytes + kChunkHeadBytes;
  Json tree = Json::parse(reinterpret_cast<const char*>(&glb[tree_at]),
                          reinterpret_cast<const char*>(&glb[tree_at]) + tree_bytes);
  tree["extensionsUsed"].push_back("VRMC_vrm");
  tree["extensions"]["VRMC_vrm"] = vrm_extension();
  std::string text = tree.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');

  const std::span rest_of_file = std::span(glb).subspan(tree_at + tree_bytes);
  std::vector<std::byte> out;
  append(out, std::span(glb).first(8));
  append_number(out, tree_at + text.size() + rest_of_file.size());
  append_number(out, text.size());
  append(out, std::span(glb).subspan(kHeadBytes + 4, 4));
  append(out, std::as_bytes(std::span(text)));
  append(out, rest_of_file);
  return out;
}

}  // namespace im2fit
