// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/rng.h"
#include "perception/joints/model_data.h"
#include "perception/joints/tracker.h"
#include "perception/joints/view.h"
#include "tests/perception/joints_board.h"
#include "tests/perception/joints_model_builder.h"

namespace im2fit {
namespace {

using test::Board;
using test::constant_model;
using test::ModelRecords;

JointModel parse(const std::vector<std::byte>& bytes) {
  auto model = JointModel::parse(bytes, "model");
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return std::move(*model);
}

TEST(JointTracker, JumpsAndCascadeAddUp) {
  const auto bytes = constant_model(10, -20, 30, 1).bytes();
  const JointModel model = parse(bytes);
  const JointSet j = Board().track(model);
  // Six jumps, the mean of the last three stands: 5 jumps from the board's centre (0, 0, 2000). The neck starts
  // where the torso ended, the head where the neck did. The cascade adds 2 levels x 3 trees x 1 mm. In the mirror the
  // same model goes as far to the other side.
  const auto expect = [&](Joint name, float jumps) {
    EXPECT_NEAR(j[name].x, 0, 0.01) << kJointNames[joint_index(name)];
    EXPECT_NEAR(j[name].y, -20 * jumps + 6, 0.01) << kJointNames[joint_index(name)];
    EXPECT_NEAR(j[name].z, 2000 + 30 * jumps + 6, 0.01) << kJointNames[joint_index(name)];
  };
  expect(Joint::TO, 5);
  expect(Joint::NE, 10);
  expect(Joint::HE, 15);
  expect(Joint::LE, 20);
  expect(Joint::LA, 25);
  expect(Joint::LF, 20);
}

TEST(JointTracker, ForestSplitsOnDepthDifference) {
  ModelRecords m = constant_model(0, 0, 0, 0);
  // The torso's trees: depth 200 mm to the right of the point minus depth at the point. On the board both are equal
  // (0 > 100 is false: left child, 7 down); beside it nothing is there (1000 > 100: right child, 9 down).
  m.node.clear();
  m.tree.clear();
  for (std::size_t t = 0; t < kJointCount * 2; ++t) {
    m.tree.push_back(static_cast<std::uint32_t>(m.node.size()));
    if (t / 2 == joint_index(Joint::TO)) {
      m.node.push_back({static_cast<std::int16_t>(t % 2 == 0 ? 100 : 200), 0, 0, 0, 100, 1});
      m.node.push_back({0, 7, 0, 0, 0, 0});
      m.node.push_back({0, 9, 0, 0, 0, 0});
    } else {
      m.node.push_back({});
    }
  }
  m.tree.push_back(static_cast<std::uint32_t>(m.node.size()));
  m.meta.jumps = 1;
  const auto bytes = m.bytes();
  const JointModel model = parse(bytes);
  // The board reaches 20 px = 139 mm to either side: 100 mm is on it, 200 mm is not. One half of the trees says 7,
  // the other 9, all of them 8: the median.
  EXPECT_NEAR(Board().track(model)[Joint::TO].y, 8, 0.01);
}

TEST(JointTracker, CascadeSplitsOnAnchorDifference) {
  ModelRecords m = constant_model(0, 0, 0, 0);
  m.meta.levels = 1;
  m.meta.level_trees = 1;
  // Anchor 0 on the board, anchor 1 beside it (reads 600). 0 - 600 > t is false, 600 - 0 > t is true.
  m.anchor = {{0, 0, 2}, {400, 0, 2}, {0, 0, 0}, {0, 0, 0}};
  m.split.assign(31, {0, 1, 0});
  m.split[0] = {1, 0, 500};  // right at the root, left below it: node 2, 5, 11, 23 and leaf 47 - 31 = 16
  m.leaf.assign(32 * 32, 0);
  m.leaf[16 * 32 + 3] = 40;
  m.basis.assign(32 * 45, 0);
  m.basis[3 * 45 + 4] = 0.25F;  // y of the neck, 40 units of 1/4 mm
  const auto bytes = m.bytes();
  const JointModel model = parse(bytes);
  const JointSet j = Board().track(model);
  EXPECT_NEAR(j[Joint::NE].y, 10, 0.01);
  EXPECT_NEAR(j[Joint::TO].y, 0, 0.01);
}

TEST(JointTracker, AnAnchorBetweenTwoJointsFollowsBoth) {
  ModelRecords m = constant_model(0, 0, 0, 0);
  m.bone[3 * joint_index(Joint::NE)] = 800;  // the neck starts 400 mm right of the torso, beside the board
  const std::vector<std::byte> bytes = m.bytes();
  const JointModel model = parse(bytes);
  const Board board;
  joints::View view;
  ASSERT_TRUE(joints::downsample(DepthView(board.depth.data(), board.width, board.height),
                                 MaskView(board.mask.data(), board.width, board.height), board.k, board.person,
                                 view));
  joints::Shape shape{};
  joints::run_forest(model.data().forest, view, shape);
  EXPECT_NEAR(joints::joint_of(shape, static_cast<int>(Joint::NE)).x, 400, 0.01);
  constexpr auto kTorso = static_cast<std::uint8_t>(Joint::TO);
  constexpr auto kNeck = static_cast<std::uint8_t>(Joint::NE);
  // The board ends 139 mm to the right: a quarter of the distance is on it, a half is not.
  const joints::Anchor anchors[] = {{0, 0, kTorso, kNeck, 0},
                                    {0, 0, kTorso, kNeck, 64},
                                    {0, 0, kTorso, kNeck, 128},
                                    {-250, 0, kTorso, kNeck, 256},
                                    {0, 0, kNeck, kTorso, 192}};
  std::array<std::int16_t, 5> pixels{};
  joints::read_anchors(anchors, view, shape, pixels.data());
  EXPECT_EQ(pixels, (std::array<std::int16_t, 5>{0, 0, 600, 600, 0}));
}

// Whatever the model: the picture in the mirror has the joints in the mirror.
TEST(JointTracker, AMirrorShowsTheSameJointsOnTheOtherSide) {
  Rng rng(5);
  for (int round = 0; round < 20; ++round) {
    ModelRecords m = constant_model(0, 0, 0, 0);
    const auto some = [&](double spread) { return static_cast<std::int16_t>(rng.normal(0, spread)); };
    for (auto& n : m.node) n = {some(60), some(60), some(60), 0, 0, 0};
    for (auto& b : m.bone) b = some(100);
    for (auto& a : m.anchor)
      a = {some(150), some(150), static_cast<std::uint8_t>(rng.index(15)), static_cast<std::uint8_t>(rng.index(15)),
           static_cast<std::int16_t>(rng.index(257))};
    for (auto& s : m.split)
      s = {static_cast<std::uint16_t>(rng.index(4)), static_cast<std::uint16_t>(rng.index(4)), some(200)};
    for (auto& l : m.leaf) l = static_cast<std::int8_t>(rng.next());
    for (auto& b : m.basis) b = static_cast<float>(rng.uniform(-0.1, 0.1));
    const auto bytes = m.bytes();
    const JointModel model = parse(bytes);
    Board board;
    board.widen(160 + 4 * round);
    for (std::size_t i = 0; i < board.depth.size(); ++i)
      if (board.mask[i] != 0) board.depth[i] = static_cast<std::uint16_t>(2000 + rng.index(300));
    Board other = board;
    for (int v = 0; v < board.height; ++v) {
      const auto row = static_cast<std::ptrdiff_t>(v * board.width);
      std::reverse(other.depth.begin() + row, other.depth.begin() + row + board.width);
      std::reverse(other.mask.begin() + row, other.mask.begin() + row + board.width);
    }
    other.person.u_min = board.width - 1 - board.person.u_max;
    other.person.u_max = board.width - 1 - board.person.u_min;
    const JointSet plain = board.track(model), image = other.track(model);
    constexpr std::array<std::size_t, kJointCount> kOther = {0, 1, 2, 4, 3, 6, 5, 8, 7, 10, 9, 12, 11, 14, 13};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_NEAR(plain.position_mm[j].x, -image.position_mm[kOther[j]].x, 0.5) << kJointNames[j];
      EXPECT_NEAR(plain.position_mm[j].y, image.position_mm[kOther[j]].y, 0.5) << kJointNames[j];
      EXPECT_NEAR(plain.position_mm[j].z, image.position_mm[kOther[j]].z, 0.5) << kJointNames[j];
    }
  }
}

TEST(JointTracker, ConfidenceFollowsSpreadAndMask) {
  const auto still_bytes = constant_model(0, 0, 0, 0).bytes();
  const JointModel still = parse(still_bytes);
  const JointSet sure = Board().track(still);
  EXPECT_NEAR(sure.confidence[joint_index(Joint::TO)], 0.75, 0.001);

  const auto moved_bytes = constant_model(0, 0, 0, 100).bytes();  // 600 mm right, and left in the mirror
  const JointModel moved = parse(moved_bytes);
  EXPECT_LT(Board().track(moved).confidence[joint_index(Joint::TO)], 0.26);

  const auto outside_bytes = constant_model(0, 100, 0, 0).bytes();  // the head ends 1.5 m down, outside the picture
  const JointModel outside = parse(outside_bytes);
  EXPECT_LT(Board().track(outside).confidence[joint_index(Joint::HE)], 0.2);
}

TEST(JointTracker, EmptyMaskGivesNoConfidence) {
  const auto bytes = constant_model(5, 5, 5, 5).bytes();
  const JointModel model = parse(bytes);
  Board board;
  std::fill(board.mask.begin(), board.mask.end(), std::uint8_t{0});
  for (const float c : board.track(model).confidence) EXPECT_EQ(c, 0);
  board.person = {};
  for (const float c : board.track(model).confidence) EXPECT_EQ(c, 0);
}

TEST(JointView, DownsamplingKeepsMetricPositions) {
  // The same 400 x 600 mm board at 2 m with twice the pixels.
  const int w = 640, h = 480;
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(w * h), 0);
  std::vector<std::uint8_t> mask(depth.size(), 0);
  Person person;
  person.u_min = 280;
  person.u_max = 359;
  person.v_min = 180;
  person.v_max = 299;
  for (int v = person.v_min; v <= person.v_max; ++v)
    for (int u = person.u_min; u <= person.u_max; ++u) {
      depth[static_cast<std::size_t>(v * w + u)] = 2000;
      mask[static_cast<std::size_t>(v * w + u)] = 255;
    }
  joints::View view;
  ASSERT_TRUE(joints::downsample(DepthView(depth.data(), w, h), MaskView(mask.data(), w, h),
                                 {w, h, 576, 576, 319.5F, 239.5F}, person, view));
  EXPECT_EQ(view.width, 40);
  EXPECT_EQ(view.height, 60);
  EXPECT_EQ(view.pixel_count, 40 * 60);
  EXPECT_NEAR(view.fx, 288, 1e-3);
  EXPECT_NEAR(view.centroid_mm.x, 0, 0.01);
  EXPECT_NEAR(view.centroid_mm.z, 2000, 0.01);
  EXPECT_EQ(view.at_ray(0.068F, 0), 2000);  // 136 mm: the board ends at 138.9
  EXPECT_EQ(view.at_ray(0.0705F, 0), 0);    // 141 mm
  EXPECT_EQ(view.at_ray(-0.0705F, 0), 0);
  EXPECT_EQ(view.at_ray(1e4F, -1e4F), 0);
}

TEST(JointModel, VotesMayReadTheLastClue) {
  ModelRecords m = constant_model(1, 2, 3, 4);
  m.person_split[30].a = 4 + joints::kClueCount - 1;
  const auto bytes = m.bytes();
  EXPECT_TRUE(JointModel::parse(bytes, "some.i2t"));
}

TEST(JointModel, AnOlderFileIsRefusedByItsVersion) {
  const ModelRecords m = constant_model(1, 2, 3, 4);
  const auto bytes = m.bytes(3);
  const auto model = JointModel::parse(bytes, "some.i2t");
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("version 3"), std::string::npos) << model.error().message;
  EXPECT_NE(model.error().message.find("some.i2t"), std::string::npos);
}

TEST(JointModel, DamagedFilesAreRefusedByName) {
  const auto good = constant_model(1, 2, 3, 4);
  struct Damage {
    const char* what;
    void (*apply)(ModelRecords&);
  };
  const Damage damages[] = {
      {"odd trees", [](ModelRecords& m) { m.meta.forest_trees = 3; }},
      {"no trees", [](ModelRecords& m) { m.meta.forest_trees = 0; }},
      {"many trees", [](ModelRecords& m) { m.meta.forest_trees = 4000000000U; }},
      {"no jumps", [](ModelRecords& m) { m.meta.jumps = 0; }},
      {"levels", [](ModelRecords& m) { m.meta.levels = 33; }},
      {"level trees", [](ModelRecords& m) { m.meta.level_trees = 100000; }},
      {"pixels", [](ModelRecords& m) { m.meta.pixels = 1; }},
      {"many pixels", [](ModelRecords& m) { m.meta.pixels = 1025; }},
      {"tree order", [](ModelRecords& m) { std::swap(m.tree[3], m.tree[4]); }},
      {"tree past the end", [](ModelRecords& m) { m.tree[5] = 4000000000U; }},
      {"tree end", [](ModelRecords& m) { m.tree.back() -= 1; }},
      {"tree count", [](ModelRecords& m) { m.tree.pop_back(); }},
      {"child outside", [](ModelRecords& m) { m.node[7].left = 1; }},
      {"child far outside", [](ModelRecords& m) { m.node[7].left = 65535; }},
      {"no nodes", [](ModelRecords& m) { m.node.clear(); }},
      {"bones", [](ModelRecords& m) { m.bone.pop_back(); }},
      {"anchor joint", [](ModelRecords& m) { m.anchor[2].joint = 15; }},
      {"anchor towards", [](ModelRecords& m) { m.anchor[1].towards = 15; }},
      {"anchor beyond", [](ModelRecords& m) { m.anchor[1].share_q8 = 257; }},
      {"anchor before", [](ModelRecords& m) { m.anchor[1].share_q8 = -1; }},
      {"anchor count", [](ModelRecords& m) { m.anchor.pop_back(); }},
      {"split a", [](ModelRecords& m) { m.split[9].a = 4; }},
      {"split b", [](ModelRecords& m) { m.split[9].b = 65535; }},
      {"split count", [](ModelRecords& m) { m.split.pop_back(); }},
      {"leaf count", [](ModelRecords& m) { m.leaf.pop_back(); }},
      {"basis count", [](ModelRecords& m) { m.basis.pop_back(); }},
      {"basis", [](ModelRecords& m) { m.basis[50] = std::numeric_limits<float>::quiet_NaN(); }},
      {"basis too large", [](ModelRecords& m) { m.basis[51] = -1e9F; }},
      {"side trees", [](ModelRecords& m) { m.meta.side_trees = 1; }},
      {"person trees", [](ModelRecords& m) { m.meta.person_trees = 2; }},
      {"many person trees", [](ModelRecords& m) { m.meta.person_trees = 1025; }},
      {"somebody anchor joint", [](ModelRecords& m) { m.person_anchor[3].towards = 15; }},
      {"somebody anchor count", [](ModelRecords& m) { m.person_anchor.pop_back(); }},
      {"somebody split", [](ModelRecords& m) { m.person_split[30].a = 4 + joints::kClueCount; }},
      {"somebody split count", [](ModelRecords& m) { m.person_split.pop_back(); }},
      {"somebody leaf count", [](ModelRecords& m) { m.person_leaf.pop_back(); }},
      {"side split of a clue",
       [](ModelRecords& m) {
         m.meta.side_trees = 1;
         m.side_anchor = m.person_anchor;
         m.side_split = m.person_split;
         m.side_leaf = m.person_leaf;
       }},
      {"provenance", [](ModelRecords& m) { m.provenance.assign(70000, ' '); }},
      {"bins", [](ModelRecords& m) { m.bin.clear(); }},
      {"no chance above 0",
       [](ModelRecords& m) {
         for (auto& bin : m.bin) bin.chance = 0;
       }},
      {"spread that falls", [](ModelRecords& m) { std::swap(m.bin[10], m.bin[11]); }},
  };
  for (const Damage& d : damages) {
    ModelRecords m = good;
    d.apply(m);
    const auto bytes = m.bytes();
    const auto model = JointModel::parse(bytes, "some.i2t");
    ASSERT_FALSE(model) << d.what;
    EXPECT_EQ(model.error().code, ErrorCode::corrupt) << d.what;
    EXPECT_NE(model.error().message.find("some.i2t"), std::string::npos) << d.what;
  }
}

TEST(JointModel, ATreeThatRunsBackwardsIsRefused) {
  ModelRecords m = constant_model(0, 0, 0, 0);
  m.node.resize(m.node.size() + 4);
  for (std::size_t t = 1; t < m.tree.size(); ++t) m.tree[t] += 4;
  m.node[0] = {0, 0, 0, 0, 0, 1};
  m.node[1] = {0, 0, 0, 0, 0, 3};
  const auto fine = m.bytes();
  EXPECT_TRUE(JointModel::parse(fine, "m"));
  m.node[1].left = 2;  // nodes 2 and 3: the last of the five is 4
  EXPECT_TRUE(JointModel::parse(m.bytes(), "m"));
  m.node[1].left = 4;  // 4 is the tree's last, 5 the next tree's
  EXPECT_FALSE(JointModel::parse(m.bytes(), "m"));
  m.node[1].left = 1;  // its own child: would never end
  const auto loop = m.bytes();
  EXPECT_FALSE(JointModel::parse(loop, "m"));
}

TEST(JointModel, AnyAcceptedValuesTrackWithoutHarm) {
  Rng rng(11);
  for (int round = 0; round < 40; ++round) {
    ModelRecords m = constant_model(0, 0, 0, 0);
    const auto any = [&] { return static_cast<std::int16_t>(rng.next()); };
    for (auto& n : m.node) n = {any(), any(), any(), any(), any(), 0};
    for (auto& b : m.bone) b = any();
    for (auto& a : m.anchor)
      a = {any(), any(), static_cast<std::uint8_t>(rng.index(15)), static_cast<std::uint8_t>(rng.index(15)),
           static_cast<std::int16_t>(rng.index(257))};
    for (auto& s : m.split)
      s = {static_cast<std::uint16_t>(rng.index(4)), static_cast<std::uint16_t>(rng.index(4)), any()};
    for (auto& l : m.leaf) l = static_cast<std::int8_t>(rng.next());
    for (auto& b : m.basis) b = static_cast<float>(rng.uniform(-100, 100));
    m.person_anchor.assign(m.anchor.begin(), m.anchor.begin() + m.meta.pixels);
    m.person_leaf.assign(32, 1);
    for (auto& s : m.person_split)
      s = {static_cast<std::uint16_t>(rng.index(4 + joints::kClueCount)),
           static_cast<std::uint16_t>(rng.index(4 + joints::kClueCount)), any()};
    const auto bytes = m.bytes();
    const JointModel model = parse(bytes);
    JointTracker tracker(model);
    const JointSet j = Board().track(tracker);
    EXPECT_EQ(tracker.person_odds(static_cast<float>(any())), 1.0F / 256);
    for (const Vec3f& p : j.position_mm) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
}

TEST(JointModel, FlippedBytesAreNoticed) {
  const auto good = constant_model(1, 2, 3, 4).bytes();
  Rng rng(3);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    auto bad = good;
    bad[static_cast<std::size_t>(rng.index(static_cast<int>(bad.size())))] ^= std::byte{0x10};
    const auto model = JointModel::parse(bad, "m");
    refused += model ? 0 : 1;  // padding between sections may flip unseen
  }
  EXPECT_GT(refused, 50);
  for (const std::size_t cut : {std::size_t{0}, std::size_t{10}, good.size() / 2, good.size() - 1})
    EXPECT_FALSE(JointModel::parse({good.data(), cut}, "m"));
}

}  // namespace
}  // namespace im2fit
