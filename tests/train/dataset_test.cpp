// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/dataset.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <tuple>

#include "body/params_vector.h"
#include "core/file.h"
#include "tests/train/dataset_samples.h"
#include "tests/train/tracker_fixture.h"
#include "train/dataset/dataset_shard.h"

namespace im2fit::lab {
namespace {

namespace fs = std::filesystem;

TEST(DatasetVersion, IsReadBackFromAProvenance) {
  EXPECT_EQ(dataset_version_text(22), "dataset version 22");
  EXPECT_EQ(dataset_version_in("im2fit-lab index --subjects 1500 --seed 1, " + dataset_version_text(22)), 22U);
  EXPECT_EQ(dataset_version_in("dataset version 4294967296 and more"), 4294967296U);
  for (const char* without :
       {"", "im2fit-lab index --subjects 1500 --seed 1", "dataset version ", "dataset version x"})
    EXPECT_FALSE(dataset_version_in(without)) << without;
}

TEST(DatasetPeople, OneInThreeOfTheFirstIsOutOfDistribution) {
  const DatasetOptions usual;
  EXPECT_EQ(usual.ood_every, 3);
  EXPECT_EQ(usual.ood_below, 14336U);
  for (const int models : {1, 2, 3, 12, 13, 100, 9'557, 9'558, 9'559, 50'000}) {
    int subjects = 0;
    for (int found = 0; found < models; ++subjects) found += subjects < 14336 && subjects % 3 == 2 ? 0 : 1;
    EXPECT_EQ(subjects_with(models, 3, 14336), subjects) << models;
  }
  EXPECT_EQ(subjects_with(50'000, 3, 14336), 54'778);
  EXPECT_EQ(subjects_with(900'000'000, 3, 14336), 900'004'778);
  EXPECT_EQ(subjects_with(70, 0, 14336), 70);
  EXPECT_TRUE(is_ood(14'333, 3, 14336));
  EXPECT_FALSE(is_ood(14'336, 3, 14336));
}

class Dataset : public WithTracker {
 protected:
  std::vector<index::Sample> make(const DatasetOptions& options) {
    std::vector<index::Sample> out;
    auto report = make_dataset(model(), tracker(), options, {}, [&](const index::Sample& s) { out.push_back(s); });
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
  o.seed = 2;  // no capture fails
  o.again_below = 0;
  const auto bare = [&] {
    o.clothed_every = 0;
    return make(o);
  }();
  o.clothed_every = 2;
  std::vector<index::Sample> rest;
  std::vector<std::uint64_t> clothed;
  for (const index::Sample& s : make(o)) {
    EXPECT_EQ(s.clothes_kind > 0, s.clothed);
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
  // What a killed run left goes, once no other run can be at it; other files stay.
  const std::string old_leftover = folder.str() + "/samples-1.i2d.ab12cd",
                    new_leftover = folder.str() + "/samples-2.i2d.ab12cd";
  for (const auto& path : {old_leftover, new_leftover, folder.str() + "/notes.ab12cd"})
    ASSERT_TRUE(write_file_atomically(path, std::string("x")));
  fs::last_write_time(old_leftover, fs::file_time_type::clock::now() - std::chrono::hours(2));
  const auto first = make(o);
  EXPECT_EQ(report_.subjects_reused, 0);
  EXPECT_FALSE(fs::exists(old_leftover));
  for (const auto& path : {new_leftover, folder.str() + "/notes.ab12cd"}) EXPECT_TRUE(fs::remove(path)) << path;
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
    (void)make_dataset(model(), tracker(), o, {}, [](const index::Sample&) {});
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
  o.again_below = 0;
  const auto turned = make(o);
  o.turn_below = 0;
  const auto plain = make(o);
  ASSERT_EQ(turned.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const std::uint64_t number = turned[i].subject;
    // Every second pair, and 2, out of distribution; 5 is so, too, but not low enough.
    EXPECT_EQ(turned[i].refines(), number < 5 && (number / 2 % 2 == 0 || number == 2)) << number;
    EXPECT_EQ(turned[i].back_frame_count >= kCaptureFramesMin, turned[i].refines()) << number;
    EXPECT_EQ(turned[i].frame_count, plain[i].frame_count) << number;
    EXPECT_FALSE(plain[i].refines());
    EXPECT_EQ(plain[i].back_frame_count, 0);
  }
}

TEST_F(Dataset, WhoTurnsIsSeenAgain) {
  if (model().shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space";
  DatasetOptions o = small();
  o.seed = 2;           // no capture fails
  o.subject_count = 3;  // 0 and 1 turn, 2 is out of distribution and is seen in clothes as well
  const auto captures_of = [](const std::vector<index::Sample>& samples) {
    std::map<std::tuple<std::uint64_t, bool, bool>, const index::Sample*> captures;
    for (const index::Sample& s : samples)
      EXPECT_TRUE(captures.try_emplace({s.subject, s.clothed, s.again}, &s).second);
    return captures;
  };
  const auto twice = make(o);
  const auto captures = captures_of(twice);
  int pairs = 0;
  for (const auto& [key, again] : captures) {
    const auto& [number, clothed, is_again] = key;
    if (!is_again) continue;
    EXPECT_TRUE(again->refines());
    EXPECT_FALSE(again->is_entry());
    const auto first = captures.find({number, clothed, false});
    ASSERT_NE(first, captures.end()) << number;
    EXPECT_EQ(again->truth, first->second->truth);  // the same body
    EXPECT_NE(again->feature, first->second->feature);
    EXPECT_NE(again->fit, first->second->fit);
    EXPECT_EQ(again->calibrate_only, first->second->calibrate_only);
    EXPECT_GT(again->frame_count, 3 * first->second->frame_count);  // as a device takes
    ++pairs;
  }
  EXPECT_EQ(pairs, 4);
  // Who is seen once is seen as the first time.
  o.again_below = 0;
  for (const index::Sample& s : make(o)) {
    const auto first = captures.find({s.subject, s.clothed, false});
    ASSERT_NE(first, captures.end());
    EXPECT_TRUE(same(s, *first->second)) << s.subject;
  }
}

TEST_F(Dataset, WrongOptionsAreRefused) {
  const auto refuse = [&](const DatasetOptions& o, const char* word) {
    auto r = make_dataset(model(), tracker(), o, {}, [](const index::Sample&) {});
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
}  // namespace im2fit::lab
