// SPDX-License-Identifier: Apache-2.0
#include "synth/dataset.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/file.h"
#include "body/params_vector.h"
#include "synth/dataset_shard.h"
#include "tests/synth/body_fixture.h"

namespace im2fit::synth {
namespace {

namespace fs = std::filesystem;

class TemporaryFolder {
 public:
  TemporaryFolder() : path_(fs::temp_directory_path() / ("im2fit_dataset_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string str() const { return path_.string(); }

 private:
  fs::path path_;
};

// NaN features are equal when their bits are.
bool same(const index::Sample& a, const index::Sample& b) {
  return a.subject == b.subject && a.woman == b.woman && a.calibrate_only == b.calibrate_only &&
         a.frame_count == b.frame_count && a.truth == b.truth && a.body == b.body &&
         a.feature.size() == b.feature.size() &&
         std::memcmp(a.feature.data(), b.feature.data(), a.feature.size() * sizeof(float)) == 0;
}
bool same(const std::vector<index::Sample>& a, const std::vector<index::Sample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const index::Sample& x, const index::Sample& y) { return same(x, y); });
}

Chunk small_chunk() {
  Chunk chunk;
  for (std::uint64_t i = 0; i < 3; ++i) {
    index::Sample s;
    s.subject = 1'000'000'000'000 + i;
    s.feature = {1.5F, std::numeric_limits<float>::quiet_NaN(), static_cast<float>(i)};
    s.body = {0.25F, -1.0F};
    s.truth[3] = 400 + static_cast<float>(i);
    s.woman = i == 1;
    s.calibrate_only = i == 2;
    s.frame_count = 4 + static_cast<int>(i);
    chunk.samples.push_back(s);
  }
  chunk.subjects = 3;
  chunk.captures_failed = 2;
  chunk.frames_seen = 55;
  chunk.refused[4] = 7;
  return chunk;
}

TEST(DatasetShard, ComesBackAsWritten) {
  const TemporaryFolder folder;
  const Chunk chunk = small_chunk();
  ASSERT_TRUE(write_shard(folder / "a.i2d", 77, chunk));
  const auto back = read_shard(folder / "a.i2d", 77);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(same(back->samples, chunk.samples));
  EXPECT_EQ(back->subjects, 3);
  EXPECT_EQ(back->captures_failed, 2);
  EXPECT_EQ(back->frames_seen, 55);
  EXPECT_EQ(back->refused, chunk.refused);
}

TEST(DatasetShard, OtherKeysAndDamageAreRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_shard(folder / "a.i2d", 77, small_chunk()));
  EXPECT_FALSE(read_shard(folder / "a.i2d", 78));
  EXPECT_FALSE(read_shard(folder / "absent.i2d", 77));
  auto bytes = *read_file(folder / "a.i2d");
  for (std::size_t at = 40; at < bytes.size(); at += 64) {
    auto damaged = bytes;
    damaged[at] ^= std::byte{1};
    ASSERT_TRUE(write_file_atomically(folder / "b.i2d", damaged));
    if (const auto back = read_shard(folder / "b.i2d", 77)) {
      EXPECT_TRUE(same(back->samples, small_chunk().samples)) << "byte " << at;
    }
  }
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file_atomically(folder / "c.i2d", bytes));
  EXPECT_FALSE(read_shard(folder / "c.i2d", 77));
}

TEST(CaptureDraws, VaryAsAskedAndRepeat) {
  CaptureVariety variety;
  int wide = 0, landscape = 0;
  for (std::uint64_t s = 0; s < 2000; ++s) {
    const CaptureOptions a = draw_capture(variety, 1, s, 0);
    const CaptureOptions b = draw_capture(variety, 1, s, 0);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.frame_count, b.frame_count);
    EXPECT_NE(a.seed, draw_capture(variety, 1, s, 1).seed);
    EXPECT_NE(a.seed, draw_capture(variety, 2, s, 0).seed);
    EXPECT_GE(a.frame_count, variety.frames_min);
    EXPECT_LE(a.frame_count, variety.frames_max);
    EXPECT_NEAR(a.sensor.depth_scale, 1, 0.003001);
    wide += a.intrinsics.width == 640 ? 1 : 0;
    landscape += a.scene.rotate_deg == 0 ? 1 : 0;
  }
  EXPECT_NEAR(wide / 2000.0, variety.wide_share, 0.03);
  EXPECT_NEAR(landscape / 2000.0, variety.landscape_share, 0.04);
}

TEST(FeatureGroups, CoverTheFeature) {
  std::size_t covered = 0;
  for (const auto& g : feature_groups()) covered += g.count;
  EXPECT_EQ(covered, kFeatureSize);
}

class Dataset : public WithBody {
 protected:
  void SetUp() override {
    WithBody::SetUp();
    if (IsSkipped()) return;
    const char* given = std::getenv("IM2FIT_TRACKER");
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    const std::string path =
        given != nullptr
            ? given
            : (cache != nullptr ? std::string(cache) : std::string(home != nullptr ? home : ".") + "/.cache") +
                  "/im2fit/tracker.i2t";
    auto bytes = read_file(path);
    if (!bytes) GTEST_SKIP() << "no tracker at " << path;
    bytes_ = std::move(*bytes);
    auto tracker = JointModel::parse(bytes_, path);
    ASSERT_TRUE(tracker) << tracker.error().message;
    tracker_ = std::make_unique<JointModel>(std::move(*tracker));
  }

  std::vector<index::Sample> make(const DatasetOptions& options) {
    std::vector<index::Sample> out;
    auto report = make_dataset(model(), *tracker_, options, {}, [&](const index::Sample& s) { out.push_back(s); });
    EXPECT_TRUE(report) << report.error().message;
    if (report) report_ = *report;
    return out;
  }
  static DatasetOptions small() {
    DatasetOptions o;
    o.subject_count = 5;
    o.chunk_size = 2;
    o.variety.frames_min = 3;
    o.variety.frames_max = 5;
    o.variety.wide_share = 0.2;
    return o;
  }

  std::vector<std::byte> bytes_;
  std::unique_ptr<JointModel> tracker_;
  DatasetReport report_;
};

TEST_F(Dataset, DoesNotDependOnThreadsOrOnChunks) {
  DatasetOptions o = small();
  o.thread_count = 1;
  const auto one = make(o);
  ASSERT_FALSE(one.empty());
  for (std::size_t i = 1; i < one.size(); ++i) EXPECT_GT(one[i].subject, one[i - 1].subject);
  o.thread_count = 2;
  o.chunk_size = 3;
  EXPECT_TRUE(same(one, make(o)));
  o.seed = 2;
  EXPECT_FALSE(same(one, make(o)));
}

TEST_F(Dataset, ResumesFromShardsAndMakesDamagedOnesAgain) {
  const TemporaryFolder folder;
  DatasetOptions o = small();
  o.work_dir = folder.str();
  const auto first = make(o);
  EXPECT_EQ(report_.subjects_reused, 0);
  EXPECT_TRUE(same(first, make(o)));
  EXPECT_EQ(report_.subjects_reused, 5);
  const std::string victim = fs::directory_iterator(folder.str())->path().string();
  auto bytes = *read_file(victim);
  bytes.resize(bytes.size() - 1);
  ASSERT_TRUE(write_file_atomically(victim, bytes));
  EXPECT_TRUE(same(first, make(o)));
  EXPECT_LT(report_.subjects_reused, 5);
  EXPECT_GE(report_.subjects_reused, 3);
  o.input_key = 9;  // another tracker: nothing may be used again
  make(o);
  EXPECT_EQ(report_.subjects_reused, 0);
}

TEST_F(Dataset, FeaturesSeeTheBody) {
  DatasetOptions o = small();
  o.subject_count = 8;
  const auto samples = make(o);
  EXPECT_GE(samples.size(), 6U);
  EXPECT_EQ(report_.samples, static_cast<int>(samples.size()));
  for (const auto& s : samples) {
    EXPECT_EQ(s.feature.size(), kFeatureSize);
    EXPECT_EQ(s.body.size(), body::params_vector_size(model().modifier_names().size()));
    EXPECT_GE(s.frame_count, kCaptureFramesMin);
    const auto missing = std::count_if(s.feature.begin(), s.feature.end(), [](float f) { return std::isnan(f); });
    EXPECT_LT(missing, static_cast<std::ptrdiff_t>(kFeatureSize) / 4);
    EXPECT_GT(s.truth[measurement_index(Measurement::stature)], 1300);
    EXPECT_LT(s.truth[measurement_index(Measurement::stature)], 2200);
  }
}

TEST_F(Dataset, WrongOptionsAreRefused) {
  const auto refuse = [&](const DatasetOptions& o, const char* word) {
    auto r = make_dataset(model(), *tracker_, o, {}, [](const index::Sample&) {});
    ASSERT_FALSE(r);
    EXPECT_NE(r.error().message.find(word), std::string::npos) << r.error().message;
  };
  DatasetOptions o = small();
  o.subject_count = 0;
  refuse(o, "subject_count");
  o = small();
  o.captures_per_subject = 65;
  refuse(o, "captures_per_subject");
  o = small();
  o.variety.frames_max = 2;
  refuse(o, "frames");
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomically(folder / "file", std::string("x")));
  o = small();
  o.work_dir = folder / "file/below";
  refuse(o, "below");
}

}  // namespace
}  // namespace im2fit::synth
