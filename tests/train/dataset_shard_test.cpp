// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/dataset_shard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/file.h"
#include "tests/train/dataset_samples.h"

namespace im2fit::lab {
namespace {

namespace fs = std::filesystem;

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
    s.clothes_kind = i == 0 ? 4 : 0;
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

TEST(DatasetShard, StatesWhatItIs) {
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
  ASSERT_TRUE(write_file_atomically(folder_ / "empty/x.i2d", std::string("not a shard at all, whatever its name")));
  refuse({"a", "empty"}, "x.i2d");
}

TEST_F(Shards, ADamagedOneIsFoundWhenRead) {
  write("a", {0, 4});
  write("a", {4, 4});
  const std::string path = folder_ / "a" + "/" + shard_name(small_run(), {4, 4});
  auto bytes = *read_file(path);
  bytes[bytes.size() - 64] ^= std::byte{1};  // of the last section; the bytes after it may be padding
  ASSERT_TRUE(write_file_atomically(path, bytes));
  const auto set = find({"a"});
  ASSERT_TRUE(set);
  int seen = 0;
  const auto read = set->read([&](const index::Sample&) { return ++seen > 0; });
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
  EXPECT_EQ(seen, 4);
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

}  // namespace
}  // namespace im2fit::lab
