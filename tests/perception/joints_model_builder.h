// SPDX-License-Identifier: Apache-2.0
// Small joint models written by hand, whose answers are known in closed form.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/container.h"
#include "core/joints.h"

namespace im2fit::test {

// The records of docs/tracker.md, spelt out here so that the test does not share the code under test.
struct MetaRecord {
  std::uint32_t forest_trees = 2, jumps = 6, levels = 2, level_trees = 3, pixels = 4, side_trees = 0,
                person_trees = 1;
};
struct NodeRecord {
  std::int16_t a = 0, b = 0, c = 0, d = 0, threshold = 0;
  std::uint16_t left = 0;
};
struct AnchorRecord {
  std::int16_t dx = 0, dy = 0;
  std::uint8_t joint = 0, towards = 0;
  std::int16_t share_q8 = 0;
};
struct SplitRecord {
  std::uint16_t a = 0, b = 1;
  std::int16_t threshold = 0;
};
struct BinRecord {
  std::uint16_t spread = 0, chance = 0;
};

struct ModelRecords {
  MetaRecord meta;
  std::vector<std::uint32_t> tree;
  std::vector<NodeRecord> node;
  std::vector<std::int16_t> bone;
  std::vector<AnchorRecord> anchor;
  std::vector<SplitRecord> split;
  std::vector<std::int8_t> leaf;
  std::vector<float> basis;
  std::vector<BinRecord> bin;
  std::vector<AnchorRecord> side_anchor;
  std::vector<SplitRecord> side_split;
  std::vector<std::int16_t> side_leaf;
  std::vector<AnchorRecord> person_anchor;
  std::vector<SplitRecord> person_split;
  std::vector<std::int16_t> person_leaf;
  std::string provenance = "by hand";

  std::vector<std::byte> bytes(std::uint32_t version = 4) const {
    ContainerWriter w("I2TR", version);
    w.add_array<MetaRecord>("meta", std::span(&meta, 1));
    w.add_array<std::uint32_t>("tree", tree);
    w.add_array<NodeRecord>("node", node);
    w.add_array<std::int16_t>("bone", bone);
    w.add_array<AnchorRecord>("anchor", anchor);
    w.add_array<SplitRecord>("split", split);
    w.add_array<std::int8_t>("leaf", leaf);
    w.add_array<float>("basis", basis);
    w.add_array<BinRecord>("confidence", bin);
    w.add_array<AnchorRecord>("side anchor", side_anchor);
    w.add_array<SplitRecord>("side split", side_split);
    w.add_array<std::int16_t>("side leaf", side_leaf);
    w.add_array<AnchorRecord>("somebody anchor", person_anchor);
    w.add_array<SplitRecord>("somebody split", person_split);
    w.add_array<std::int16_t>("somebody leaf", person_leaf);
    w.add_array<char>("provenance", provenance);
    return w.finish();
  }
};

// Every tree of the forest is one leaf: each jump moves by (jx, jy, jz) mm. Bones are zero. The cascade's leaves are
// first coefficients are all `leaf`, and that coefficient's unit is 1 mm along every axis of every joint. Confidence:
// 0.75 up to 500 mm of spread, then 0.25. A person, with log-odds of 8, has a person_score above 0.7; others
// have -8.
inline ModelRecords constant_model(std::int16_t jx, std::int16_t jy, std::int16_t jz, std::int8_t leaf) {
  ModelRecords m;
  const std::size_t trees = kJointCount * m.meta.forest_trees;
  for (std::size_t t = 0; t <= trees; ++t) m.tree.push_back(static_cast<std::uint32_t>(t));
  m.node.assign(trees, NodeRecord{jx, jy, jz, 0, 0, 0});
  m.bone.assign(kJointCount * 3, 0);
  m.anchor.assign(m.meta.levels * m.meta.pixels, AnchorRecord{});
  m.split.assign(m.meta.levels * m.meta.level_trees * 31, SplitRecord{});
  m.leaf.assign(m.meta.levels * m.meta.level_trees * 32 * 32, 0);
  for (std::size_t i = 0; i < m.leaf.size(); i += 32) m.leaf[i] = leaf;
  m.basis.assign(m.meta.levels * 32 * 45, 0);
  for (std::size_t l = 0; l < m.meta.levels; ++l)
    std::fill_n(m.basis.begin() + static_cast<std::ptrdiff_t>(l * 32 * 45), 45, 1.0F);
  for (std::size_t j = 0; j < kJointCount; ++j)
    for (std::uint16_t b = 0; b < 12; ++b)
      m.bin.push_back(
          {static_cast<std::uint16_t>(b < 11 ? 500 : 65535), static_cast<std::uint16_t>(b < 11 ? 49151 : 16384)});
  m.person_anchor.assign(m.meta.pixels, AnchorRecord{});
  constexpr std::uint16_t kZeroClue = 0, kPersonScoreClue = 2;
  const auto clue = [&](std::uint16_t c) { return static_cast<std::uint16_t>(m.meta.pixels + c); };
  m.person_split.assign(31, SplitRecord{clue(kPersonScoreClue), clue(kZeroClue), 2867});  // of 4096
  m.person_leaf.assign(32, -8 * 256);
  m.person_leaf[31] = 8 * 256;
  return m;
}

}  // namespace im2fit::test
