// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "body_pack.h"
#include "report/vrm_avatar.h"

namespace im2fit::body {
namespace {

using Json = nlohmann::json;

std::uint32_t number_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

class Vrm : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEEDS_BODY();
    avatar_.model = real_body();
    avatar_.params.gender = 0;
    auto figure = make_figure(avatar_);
    ASSERT_TRUE(figure) << figure.error().message;
    figure_ = std::move(*figure);
    auto bytes = vrm_of(avatar_, figure_);
    ASSERT_TRUE(bytes) << bytes.error().message;
    bytes_ = std::move(*bytes);
    ASSERT_GT(bytes_.size(), 20U + number_at(bytes_, 12));
    tree_ = Json::parse(reinterpret_cast<const char*>(&bytes_[20]),
                        reinterpret_cast<const char*>(&bytes_[20]) + number_at(bytes_, 12));
  }
  // The nodes' rotations are none at rest: places are sums of translations.
  Vec3f place(std::size_t node) const {
    const auto& nodes = tree_["nodes"];
    const auto& t = nodes[node]["translation"];
    const Vec3f at = {t[0].get<float>(), t[1].get<float>(), t[2].get<float>()};
    for (std::size_t parent = 0; parent < nodes.size(); ++parent)
      for (const auto& child : nodes[parent].value("children", Json::array()))
        if (child.get<std::size_t>() == node) return at + place(parent);
    return at;
  }
  std::size_t bone(const char* name) const {
    return tree_["extensions"]["VRMC_vrm"]["humanoid"]["humanBones"][name]["node"].get<std::size_t>();
  }

  Avatar avatar_;
  Figure figure_;
  std::vector<std::byte> bytes_;
  Json tree_;
};

TEST_F(Vrm, TheFileIsAWholeGlbWithTheBonesThatVrmRequires) {
  EXPECT_EQ(number_at(bytes_, 8), bytes_.size());
  EXPECT_EQ(number_at(bytes_, 12) % 4, 0U);
  const std::size_t binary_at = 20 + number_at(bytes_, 12);
  EXPECT_EQ(binary_at + 8 + number_at(bytes_, binary_at), bytes_.size());
  EXPECT_EQ(tree_["extensionsUsed"], Json::array({"VRMC_vrm"}));
  const Json& vrm = tree_["extensions"]["VRMC_vrm"];
  EXPECT_EQ(vrm["specVersion"], "1.0");
  EXPECT_EQ(vrm["meta"]["licenseUrl"], "https://vrm.dev/licenses/1.0/");
  EXPECT_FALSE(vrm["meta"]["authors"].empty());
  // Each required bone is a descendant of the one above it.
  const std::pair<const char*, const char*> kRequired[] = {{"spine", "hips"},
                                                           {"head", "spine"},
                                                           {"leftUpperArm", "spine"},
                                                           {"leftLowerArm", "leftUpperArm"},
                                                           {"leftHand", "leftLowerArm"},
                                                           {"rightUpperArm", "spine"},
                                                           {"rightLowerArm", "rightUpperArm"},
                                                           {"rightHand", "rightLowerArm"},
                                                           {"leftUpperLeg", "hips"},
                                                           {"leftLowerLeg", "leftUpperLeg"},
                                                           {"leftFoot", "leftLowerLeg"},
                                                           {"rightUpperLeg", "hips"},
                                                           {"rightLowerLeg", "rightUpperLeg"},
                                                           {"rightFoot", "rightLowerLeg"}};
  const auto parent_of = [&](std::size_t node) {
    for (std::size_t parent = 0; parent < tree_["nodes"].size(); ++parent)
      for (const auto& child : tree_["nodes"][parent].value("children", Json::array()))
        if (child.get<std::size_t>() == node) return parent;
    return tree_["nodes"].size();
  };
  for (const auto& [below, above] : kRequired) {
    std::size_t node = bone(below);
    while (node != bone(above) && node < tree_["nodes"].size()) node = parent_of(node);
    EXPECT_EQ(node, bone(above)) << below;
  }
}

TEST_F(Vrm, ItStandsInTheTPoseFacingForwards) {
  const Vec3f hips = place(bone("hips")), head = place(bone("head"));
  for (const auto& [side, prefix] : {std::pair{1.0F, std::string("left")}, std::pair{-1.0F, std::string("right")}}) {
    const Vec3f shoulder = place(bone((prefix + "UpperArm").c_str())),
                elbow = place(bone((prefix + "LowerArm").c_str())), hand = place(bone((prefix + "Hand").c_str()));
    EXPECT_NEAR(elbow.y, shoulder.y, 1e-3) << prefix;
    EXPECT_NEAR(hand.y, shoulder.y, 1e-3) << prefix;
    EXPECT_NEAR(hand.z, shoulder.z, 1e-3) << prefix;
    EXPECT_GT(side * (hand.x - shoulder.x), 0.35F) << prefix;
  }
  EXPECT_GT(head.y, hips.y + 0.4F);
  // The mesh goes with the bones: its span is about its height, and it stands on the floor.
  const Json& position =
      tree_["accessors"][tree_["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
  const float span = position["max"][0].get<float>() - position["min"][0].get<float>(),
              height = position["max"][1].get<float>() - position["min"][1].get<float>();
  EXPECT_NEAR(span / height, 1, 0.08);
  EXPECT_NEAR(position["min"][1].get<float>(), 0, 1e-4);
  for (const auto& node : tree_["nodes"]) {
    if (node.contains("rotation")) {
      EXPECT_NEAR(std::abs(node["rotation"][3].get<float>()), 1, 1e-5);
    }
  }
}

TEST(VrmName, EndsInVrm) {
  EXPECT_TRUE(is_vrm_name("anna.vrm"));
  EXPECT_FALSE(is_vrm_name(".vrm"));
  EXPECT_FALSE(is_vrm_name("anna.glb"));
}

}  // namespace
}  // namespace im2fit::body
