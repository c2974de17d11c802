// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/train_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "core/file.h"
#include "perception/joints/model_data.h"
#include "perception/joints/person_votes.h"
#include "perception/joints/tracker.h"
#include "perception/segment/segment.h"
#include "tests/perception/joints_model_builder.h"
#include "tests/train/body_fixture.h"
#include "train/camera/virtual_camera.h"
#include "train/tracker/tracker_images.h"
#include "train/tracker/tracker_person_votes.h"
#include "train/tracker/tracker_votes.h"

namespace im2fit::lab {
namespace {

std::string cached(const char* variable, const char* name) {
  if (const char* path = std::getenv(variable)) return path;
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return std::string(cache) + "/im2fit/" + name;
  const char* home = std::getenv("HOME");
  return std::string(home != nullptr ? home : "") + "/.cache/im2fit/" + name;
}

std::optional<body::BodyModel> load_body() {
  auto model = body::BodyModel::load(cached("IM2FIT_BODY", "body.i2b"));
  if (!model) return std::nullopt;
  return std::move(*model);
}

TrainOptions tiny() {
  TrainOptions o;
  o.image_count = 44;
  o.images_per_subject = 11;
  o.level_count = 3;
  o.level_tree_count = 20;
  o.pixel_count = 60;
  o.samples_per_image = 10;
  o.starts_per_image = 3;
  return o;
}

TEST(TrainTracker, ThreadCountDoesNotShowAndSeedDoes) {
  const auto body = load_body();
  if (!body) GTEST_SKIP() << "no body pack; run im2fit-lab fetch";
  TrainOptions o = tiny();
  o.thread_count = 1;
  const auto one = train_tracker(*body, o);
  o.thread_count = 2;
  double last = 0;
  const auto two = train_tracker(*body, o, [&](double share, std::string_view stage) {
    EXPECT_GE(share, last);
    EXPECT_LE(share, 1.0);
    EXPECT_FALSE(stage.empty());
    last = share;
  });
  ASSERT_TRUE(one && two);
  EXPECT_EQ(*one, *two);
  EXPECT_EQ(last, 1.0);
  const auto model = JointModel::parse(*one, "tiny");
  ASSERT_TRUE(model) << model.error().message;
  o.seed = 2;
  const auto other = train_tracker(*body, o);
  ASSERT_TRUE(other);
  EXPECT_NE(*one, *other);
}

TEST(TrainTracker, OptionsOutOfRangeAreRefused) {
  const auto body = load_body();
  if (!body) GTEST_SKIP() << "no body pack; run im2fit-lab fetch";
  const auto refused = [&](auto change) {
    TrainOptions o = tiny();
    change(o);
    const auto r = train_tracker(*body, o);
    return !r && r.error().code == ErrorCode::invalid_argument;
  };
  EXPECT_TRUE(refused([](TrainOptions& o) { o.image_count = 39; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.images_per_subject = 0; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.thread_count = 0; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.tree_count = 3; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.jump_count = 0; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.level_count = 33; }));
  EXPECT_TRUE(refused([](TrainOptions& o) { o.pixel_count = 1; }));
}

// People the model has not seen, the whole chain as on the device: noise, furniture, our own mask.
TEST(TrainTracker, CachedModelMeetsItsBarOnHeldOutPeople) {
  const auto body = load_body();
  const auto file = read_file(cached("IM2FIT_TRACKER", "tracker.i2t"));
  if (!body || !file) GTEST_SKIP() << "no body pack or tracker; run im2fit-lab train";
  const auto model = JointModel::parse(*file, "tracker.i2t");
  ASSERT_TRUE(model) << model.error().message;
  constexpr int kPeople = 16;
  double error = 0;
  int near = 0;
  double worst_overlap = 1;
  for (int i = 0; i < kPeople; ++i) {
    const Subject subject = draw_subject(*body, Family::held_out, 4242, static_cast<std::uint64_t>(i));
    SceneOptions options;
    options.rotate_deg = 0;
    options.furniture_count = 3;
    options.pose = i % 4 == 3 ? StandingPose::psi : (i % 4 == 2 ? StandingPose::a_pose : StandingPose::relaxed);
    const int w = i % 2 == 0 ? 640 : 320, h = w * 3 / 4;
    const Intrinsics k = kinect_intrinsics(w, h);
    VirtualScene scene(*body, subject, options, kinect_sensor(), k, static_cast<std::uint64_t>(100 + i));
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(w * h));
    std::vector<std::uint8_t> mask(depth.size()), truth(depth.size());
    scene.render(0, DepthImage(depth.data(), w, h));
    scene.person_mask(MaskImage(truth.data(), w, h));
    Segmenter segmenter(w, h);
    PersonTracker people;
    JointTracker tracker(*model);
    const Person person = segmenter.run(DepthView(depth.data(), w, h), k, people, MaskImage(mask.data(), w, h));
    ASSERT_TRUE(person.found) << i;
    double both = 0, either = 0;
    for (std::size_t p = 0; p < mask.size(); ++p) {
      both += mask[p] != 0 && truth[p] != 0 ? 1 : 0;
      either += mask[p] != 0 || truth[p] != 0 ? 1 : 0;
    }
    worst_overlap = std::min(worst_overlap, both / either);
    const JointSet j = tracker.track(DepthView(depth.data(), w, h), MaskView(mask.data(), w, h), k, person, false);
    const JointSet t = scene.joints(0);
    for (std::size_t n = 0; n < kJointCount; ++n) {
      const double off = static_cast<double>(norm(j.position_mm[n] - t.position_mm[n]));
      error += off;
      near += off < 100 ? 1 : 0;
    }
  }
  const double count = kPeople * static_cast<double>(kJointCount);
  EXPECT_LT(error / count, 25);  // the small model of scripts/test has 18
  EXPECT_GT(near / count, 0.985);
  EXPECT_GT(worst_overlap, 0.93);
}

// People and rooms that the votes have not learnt from, with the drawn truth; every fourth without floor and shape.
TEST(TrainTracker, CachedModelTellsPeopleFromThings) {
  const auto body = load_body();
  const auto file = read_file(cached("IM2FIT_TRACKER", "tracker.i2t"));
  if (!body || !file) GTEST_SKIP() << "no body pack or tracker; run im2fit-lab train";
  const auto model = JointModel::parse(*file, "tracker.i2t");
  ASSERT_TRUE(model) << model.error().message;
  const joints::Votes& votes = model->data().person_votes;
  const VoteExamples seen = collect_detections(*body, *model, votes.anchors, {70, 280, 4243, 2}, {});
  std::array<int, 2> all{}, right{};  // things, people
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const int score =
        joints::count_votes(votes, seen.values.data() + static_cast<std::ptrdiff_t>(i) * seen.value_count);
    ++all[seen.yes[i]];
    right[seen.yes[i]] += (score > 0) == (seen.yes[i] != 0) ? 1 : 0;
  }
  ASSERT_GT(all[0], 40);
  ASSERT_GT(all[1], 120);
  EXPECT_GT(right[0], 0.94 * all[0]);
  EXPECT_GT(right[1], 0.94 * all[1]);
}

// A box of 5 x 2 px whose left column is nearest, off the picture's middle.
TEST(TrackerImages, AMirrorShowsTheOtherSideAtTheOtherRay) {
  TrackerImage image;
  image.view.u_first = 7;
  image.view.width = 5;
  image.view.height = 2;
  image.view.fx = image.view.fy = 100;
  image.view.cx = 8.0F;
  image.view.cy = 1.0F;
  image.view.centroid_mm = {30, 5, 1000};
  for (int i = 0; i < 10; ++i) image.view.depth.push_back(static_cast<std::uint16_t>(1000 + i));
  image.truth[joint_index(Joint::LA)] = {100, 1, 2};
  image.truth[joint_index(Joint::RA)] = {-40, 3, 4};
  image.truth[joint_index(Joint::HE)] = {7, 8, 9};
  const TrackerImage other = mirrored(image);
  for (int v = 0; v < 2; ++v) {
    for (int u = 6; u < 13; ++u) {  // a column beyond each side
      const float rx = (static_cast<float>(u) - image.view.cx) / image.view.fx;
      const float ry = (static_cast<float>(v) - image.view.cy) / image.view.fy;
      EXPECT_EQ(other.view.at_ray(-rx, ry), image.view.at_ray(rx, ry)) << u << " " << v;
    }
  }
  EXPECT_EQ(other.view.centroid_mm.x, -30);
  EXPECT_EQ(other.truth[joint_index(Joint::RA)].x, -100);
  EXPECT_EQ(other.truth[joint_index(Joint::LA)].x, 40);
  EXPECT_EQ(other.truth[joint_index(Joint::LA)].y, 3);
  EXPECT_EQ(other.truth[joint_index(Joint::HE)].x, -7);
  // Twice is once.
  EXPECT_EQ(mirrored(other).view.depth, image.view.depth);
  EXPECT_EQ(mirrored(other).view.cx, image.view.cx);
}

constexpr int kValues = 8;

DrawPair any_pair() {
  return [](Rng& rng) {
    joints::Split s;
    s.a = static_cast<std::uint16_t>(rng.index(kValues));
    s.b = static_cast<std::uint16_t>(rng.index(kValues));
    return s;
  };
}

// Yes where value 2 exceeds value 5 by more than 30, but for one in ten.
VoteExamples drawn(std::uint64_t seed, int count) {
  Rng rng(seed);
  VoteExamples out;
  out.value_count = kValues;
  for (int i = 0; i < count; ++i) {
    const std::size_t first = out.values.size();
    for (int k = 0; k < kValues; ++k) out.values.push_back(static_cast<std::int16_t>(rng.index(400) - 200));
    const bool yes = out.values[first + 2] - out.values[first + 5] > 30;
    out.yes.push_back((rng.index(10) == 0) != yes ? 1 : 0);
  }
  return out;
}

double log_odds(const VoteTrees& trees, const VoteExamples& examples, std::size_t i) {
  return joints::count_votes(trees.view(), examples.values.data() + i * kValues) /
         static_cast<double>(joints::kVoteUnit);
}

TEST(TrackerVotes, ARuleIsLearntWithItsChance) {
  VoteTrees trees;
  train_votes(drawn(1, 6000), 60, any_pair(), Rng(2), trees);
  EXPECT_EQ(trees.tree_count(), 60U);
  const VoteExamples unseen = drawn(3, 3000);
  double stated = 0;
  int right = 0, clear = 0;
  for (std::size_t i = 0; i < unseen.size(); ++i) {
    const std::int16_t* v = unseen.values.data() + i * kValues;
    const int beyond = v[2] - v[5] - 30;
    if (std::abs(beyond) < 20) continue;
    const double odds = log_odds(trees, unseen, i);
    ++clear;
    right += (odds > 0) == (beyond > 0) ? 1 : 0;
    stated += std::fabs(odds);
  }
  EXPECT_GT(right, 0.98 * clear);
  EXPECT_NEAR(stated / clear, std::log(9), 0.6) << "nine in ten";
}

constexpr std::size_t kClues = static_cast<std::size_t>(joints::kClueCount);

class TrackerDetections : public WithBody {
 protected:
  VoteExamples collect(int people, int rooms, int threads = 2) const {
    const auto bytes = test::constant_model(0, 0, 0, 0).bytes();
    const auto joint_model = JointModel::parse(bytes, "by hand");
    const std::vector<joints::Anchor> anchors = {{0, 0, 2, 2, 0}, {150, -90, 0, 0, 0}};
    return collect_detections(model(), *joint_model, anchors, {people, rooms, 5, threads}, {});
  }
};

TEST_F(TrackerDetections, PeopleAreFoundAndEachIsFollowedByItsMirrorImage) {
  const VoteExamples seen = collect(14, 0);
  ASSERT_GE(seen.size(), 24U) << "nearly everybody";
  ASSERT_EQ(seen.size() % 2, 0U);
  const auto width = static_cast<std::size_t>(seen.value_count);
  ASSERT_EQ(width, 2 + kClues);
  EXPECT_EQ(seen.values.size(), seen.size() * width);
  EXPECT_EQ(std::count(seen.yes.begin(), seen.yes.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
  int shapeless = 0;
  for (std::size_t i = 0; i < seen.size(); i += 2) {
    const std::int16_t* one = seen.values.data() + i * width + 2;
    EXPECT_EQ(one[2], one[width + 2]) << "person_score";
    if (one[width + 1] == 0)
      ++shapeless;
    else
      EXPECT_EQ(one[1], one[width + 1]) << "shape";
  }
  EXPECT_GE(shapeless, 5);
}

TEST_F(TrackerDetections, EmptyRoomsHoldNoPeople) {
  const VoteExamples seen = collect(0, 64);
  EXPECT_GT(seen.size(), 4U) << "but some things are detected";
  EXPECT_EQ(std::count(seen.yes.begin(), seen.yes.end(), 1), 0);
}

TEST_F(TrackerDetections, ThreadCountDoesNotShow) {
  const VoteExamples one = collect(8, 70, 1), two = collect(8, 70, 2);
  EXPECT_EQ(one.values, two.values);
  EXPECT_EQ(one.yes, two.yes);
}

}  // namespace
}  // namespace im2fit::lab
