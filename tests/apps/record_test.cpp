// SPDX-License-Identifier: Apache-2.0
// record, stopped short: by a kill, a full disk, a pulled cable. What was recorded until then must be readable.
#include <sys/mount.h>

#include <set>

#include "daemon_run.h"
#include "measure_run.h"

namespace im2fit {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

class Record : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<test::Picture> pictures;
    for (int i = 0; i < 30; ++i) pictures.emplace_back(kWidth, kHeight, 1000 + i);
    test::write_depth_folder(folder_.path("in"), pictures);
  }
  std::string camera(const std::string& keys) const {
    return "openni2:im2fit-virtual://3?folder=" + folder_.path("in") + keys;
  }
  static test::Run record(const std::string& source, const std::string& out, std::vector<std::string> words = {},
                          const test::RunOptions& options = {}) {
    std::vector<std::string> command = {test::kProgram, "record", source, "--out", out};
    command.insert(command.end(), words.begin(), words.end());
    return test::run_program(command, options);
  }
  // Frames of a recording as the program itself reads it: it records it again.
  int frames_read(const std::string& path) {
    const auto run = record(path, folder_.path("copy" + std::to_string(++copies_)), {"--frames", "0", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto summary = nlohmann::json::parse(run.out, nullptr, false);
    return summary.is_object() ? summary["frames"].get<int>() : -1;
  }
  static int frame_files(const std::string& folder) {
    int count = 0;
    for (const auto& name : test::files_in(folder)) count += name.size() == 10 && name.substr(6) == ".png" ? 1 : 0;
    return count;
  }

  test::TestFolder folder_;
  int copies_ = 0;
};

TEST_F(Record, CountsWhatItHasAndWhatIsMissing) {
  std::filesystem::remove(folder_.path("in") + "/000007.pgm");
  std::filesystem::resize_file(folder_.path("in") + "/000011.pgm", 50);
  const auto run = record(folder_.path("in"), folder_.path("out"), {"--frames", "0", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = nlohmann::json::parse(run.out);
  EXPECT_EQ(summary["frames"], 28);
  EXPECT_EQ(summary["damaged"], 1);
  EXPECT_EQ(summary["missing"], 2) << "the absent one and the damaged one";
  EXPECT_EQ(summary["complete"], false);
  const auto words = record(folder_.path("in"), folder_.path("again"), {"--frames", "0"});
  EXPECT_NE(words.out.find("28 frames, 2 missing, 1 damaged"), std::string::npos) << words.out;
}

TEST_F(Record, AFullDiskIsOneErrorAndKeepsTheFramesBefore) {
  // Times of 100 frames exceed the limit that stands in for a full disk; a picture does not.
  std::vector<test::Picture> pictures;
  for (int i = 0; i < 100; ++i) pictures.emplace_back(kWidth, kHeight, 1000 + i);
  test::write_depth_folder(folder_.path("long"), pictures);
  test::RunOptions options;
  options.file_bytes_max = 1500;
  const auto run = record(folder_.path("long"), folder_.path("out"), {"--frames", "0"}, options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_NE(run.err.find("free some space"), std::string::npos) << run.err;
  const int files = frame_files(folder_.path("out"));
  EXPECT_GT(files, 10);
  EXPECT_LT(files, 100);
  EXPECT_NE(run.err.find("holds the " + std::to_string(files) + " frames before"), std::string::npos) << run.err;
  EXPECT_TRUE(test::partial_files_in(folder_.path("out")).empty());
  EXPECT_EQ(frames_read(folder_.path("out")), files);
}

TEST_F(Record, AFullFileSystemIsOneErrorAndKeepsTheFramesBefore) {
  const std::string disk = folder_.path("disk");
  std::filesystem::create_directories(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "no right to mount a small disk";
  const auto run = record(folder_.path("in"), disk + "/out", {"--frames", "0"});
  const int files = frame_files(disk + "/out");
  const int readable = files > 0 ? frames_read(disk + "/out") : 0;
  ::umount(disk.c_str());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_NE(run.err.find("No space left"), std::string::npos) << run.err;
  EXPECT_GT(files, 0);
  EXPECT_EQ(readable, files);
}

#if IM2FIT_TEST_VIRTUAL
// Killed in mid-recording, again and again: whatever instant it was, the folder is a recording.
TEST_F(Record, AKillLeavesARecordingUpToTheLastFrame) {
  for (const int after : {1, 4, 9}) {
    const std::string out = folder_.path("out" + std::to_string(after));
    std::string program = test::kProgram, verb = "record", source = camera("&fps=60"), flag = "--out", to = out,
                count = "--frames", all = "0";
    std::vector<char*> argv = {program.data(), verb.data(),  source.data(), flag.data(),
                               to.data(),      count.data(), all.data(),    nullptr};
    const pid_t child = ::fork();
    if (child == 0) {
      const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
      test::detail::become(argv, null, null, {});
    }
    const auto end = test::Clock::now() + test::kPatience;
    while (test::Clock::now() < end && (!std::filesystem::exists(out) || frame_files(out) < after))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const int files = frame_files(out);
    EXPECT_GE(files, after);
    EXPECT_EQ(frames_read(out), files);
  }
}

TEST_F(Record, APulledCableIsWaitedForAndCounted) {
  const auto run =
      record(camera("&fps=30&unplug_ms=600&replug_ms=200"), folder_.path("out"), {"--frames", "40", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = nlohmann::json::parse(run.out);
  EXPECT_EQ(summary["frames"], 40);
  EXPECT_GE(summary["losses"].get<int>(), 1);
  EXPECT_GE(summary["missing"].get<int>(), 1);
  EXPECT_EQ(summary["complete"], false);
  EXPECT_NE(run.err.find("is away"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("is back"), std::string::npos) << run.err;
  EXPECT_EQ(frames_read(folder_.path("out")), 40);
  const auto strict =
      record(camera("&fps=30&unplug_ms=600"), folder_.path("strict"), {"--frames", "0", "--reconnect", "0"});
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(strict.err, "im2fit")) << strict.err;
  EXPECT_NE(strict.err.find("frames before"), std::string::npos) << strict.err;
  EXPECT_EQ(frames_read(folder_.path("strict")), frame_files(folder_.path("strict")));
}

// The runtime's recorder names the file once it is whole; a kill leaves it under its working name.
TEST_F(Record, AKilledOniPlaysToItsLastFrame) {
  const std::string out = folder_.path("killed.oni");
  std::string program = test::kProgram, verb = "record", source = camera("&fps=60"), flag = "--out", to = out,
              count = "--frames", all = "0";
  std::vector<char*> argv = {program.data(), verb.data(),  source.data(), flag.data(),
                             to.data(),      count.data(), all.data(),    nullptr};
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    test::detail::become(argv, null, null, {});
  }
  std::error_code none;
  const auto end = test::Clock::now() + test::kPatience;
  while (test::Clock::now() < end && !(std::filesystem::file_size(out + ".part", none) > 20'000 && !none))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  ASSERT_TRUE(std::filesystem::exists(out + ".part"));
  std::filesystem::rename(out + ".part", out);
  EXPECT_GE(frames_read(out), 5);
}
#endif

}  // namespace
}  // namespace im2fit
