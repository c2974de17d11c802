// SPDX-License-Identifier: Apache-2.0
#include "synth/dataset.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>

#include "base/file.h"
#include "body/params_vector.h"
#include "synth/dataset_shard.h"
#include "synth/half.h"
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
         a.clothed == b.clothed && a.frame_count == b.frame_count && a.back_frame_count == b.back_frame_count &&
         a.distance_mm == b.distance_mm && a.back_distance_mm == b.back_distance_mm && a.truth == b.truth &&
         a.body == b.body && a.feature.size() == b.feature.size() &&
         std::memcmp(a.feature.data(), b.feature.data(), a.feature.size() * sizeof(float)) == 0;
}
bool same(const std::vector<index::Sample>& a, const std::vector<index::Sample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const index::Sample& x, const index::Sample& y) { return same(x, y); });
}

RunKey small_run() {
  RunKey run;
  run.dataset_version = 3;
  run.input_key = 77;
  run.seed = 1;
  run.wide_share = 0.125;
  run.feature_size = 3;
  run.body_size = 2;
  return run;
}
constexpr SubjectRange kSmallRange{1'000'000'000'000, 5};

// Five subjects, two without a sample.
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
    s.clothed = i == 0;
    s.frame_count = 4 + static_cast<int>(i);
    s.back_frame_count = i == 2 ? 3 : 0;
    s.distance_mm = 2345 + 30000 * static_cast<int>(i);
    s.back_distance_mm = i == 2 ? 3456 : 0;
    chunk.samples.push_back(s);
  }
  chunk.counts.subjects = chunk.counts.samples = 3;
  chunk.counts.captures_failed = 2;
  chunk.counts.frames_seen = 55;
  chunk.counts.refused[4] = 7;
  return chunk;
}

TEST(DatasetShard, ComesBackAsWritten) {
  const TemporaryFolder folder;
  const Chunk chunk = small_chunk();
  ASSERT_TRUE(write_shard(folder / "a.i2d", small_run(), kSmallRange, chunk));
  const auto back = read_shard(folder / "a.i2d", small_run(), kSmallRange);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(same(back->samples, chunk.samples));
  EXPECT_EQ(back->counts.subjects, 3);
  EXPECT_EQ(back->counts.captures_failed, 2);
  EXPECT_EQ(back->counts.frames_seen, 55);
  EXPECT_EQ(back->counts.refused, chunk.counts.refused);
}

TEST(DatasetShard, SaysWhatItIs) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_shard(folder / "a.i2d", small_run(), kSmallRange, small_chunk()));
  const auto about = about_shard(folder / "a.i2d");
  ASSERT_TRUE(about) << about.error().message;
  EXPECT_EQ(about->run, small_run());
  EXPECT_EQ(about->range, kSmallRange);
  EXPECT_EQ(about->counts.samples, 3);
  const auto bytes = *read_file(folder / "a.i2d");
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const char* line : {"subjects 1000000000000 to 1000000000004\n", "seed 1\n", "wide_share 0.125\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
}

TEST(DatasetShard, OtherRunsRangesAndDamageAreRefused) {
  const TemporaryFolder folder;
  const auto read = [&](const char* name) { return read_shard(folder / name, small_run(), kSmallRange); };
  ASSERT_TRUE(write_shard(folder / "a.i2d", small_run(), kSmallRange, small_chunk()));
  RunKey other = small_run();
  other.seed = 2;
  const auto refused = read_shard(folder / "a.i2d", other, kSmallRange);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("seed 1, not 2"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(read_shard(folder / "a.i2d", small_run(), {kSmallRange.first, 6}));
  EXPECT_FALSE(read("absent.i2d"));
  auto bytes = *read_file(folder / "a.i2d");
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    auto damaged = bytes;
    damaged[at] ^= std::byte{1};
    ASSERT_TRUE(write_file_atomically(folder / "b.i2d", damaged));
    (void)about_shard(folder / "b.i2d");  // any answer but a crash
    if (const auto back = read("b.i2d")) {
      EXPECT_TRUE(same(back->samples, small_chunk().samples)) << "byte " << at;
    }
  }
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file_atomically(folder / "c.i2d", bytes));
  EXPECT_FALSE(read("c.i2d"));
}

TEST(DatasetShard, FeaturesBeyondHalfPrecisionAreRefused) {
  const TemporaryFolder folder;
  Chunk chunk = small_chunk();
  chunk.samples[1].feature[0] = 70000;
  fit_to_shard(chunk.samples[1]);
  const auto written = write_shard(folder / "a.i2d", small_run(), kSmallRange, chunk);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("feature 0 is 70000"), std::string::npos) << written.error().message;
}

// Truth: the value a half stands for, sign (1 + significand/1024) 2^(exponent - 15), in double.
double value_of_half(std::uint16_t h) {
  const int exponent = h >> 10 & 31, significand = h & 1023;
  const double size = exponent == 0 ? std::ldexp(significand, -24) : std::ldexp(1024 + significand, exponent - 25);
  return (h & 0x8000) != 0 ? -size : size;
}

TEST(Half, EveryValueAndTheNearestToAnyOther) {
  for (int bits = 0; bits < 0x10000; ++bits) {
    const auto h = static_cast<std::uint16_t>(bits);
    const float f = float_of(h);
    if ((h >> 10 & 31) == 31) {
      EXPECT_EQ(std::isnan(f), (h & 1023) != 0);
      EXPECT_EQ(std::isinf(f), (h & 1023) == 0);
      continue;
    }
    EXPECT_EQ(static_cast<double>(f), value_of_half(h));
    EXPECT_EQ(half_of(f), h);
    if ((h & 0x7FFF) == 0x7BFF) continue;
    // Between this and the next: the nearer, in the middle the even one.
    const auto next = static_cast<std::uint16_t>(h + 1);
    const double middle = (value_of_half(h) + value_of_half(next)) / 2;
    const auto there = static_cast<float>(middle);
    ASSERT_EQ(static_cast<double>(there), middle);
    EXPECT_EQ(half_of(there), (h & 1) == 0 ? h : next);
    EXPECT_EQ(half_of(std::nextafter(there, f)), h);
    EXPECT_EQ(half_of(std::nextafter(there, float_of(next))), next);
  }
  EXPECT_EQ(half_of(65519.996F), 0x7BFF);
  EXPECT_EQ(half_of(65520.0F), 0x7C00);
  EXPECT_EQ(half_of(1e30F), 0x7C00);
  EXPECT_EQ(half_of(1e-30F), 0);
  EXPECT_TRUE(std::isnan(float_of(half_of(std::numeric_limits<float>::quiet_NaN()))));
}

class Shards : public ::testing::Test {
 protected:
  void write(const std::string& where, SubjectRange range, std::uint64_t seed = 1) {
    RunKey run = small_run();
    run.seed = seed;
    Chunk chunk;
    for (std::uint64_t i = 0; i < range.count; ++i) {
      index::Sample s;
      s.subject = range.first + i;
      s.feature = {1, 2, 3};
      s.body = {0, 1};
      chunk.samples.push_back(s);
    }
    chunk.counts.samples = chunk.counts.subjects = static_cast<std::int32_t>(range.count);
    ASSERT_TRUE(make_directory(folder_ / where));
    ASSERT_TRUE(write_shard(folder_ / where + "/" + shard_name(run, range), run, range, chunk));
  }
  Result<ShardSet> find(const std::vector<std::string>& names) {
    std::vector<std::string> folders;
    for (const auto& name : names) folders.push_back(folder_ / name);
    return ShardSet::find(folders);
  }
  void refuse(const std::vector<std::string>& names, const std::string& words) {
    const auto set = find(names);
    ASSERT_FALSE(set);
    EXPECT_NE(set.error().message.find(words), std::string::npos) << set.error().message;
  }
  TemporaryFolder folder_;
};

TEST_F(Shards, OfSeveralFoldersAreOneRow) {
  write("a", {0, 4});
  write("b", {4, 3});
  write("a", {7, 5});
  ASSERT_TRUE(write_file_atomically(folder_ / "a/samples.json", std::string("{}")));
  const auto set = find({"b", "a"});
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(set->range(), (SubjectRange{0, 12}));
  EXPECT_TRUE(set->expect({0, 12}));
  EXPECT_FALSE(set->expect({0, 13}));
  EXPECT_FALSE(set->expect({0, 11}));
  std::vector<std::uint64_t> seen;
  ASSERT_TRUE(set->read([&](const index::Sample& s) {
    seen.push_back(s.subject);
    return true;
  }));
  ASSERT_EQ(seen.size(), 12U);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], i);
}

TEST_F(Shards, MixedDoubledMissingAndNoneAreRefused) {
  write("a", {0, 4});
  write("gap", {6, 2});
  refuse({"a", "gap"}, "subjects 4 to 5 are missing");
  write("twice", {0, 4});
  refuse({"a", "twice"}, "delete one of them");
  write("overlap", {3, 2});
  refuse({"a", "overlap"}, "delete one of them");
  write("mixed", {4, 2}, 2);
  refuse({"a", "mixed"}, "seed 2, not 1");
  ASSERT_TRUE(make_directory(folder_ / "empty"));
  refuse({"empty"}, "no shards");
  refuse({"absent"}, "absent");
  ASSERT_TRUE(
      write_file_atomically(folder_ / "empty/x.i2d", std::string("not a shard at all, whatever its name says")));
  refuse({"a", "empty"}, "x.i2d");
}

TEST_F(Shards, ADamagedOneIsFoundWhenRead) {
  write("a", {0, 4});
  write("a", {4, 4});
  const std::string path = folder_ / "a" + "/" + shard_name(small_run(), {4, 4});
  auto bytes = *read_file(path);
  bytes[bytes.size() - 64] ^= std::byte{1};  // of the last section; what follows may be padding
  ASSERT_TRUE(write_file_atomically(path, bytes));
  const auto set = find({"a"});
  ASSERT_TRUE(set);
  int seen = 0;
  const auto read = set->read([&](const index::Sample&) { return ++seen > 0; });
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
  EXPECT_EQ(seen, 4);
}

TEST(CaptureDraws, VaryAsAskedAndRepeat) {
  CaptureVariety variety;
  int wide = 0, landscape = 0, anywhere = 0, far = 0;
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
    anywhere += a.scene.distance_mm > 0 ? 1 : 0;
    far += a.scene.distance_mm > 3300 ? 1 : 0;
    EXPECT_EQ(a.scene.enlarge_to_fit, a.scene.distance_mm > 0);
    EXPECT_LE(a.scene.distance_mm, 4000);  // TOO_FAR
  }
  EXPECT_NEAR(anywhere / 2000.0, variety.anywhere_share, 0.04);
  EXPECT_NEAR(far / 2000.0, variety.anywhere_share / 3, 0.03);
  EXPECT_NEAR(wide / 2000.0, variety.wide_share, 0.03);
  EXPECT_NEAR(landscape / 2000.0, variety.landscape_share, 0.04);
}

TEST(FeatureGroups, CoverTheFeature) {
  std::size_t covered = 0;
  for (const auto& g : feature_groups()) covered += g.count;
  EXPECT_EQ(covered, kFeatureSize);
}

TEST(DatasetPeople, OneInThreeOfTheFirstIsAStranger) {
  const DatasetOptions usual;
  EXPECT_EQ(usual.stranger_every, 3);
  EXPECT_EQ(usual.stranger_below, 16384U);
  for (const int models : {1, 2, 3, 12, 13, 100, 10'922, 10'923, 10'924, 50'000}) {
    int subjects = 0;
    for (int found = 0; found < models; ++subjects) found += subjects < 16384 && subjects % 3 == 2 ? 0 : 1;
    EXPECT_EQ(subjects_with(models, 3, 16384), subjects) << models;
  }
  EXPECT_EQ(subjects_with(50'000, 3, 16384), 55'461);
  EXPECT_EQ(subjects_with(900'000'000, 3, 16384), 900'005'461);
  EXPECT_EQ(subjects_with(70, 0, 16384), 70);
  EXPECT_TRUE(is_stranger(16'382, 3, 16384));
  EXPECT_FALSE(is_stranger(16'385, 3, 16384));
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
  for (std::size_t i = 1; i < one.size(); ++i) EXPECT_GE(one[i].subject, one[i - 1].subject);
  o.thread_count = 2;
  o.chunk_size = 3;
  EXPECT_TRUE(same(one, make(o)));
  o.seed = 2;
  EXPECT_FALSE(same(one, make(o)));
}

TEST_F(Dataset, EverySecondPairIsSeenInClothesToo) {
  DatasetOptions o = small();
  const auto bare = [&] {
    o.clothed_every = 0;
    return make(o);
  }();
  o.clothed_every = 2;
  std::vector<index::Sample> rest;
  std::vector<std::uint64_t> clothed;
  for (const index::Sample& s : make(o)) {
    if (!s.clothed) {
      rest.push_back(s);
      continue;
    }
    clothed.push_back(s.subject);
    ASSERT_FALSE(rest.empty());
    EXPECT_EQ(rest.back().subject, s.subject) << "the bare sample goes before";
    EXPECT_EQ(rest.back().truth, s.truth) << "what is true is the body's";
    EXPECT_TRUE(s.refines());
    EXPECT_NE(std::memcmp(rest.back().feature.data(), s.feature.data(), s.feature.size() * sizeof(float)), 0);
  }
  EXPECT_EQ(clothed, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_TRUE(same(rest, bare));
}

TEST_F(Dataset, KnowsHowFarAwayPeopleStoodByTheTrunk) {
  DatasetOptions o = small();
  o.variety.anywhere_share = 1;
  constexpr std::size_t kMeanDepth = kPaperFeatureSize + ProfileLayout::kSceneValues;  // of the person's pixels
  int least = 10000, most = 0;
  for (const index::Sample& s : make(o)) {
    EXPECT_NEAR(s.distance_mm, s.feature[kMeanDepth], 200);
    if (s.refines()) {
      EXPECT_NEAR(s.back_distance_mm, s.distance_mm, 250) << "at the same place";
    }
    EXPECT_EQ(s.back_distance_mm > 0, s.refines());
    least = std::min(least, s.distance_mm);
    most = std::max(most, s.distance_mm);
  }
  EXPECT_GT(most, least + 500);
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

// Every file of a folder but the note.
std::map<std::string, std::vector<std::byte>> files_of(const std::string& folder) {
  std::map<std::string, std::vector<std::byte>> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".i2d")
      files[entry.path().filename().string()] = *read_file(entry.path().string());
  return files;
}

TEST_F(Dataset, PartsMakeWhatOneRunMakes) {
  const TemporaryFolder folder;
  DatasetOptions o = small();
  o.subject_count = 7;
  o.work_dir = folder / "whole";
  const auto whole = make(o);
  EXPECT_EQ(report_.subjects_drawn, 7);
  int drawn = 0;
  for (const int part : {2, 0, 1}) {
    o.part = part;
    o.part_count = 3;
    o.work_dir = folder / (part == 1 ? "one" : "others");
    make(o);
    drawn += report_.subjects_drawn;
  }
  EXPECT_EQ(drawn, 7);
  const std::vector<std::string> folders = {folder / "one", folder / "others"};
  const auto set = ShardSet::find(folders);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_TRUE(set->expect({0, 7}));
  EXPECT_EQ(set->run(), run_key_of(model(), o));
  std::vector<index::Sample> read;
  ASSERT_TRUE(set->read([&](const index::Sample& s) {
    read.push_back(s);
    return true;
  }));
  EXPECT_TRUE(same(whole, read));
  auto together = files_of(folder / "one");
  together.merge(files_of(folder / "others"));
  EXPECT_EQ(together, files_of(folder / "whole"));
}

TEST_F(Dataset, KilledAndRunAgainEndsInTheSameBytes) {
  const TemporaryFolder folder;
  DatasetOptions o = small();
  o.subject_count = 8;
  o.work_dir = folder / "whole";
  make(o);
  o.work_dir = folder / "killed";
  ASSERT_TRUE(make_directory(o.work_dir));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    (void)make_dataset(model(), *tracker_, o, {}, [](const index::Sample&) {});
    _exit(0);
  }
  while (files_of(o.work_dir).empty() && waitpid(child, nullptr, WNOHANG) == 0) usleep(2000);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const auto left = files_of(o.work_dir).size();
  EXPECT_GE(left, 1U);
  make(o);
  EXPECT_GE(report_.subjects_reused, static_cast<int>(2 * left));
  EXPECT_EQ(files_of(o.work_dir), files_of(folder / "whole"));
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

TEST_F(Dataset, LowNumbersTurnRoundAndKeepTheirFrontsFrames) {
  if (model().shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space";
  DatasetOptions o = small();
  o.subject_count = 8;
  o.turn_below = 5;
  o.clothed_every = 0;
  const auto turned = make(o);
  o.turn_below = 0;
  const auto plain = make(o);
  ASSERT_EQ(turned.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const std::uint64_t number = turned[i].subject;
    // Every second pair, and 2, a stranger; 5, another, is not low enough.
    EXPECT_EQ(turned[i].refines(), number < 5 && (number / 2 % 2 == 0 || number == 2)) << number;
    EXPECT_EQ(turned[i].back_frame_count >= kCaptureFramesMin, turned[i].refines()) << number;
    EXPECT_EQ(turned[i].frame_count, plain[i].frame_count) << number;
    EXPECT_FALSE(plain[i].refines());
    EXPECT_EQ(plain[i].back_frame_count, 0);
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
  o = small();
  o.part = 3;
  o.part_count = 3;
  refuse(o, "part 3 of 3");
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomically(folder / "file", std::string("x")));
  o = small();
  o.work_dir = folder / "file/below";
  refuse(o, "below");
}

}  // namespace
}  // namespace im2fit::synth
