// SPDX-License-Identifier: Apache-2.0
// The .i2f: equal bytes from equal input, and nothing in a damaged or hostile file that could hurt.
#include "core/file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <new>
#include <set>

#include "core/container.h"
#include "core/crc32c.h"
#include "index/format.h"
#include "tests/index/synthetic_people.h"
#include "train/index/raw_nearest.h"

namespace {
std::size_t allocation_count = 0;
}

// Not inlined: the compiler must not pair malloc with delete, nor elide a call.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocation_count;
  return std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace im2fit::index {
namespace {

using testing::build;
using testing::World;

const std::vector<std::byte>& good_file() {
  static const std::vector<std::byte> bytes = build(World(0.1), 400, 2);
  return bytes;
}

// The same file with one section replaced, its CRCs correct.
std::vector<std::byte> with_section(const std::string& name, const std::vector<std::byte>& content,
                                    bool drop = false) {
  const auto reader = ContainerReader::parse(good_file(), kMagic, kVersion, "good");
  ContainerWriter writer(kMagic, kVersion);
  for (const auto& [key, entry] : reader->entries()) {
    if (key == name && drop) continue;
    const auto bytes = *reader->section(key);
    writer.add(key, key == name ? content : std::vector<std::byte>(bytes.begin(), bytes.end()),
               entry.by_page ? Checked::by_page : Checked::whole);
  }
  return writer.finish();
}

template <class T>
std::vector<std::byte> patched(const std::string& name, std::size_t at, T value) {
  const auto reader = ContainerReader::parse(good_file(), kMagic, kVersion, "good");
  const auto bytes = *reader->section(name);
  std::vector<std::byte> content(bytes.begin(), bytes.end());
  std::memcpy(content.data() + at, &value, sizeof value);
  return with_section(name, content);
}

TEST(IndexFile, TwoBuildsAreEqualByteForByte) {
  EXPECT_EQ(good_file(), build(World(0.1), 400, 2));
}

TEST(IndexFile, OpensWhatItWrote) {
  const auto path =
      (std::filesystem::temp_directory_path() / ("im2fit_index_test_" + std::to_string(getpid()))).string();
  ASSERT_TRUE(write_file_atomically(path, good_file()));
  auto mapped = Index::open(path);
  ASSERT_TRUE(mapped) << mapped.error().message;
  std::filesystem::remove(path);
  const auto parsed = Index::parse(good_file(), "memory");
  ASSERT_TRUE(parsed);
  const World world(0.1);
  EXPECT_EQ(mapped->size(), 800U);
  EXPECT_EQ(mapped->feature_size(), 120U);
  EXPECT_EQ(mapped->info().subject_count, 400U);
  EXPECT_EQ(mapped->info().provenance, "synthetic people, seed 42");
  auto a = mapped->make_scratch();
  auto b = parsed->make_scratch();
  for (std::uint64_t s = 0; s < 50; ++s) {
    const Sample q = world.sample(testing::kFreshSubjects + s, 0);
    const Answer x = *mapped->query(q.feature, {}, *a);
    const Answer y = *parsed->query(q.feature, {}, *b);
    EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0);
  }
}

// Every entry is a subject's capture: its number comes back exactly, its truth to within the rounding of the codes.
TEST(IndexFile, PeopleAndTruthsComeBack) {
  const auto index = Index::parse(good_file(), "memory");
  ASSERT_TRUE(index);
  const World world(0.1);
  std::vector<int> seen(400);
  double off = 0, error = 0;
  for (std::uint32_t entry = 0; entry < index->size(); ++entry) {
    const IndexedPerson person = *index->person_of(entry);
    EXPECT_EQ(person.version, 7U);
    EXPECT_EQ(person.seed, 77U);
    ASSERT_LT(person.number, 400U);
    ++seen[static_cast<std::size_t>(person.number)];
    EXPECT_NEAR(*index->age_of(entry), testing::age_of(person.number), 0.25F);
    const Sample sample = world.sample(person.number, 0);
    const MeasurementValues values = *index->measurements_of(entry);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      off += std::abs(static_cast<double>(values[m] - sample.truth[m]));
      error += static_cast<double>(index->info().ridge_mae[m]);
    }
  }
  EXPECT_EQ(seen, std::vector<int>(400, 2));
  EXPECT_LT(off, 0.25 * error);
}

// Years 18, 25, 45 and 65 begin age groups: no age is read on the other side of one.
TEST(IndexFile, AgesKeepTheirGroups) {
  for (float years = 18; years < 90; years += 0.0625F) {
    const float read = age_of_step(age_step(years));
    EXPECT_NEAR(read, years, 0.25F);
    EXPECT_EQ(std::floor(read), std::floor(years));
  }
  EXPECT_EQ(age_step(-1), 0);
  EXPECT_EQ(age_step(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(age_step(1e9F), 254);
}

TEST(IndexFile, QueriesDoNotAllocate) {
  const auto index = Index::parse(good_file(), "memory");
  ASSERT_TRUE(index);
  auto scratch = index->make_scratch();
  const Sample q = World(0.1).sample(testing::kFreshSubjects, 0);
  const std::size_t before = allocation_count;
  int answers = 0;
  for (const int k : {0, 1, 32, 100000}) answers += index->query(q.feature, {.neighbour_count = k}, *scratch) ? 1 : 0;
  EXPECT_EQ(answers, 4);
  EXPECT_EQ(allocation_count, before);
}

TEST(IndexFile, AnswersAnyFeatureWithNumbers) {
  const auto index = Index::parse(good_file(), "memory");
  ASSERT_TRUE(index);
  auto scratch = index->make_scratch();
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (const std::vector<float>& feature :
       {std::vector<float>(120, kNaN), std::vector<float>(120, kInf), std::vector<float>(120, -kInf),
        std::vector<float>(120, 3e38F), std::vector<float>(3, 0.0F), std::vector<float>()}) {
    const Answer a = *index->query(feature, {.neighbour_count = -5, .frame_count = -5}, *scratch);
    for (const IntervalEstimate& e : a.measurements) {
      EXPECT_TRUE(std::isfinite(e.value) && std::isfinite(e.low) && std::isfinite(e.high));
      EXPECT_LE(e.low, e.high);
    }
    EXPECT_GE(a.female, 0);
    EXPECT_LE(a.female, 1);
    EXPECT_LT(a.nearest, 800U);
  }
}

TEST(IndexFile, EveryMissingOrShortSectionIsNamed) {
  const auto reader = ContainerReader::parse(good_file(), kMagic, kVersion, "good");
  for (const auto& [name, entry] : reader->entries()) {
    auto missing = Index::parse(with_section(name, {}, true), "people.i2f");
    ASSERT_FALSE(missing) << name;
    EXPECT_NE(missing.error().message.find(name), std::string::npos) << missing.error().message;
    EXPECT_NE(missing.error().message.find("people.i2f"), std::string::npos);
    if (name == "provenance") continue;  // any length will do
    const auto whole = *reader->section(name);
    auto cut = Index::parse(with_section(name, {whole.begin(), whole.end() - 1}), "people.i2f");
    ASSERT_FALSE(cut) << name;
    EXPECT_NE(cut.error().message.find(name), std::string::npos) << cut.error().message;
  }
}

TEST(IndexFile, HostileValuesBehindCorrectChecksumsAreRefused) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  struct Case {
    const char* section;
    std::vector<std::byte> bytes;
  };
  const std::vector<Case> cases = {
      {"meta", patched("meta", 0, std::uint32_t{0})},  // feature size
      {"meta", patched("meta", 0, std::uint32_t{0xFFFFFFFF})},
      {"meta", patched("meta", 4, std::uint32_t{17})},  // targets
      {"meta", patched("meta", 4, std::uint32_t{3})},
      {"meta", patched("meta", 8, std::uint32_t{0})},  // dimensions
      {"meta", patched("meta", 8, std::uint32_t{99})},
      {"meta", patched("meta", 12, std::uint32_t{0})},  // entries
      {"code", patched("meta", 12, std::uint32_t{900})},
      {"leaf", patched("meta", 12, std::uint32_t{799})},      // as many blocks
      {"meta", patched("meta", 16, std::uint32_t{1 << 20})},  // subjects
      {"meta", patched("meta", 20, std::uint32_t{0})},        // leaves
      {"leaf", patched("meta", 20, std::uint32_t{3})},
      {"leaf", patched("leaf", 4, std::uint32_t{0})},  // an empty leaf
      {"leaf", patched("leaf", 4, std::uint32_t{0x7FFFFFFF})},
      {"leaf.box", patched("leaf.box", 0, std::int16_t{32767})},
      {"leaf.box", patched("group.box", 0, std::int16_t{-32768})},
      {"groups", patched("meta", 24, std::uint32_t{16})},
      {"meta", patched("meta", 28, std::uint32_t{7})},     // method
      {"meta", patched("meta", 32, std::uint32_t{5000})},  // neighbours
      {"meta", patched("meta", 48, 0.0)},                  // grid unit
      {"meta", patched("meta", 48, std::numeric_limits<double>::quiet_NaN())},
      {"meta", patched("meta", 64, -1.0)},                                      // slope penalty
      {"meta", patched("meta", 72, std::numeric_limits<double>::quiet_NaN())},  // noise
      {"meta", patched("meta", 80, -1.0)},
      {"meta", patched("meta", 88, -1.0)},
      {"meta", patched("meta", 96, 2e9)},
      {"meta", patched("meta", 104, -1.0)},
      {"meta", patched("meta", 132, std::uint32_t{1})},  // reserved
      {"ridge", patched("ridge", 400, std::int16_t{-32768})},
      {"ridge.unit", patched("ridge.unit", 8, kNaN)},
      {"ridge.unit", patched("ridge.unit", 8, 1e30F)},
      {"feature.scale", patched("feature.scale", 8, -1.0F)},
      {"target.scale", patched("target.scale", 8, -1.0F)},
      {"code.step", patched("code.step", 0, 1 << 30)},
      {"code.step", patched("code.step", 4, -1)},
      {"interval", patched("interval", 0, 50.0F)},
      {"sex.table", patched("sex.table", 40, 1.5F)},
      {"sex.table", patched("sex.table", 4 * 128, 0.0F)},
      {"groups", patched("groups", 24, std::uint32_t{0xFFFFFFF0})},
      {"groups", patched("groups", 28, std::uint32_t{500})},
      {"report", patched("report", 4, kNaN)},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    auto index = Index::parse(cases[i].bytes, "hostile.i2f");
    ASSERT_FALSE(index) << "case " << i << " (" << cases[i].section << ")";
    EXPECT_NE(index.error().message.find(cases[i].section), std::string::npos) << i << ": " << index.error().message;
  }
}

TEST(IndexFile, DamagedForeignAndTruncatedFilesAreRefused) {
  const auto& good = good_file();
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{3}, std::size_t{31}, std::size_t{500}, good.size() / 2, good.size() - 1})
    EXPECT_FALSE(Index::parse({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}, "cut"));
  for (std::size_t at = 0; at < good.size(); at += good.size() / 97) {
    auto damaged = good;
    damaged[at] ^= std::byte{0x40};
    if (auto index = Index::parse(damaged, "damaged")) {
      // Padding between sections may change; answers must not.
      auto whole = Index::parse(good, "good");
      auto a = index->make_scratch();
      auto b = whole->make_scratch();
      const Sample q = World(0.1).sample(testing::kFreshSubjects, 0);
      const auto x = index->query(q.feature, {}, *a);
      if (!x) continue;  // noticed where it was read
      const Answer y = *whole->query(q.feature, {}, *b);
      EXPECT_EQ(std::memcmp(&*x, &y, sizeof y), 0) << "byte " << at;
    }
  }
  auto earlier = good;  // the bytes after the header stay the same
  earlier[4] = std::byte{kVersion - 1};
  const auto old = Index::parse(earlier, "old.i2f");
  ASSERT_FALSE(old);
  for (const std::string& part :
       {std::string("old.i2f"), "version " + std::to_string(kVersion - 1), "version " + std::to_string(kVersion)})
    EXPECT_NE(old.error().message.find(part), std::string::npos) << old.error().message;
  ContainerWriter body("I2BD", 1);
  auto foreign = Index::parse(body.finish(), "body.i2b");
  ASSERT_FALSE(foreign);
  EXPECT_NE(foreign.error().message.find("I2FX"), std::string::npos);
  auto absent = Index::open("/nonexistent/people.i2f");
  ASSERT_FALSE(absent);
  EXPECT_NE(absent.error().message.find("/nonexistent/people.i2f"), std::string::npos);
}

// What there is of each entry is checked when it is read. One byte of each of its pages is flipped in turn.
TEST(IndexFile, DamageIsNoticedWhereItIsRead) {
  const auto good = build(World(0.1), 3000, 2);
  const auto whole = Index::parse(good, "good");
  ASSERT_TRUE(whole);
  const auto truth = whole->make_scratch();
  const World world(0.1);
  const auto entries = ContainerReader::parse(good, kMagic, kVersion, "good")->entries();
  for (const char* section : {"code", "residual", "person", "age"}) {
    const auto offset = static_cast<std::size_t>(entries.at(section).offset);
    const auto size = static_cast<std::size_t>(entries.at(section).size);
    int refused = 0, answered = 0, unnamed = 0, named = 0;
    for (std::size_t at = 5; at < size; at += 4096) {
      auto bad = good;
      bad[offset + at] ^= std::byte{0x10};
      const auto index = Index::parse(bad, "people.i2f");
      ASSERT_TRUE(index) << index.error().message;
      auto scratch = index->make_scratch();
      const auto expect_named = [&](const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::corrupt);
        EXPECT_NE(error.message.find("people.i2f: section '" + std::string(section) + "'"), std::string::npos)
            << error.message;
      };
      for (std::uint64_t s = 0; s < 10; ++s) {
        const Sample q = world.sample(testing::kFreshSubjects + s, 0);
        const auto x = index->query(q.feature, {}, *scratch);
        refused += x ? 0 : 1;
        answered += x ? 1 : 0;
        if (!x) {
          expect_named(x.error());
          continue;
        }
        const Answer y = *whole->query(q.feature, {}, *truth);
        ASSERT_EQ(std::memcmp(&*x, &y, sizeof y), 0) << section << " byte " << at;
      }
      for (std::uint32_t entry = 0; entry < index->size(); entry += 50) {
        const auto person = index->person_of(entry);
        const auto age = index->age_of(entry);
        const auto values = index->measurements_of(entry);
        if (!age) expect_named(age.error());
        if (!person) expect_named(person.error());
        if (!values) expect_named(values.error());
        unnamed += person && age && values ? 0 : 1;
        named += person && age && values ? 1 : 0;
        if (age) {
          EXPECT_EQ(*age, *whole->age_of(entry));
        }
        if (person) {
          EXPECT_EQ(person->number, whole->person_of(entry)->number);
        }
        if (values) {
          EXPECT_EQ(*values, *whole->measurements_of(entry));
        }
      }
      const auto found = index->verify(1);
      ASSERT_FALSE(found) << section << " byte " << at;
      expect_named(found.error());
      const auto all = index->query(world.sample(testing::kFreshSubjects, 0).feature, {.exhaustive = true}, *scratch);
      if (std::string(section) == "code") {
        EXPECT_FALSE(all) << "compares every code";
      }
    }
    EXPECT_GT(answered, 0) << section;
    EXPECT_GT(named, 0) << section;
    EXPECT_GT(unnamed, 0) << section;
    if (std::string(section) == "person" || std::string(section) == "age")
      EXPECT_EQ(refused, 0) << "queries read neither numbers nor ages";
    else
      EXPECT_GT(refused, 0) << section;
  }
}

TEST(IndexFile, OpeningReadsNothingOfTheEntriesAndQueriesFewPages) {
  const auto index = Index::parse(build(World(0.1), 3000, 2), "memory");
  ASSERT_TRUE(index);
  EXPECT_EQ(index->pages_seen(), 0U);
  auto scratch = index->make_scratch();
  const Sample q = World(0.1).sample(testing::kFreshSubjects, 0);
  ASSERT_TRUE(index->query(q.feature, {.neighbour_count = 4}, *scratch));
  const std::size_t once = index->pages_seen();
  EXPECT_GT(once, 1U);
  EXPECT_LE(once, index->work_of(*scratch).pages);
  ASSERT_TRUE(index->query(q.feature, {.neighbour_count = 4}, *scratch));
  EXPECT_EQ(index->pages_seen(), once);
  ASSERT_TRUE(index->verify(1));
  EXPECT_GT(index->pages_seen(), once);
}

TEST(IndexBuild, RefusesWhatCannotBeLearnedFrom) {
  const World world;
  const auto message = [](const std::vector<Sample>& samples, const BuildOptions& options = {}) {
    auto r = build_index(options, source_of(samples));
    return r ? std::string("accepted") : r.error().message;
  };
  EXPECT_NE(message({}).find("no samples"), std::string::npos);

  std::vector<Sample> single, sizes, nan, thirty;
  for (std::uint64_t c = 0; c < 50; ++c) single.push_back(world.sample(1, c));
  EXPECT_NE(message(single).find("only 1 subjects"), std::string::npos);

  sizes = {world.sample(0, 0), world.sample(1, 0)};
  sizes[1].feature.push_back(0);
  EXPECT_NE(message(sizes).find("sample 1 has 121 features"), std::string::npos);

  nan = {world.sample(0, 0)};
  nan[0].truth[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(message(nan).find("not finite"), std::string::npos);

  for (std::uint64_t s = 0; s < 30; ++s) thirty.push_back(world.sample(s, 0));
  BuildOptions uncovered;
  uncovered.groups = {{"half", 60}};
  EXPECT_NE(message(thirty, uncovered).find("cover 60 values"), std::string::npos);
  BuildOptions many;
  many.dimensions = 17;
  EXPECT_NE(message(thirty, many).find("dimensions is 17"), std::string::npos);
  BuildOptions crowded;
  crowded.densify_to = std::size_t{kEntryMax} + 1;
  EXPECT_NE(message(thirty, crowded).find("densify_to"), std::string::npos);

  thirty[29].subject = std::uint64_t{1} << 32;
  EXPECT_NE(message(thirty).find("subject number"), std::string::npos);
}

TEST(IndexBuild, ReportsErrorsOfTheSource) {
  const auto torn = [](const auto&) -> Status { return Error{ErrorCode::io, "shard 7 is gone"}; };
  const auto built = build_index({}, torn);
  ASSERT_FALSE(built);
  EXPECT_NE(built.error().message.find("shard 7 is gone"), std::string::npos);
}

// Features or people that do not vary leave nothing to learn, but also nothing to break.
TEST(IndexBuild, SurvivesConstants) {
  const World world;
  for (const bool same_people : {false, true}) {
    std::vector<Sample> samples;
    for (std::uint64_t s = 0; s < 60; ++s) {
      Sample sample = world.sample(same_people ? 0 : s, 0);
      sample.subject = s;
      if (!same_people) std::fill(sample.feature.begin(), sample.feature.end(), 7.0F);
      sample.feature[5] = std::numeric_limits<float>::quiet_NaN();  // never measured
      samples.push_back(sample);
    }
    auto bytes = build_index({}, source_of(samples));
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto index = Index::parse(std::move(*bytes), "constant");
    ASSERT_TRUE(index) << index.error().message;
    auto scratch = index->make_scratch();
    const Answer a = *index->query(world.sample(3, 9).feature, {}, *scratch);
    double mean = 0;
    for (std::uint64_t s = 0; s < 60; ++s)
      mean += static_cast<double>(world.sample(same_people ? 0 : s, 0).truth[0]) / 60;
    EXPECT_NEAR(a.measurements[0].value, mean, 1.0);
  }
}

// The query's own neighbours are among them, and few begin as many do.
TEST(IndexFile, AlikeAreTheNearestEntriesNearestFirst) {
  const World world(0.1);
  const auto index = Index::parse(good_file(), "good");
  ASSERT_TRUE(index);
  const auto scratch = index->make_scratch();
  std::array<std::uint32_t, 40> many{};
  std::array<std::uint32_t, 7> few{};
  ASSERT_LE(index->info().neighbour_count, 40);
  for (std::uint64_t s = 0; s < 20; ++s) {
    const Sample sample = world.sample(s, 0);
    const Seen seen{sample.feature, {}, {}, {}};
    ASSERT_EQ(*index->alike(seen, few, *scratch), few.size());
    ASSERT_EQ(*index->alike(seen, many, *scratch), many.size());
    EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
    EXPECT_EQ(std::set<std::uint32_t>(many.begin(), many.end()).size(), many.size());
    const Answer answer = *index->query(seen, {}, *scratch);
    EXPECT_NE(std::find(many.begin(), many.end(), answer.nearest), many.end());
  }
}

// More candidates make the choice no worse, except for their change of the answer itself (2 % here). The
// farthest of them is twice as far.
TEST(IndexFile, TheEntryCalledNearestIsTheNearestOfThem) {
  const World world(0.1);
  const auto index = Index::parse(good_file(), "good");
  ASSERT_TRUE(index);
  const auto scratch = index->make_scratch();
  QueryOptions few, many;
  few.neighbour_count = 2;
  many.neighbour_count = 40;
  double of_few = 0, of_many = 0;
  for (std::uint64_t s = 0; s < 100; ++s) {
    const Sample sample = world.sample(testing::kFreshSubjects + s, 0);
    const Seen seen{sample.feature, {}, {}, {}};
    of_few += static_cast<double>(index->query(seen, few, *scratch)->nearest_distance);
    of_many += static_cast<double>(index->query(seen, many, *scratch)->nearest_distance);
  }
  EXPECT_LT(of_many, 1.1 * of_few);
}

TEST(RawNearestTest, FindsTheNearestByHandAndSkipsWhatWasNotMeasured) {
  RawNearest raw(3);
  const auto sample = [](std::vector<float> f, float stature) {
    Sample s;
    s.feature = std::move(f);
    s.truth[0] = stature;
    return s;
  };
  ASSERT_TRUE(raw.add(sample({0, 0, 0, 99}, 1)));
  ASSERT_TRUE(raw.add(sample({3, 4, 0}, 2)));
  ASSERT_TRUE(raw.add(sample({3, 4, 0}, 3)));
  EXPECT_FALSE(raw.add(sample({1, 2}, 4)));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto match = raw.nearest(std::vector<float>{3, 4, 12});
  EXPECT_EQ(match.sample, 1U);
  EXPECT_FLOAT_EQ(match.values[0], 2);
  EXPECT_NEAR(match.distance, 12, 1e-9);
  EXPECT_EQ(raw.nearest(std::vector<float>{0, 0, nan}).sample, 0U);
}

}  // namespace
}  // namespace im2fit::index
