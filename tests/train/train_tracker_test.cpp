// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/train_tracker.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>

#include "core/file.h"
#include "perception/joints/model_data.h"
#include "perception/joints/tracker.h"
#include "perception/segment/segment.h"
#include "train/camera/virtual_camera.h"
#include "train/tracker/tracker_detections.h"

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

// People and rooms that the votes have not learnt from, by what was drawn; every fourth without floor and shape.
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

}  // namespace
}  // namespace im2fit::lab
