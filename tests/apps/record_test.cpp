// SPDX-License-Identifier: Apache-2.0
// record, stopped short: by a kill, a full disk, a pulled cable. What was recorded until then must be readable.
#include <sys/mount.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <set>

#include "daemon_run.h"
#include "hal/open/open.h"
#include "measure_run.h"

namespace im2fit {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
// Of a .oni, for pictures of one depth: 76800 pixels, 30 to a byte, and the record's own 46.
[[maybe_unused]] constexpr std::uintmax_t kFrameBytesMax = 2700;
[[maybe_unused]] constexpr std::uintmax_t kHeadBytesMax = 1200;

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
  static std::string matrix_of(const std::string& yaml) {
    const std::string text = test::read_text(yaml);
    const auto at = text.find("camera_matrix");
    return at == std::string::npos ? "" : text.substr(at, text.find(']', at) - at);
  }
  static int frame_files(const std::string& folder) {
    int count = 0;
    for (const auto& name : test::files_in(folder)) count += name.size() == 10 && name.substr(6) == ".png" ? 1 : 0;
    return count;
  }

  test::TestFolder folder_;
  int copies_ = 0;
};

TEST_F(Record, KeepsThePosesOfACameraThatMoves) {
  const std::string poses =
      "sequence,x_m,y_m,z_m,qx,qy,qz,qw\n"
      "000000,0.1,-2.5,0.333333344,0,0.600000024,0,0.800000012\n"
      "000002,1,2,3,0,0,0,1\n";
  std::ofstream(folder_.path("in") + "/poses.csv") << poses;
  const auto run = record(folder_.path("in"), folder_.path("out"), {"--frames", "0"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(test::read_text(folder_.path("out") + "/poses.csv"), poses);
}

// A recording of Stray Scanner becomes a depth folder with its poses, and a .oni, which has no place for them.
TEST_F(Record, ConvertReportsWhatTheTargetHasNoPlaceFor) {
  const std::string stray = folder_.path("stray");
  std::filesystem::create_directories(stray);
  std::filesystem::rename(folder_.path("in"), stray + "/depth");
  std::filesystem::remove(stray + "/depth/camera.yaml");
  std::ofstream(stray + "/camera_matrix.csv") << "1400, 0, 960\n0, 1400, 720\n0, 0, 1\n";
  std::ofstream table(stray + "/odometry.csv");
  table << "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (int i = 0; i < 30; ++i) table << 5 + i << ", " << i << ", 0, 1, 0, 1, 0, 0, 0\n";
  table.close();
  const auto convert = [&](const std::string& out) {
    return test::run_program({test::kProgram, "convert", stray, folder_.path(out), "--json"});
  };
  const auto to_folder = convert("folder");
  ASSERT_EQ(to_folder.exit_code, 0) << to_folder.err;
  const auto folder = nlohmann::json::parse(to_folder.out);
  EXPECT_EQ(folder["frames"], 30);
  EXPECT_EQ(folder["not_kept"], nlohmann::json::array());
  EXPECT_NE(test::read_text(folder_.path("folder") + "/poses.csv"), "");
  const auto to_oni = convert("file.oni");
  ASSERT_EQ(to_oni.exit_code, 0) << to_oni.err;
  EXPECT_EQ(nlohmann::json::parse(to_oni.out)["not_kept"], (nlohmann::json{"poses", "gravity"}));
  // The frames are the same.
  for (const char* name : {"folder", "file.oni"}) {
    auto source = hal::open_source(folder_.path(name));
    ASSERT_TRUE(source) << source.error().message;
    std::vector<std::uint16_t> pixels(std::size_t{kWidth} * kHeight);
    ASSERT_TRUE((*source)->start());
    for (int i = 0; i < 30; ++i) ASSERT_TRUE((*source)->next(DepthImage(pixels.data(), kWidth, kHeight), 5000)) << i;
    EXPECT_EQ(pixels.front(), 1029) << name;
  }
  const auto again = convert("file.mkv");
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, testing::HasSubstr(".mkv files are not written"));
  const auto camera = test::run_program({test::kProgram, "convert", "synthetic:1", folder_.path("endless")});
  EXPECT_EQ(camera.exit_code, 1);
  EXPECT_THAT(camera.err, testing::HasSubstr("never ends; record it"));
}

// The person stands still while the camera is carried round: seen from the place at rest the hips stay where they
// are, with the sway of one who stands, and the camera goes all round them.
TEST(RenderedWalk, PosesSayWhereTheCameraWas) {
  if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
  const test::TestFolder folder;
  const std::string out = folder.path("walked");
  const auto run = test::run_program({test::kLab, "render", "--out", out, "--seed", "7", "--size", "320x240",
                                      "--body", test::body_path(), "--frames", "200", "--walk-round-after", "5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto truth = nlohmann::json::parse(test::read_text(out + "/truth.json"));
  auto source = hal::open_source(out);
  ASSERT_TRUE(source) << source.error().message;
  const Intrinsics& k = (*source)->info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  Vec3f first;
  float way_mm = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const auto frame = (*source)->next(DepthImage(pixels.data(), k.width, k.height), 0);
    ASSERT_TRUE(frame) << frame.error().message;
    ASSERT_TRUE(frame->pose);
    const auto& hip = truth["frames"][i]["joints"]["LH"];
    const Vec3f seen = {hip[0].get<float>(), hip[1].get<float>(), hip[2].get<float>()};
    const hal::CameraPose& q = *frame->pose;
    const Vec3f axis = {q.x, q.y, q.z};
    const Vec3f hip_mm = seen + cross(axis, cross(axis, seen) + seen * q.w) * 2 + q.position_mm;
    if (i == 0) first = hip_mm;
    EXPECT_LT(norm(hip_mm - first), 60) << i;
    way_mm = std::max(way_mm, std::abs(q.position_mm.x));
  }
  EXPECT_GT(way_mm, 1000);
}

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

#if IM2FIT_TEST_ONI
// Whatever goes into a folder goes into a .oni: the same frames, numbers and words about them.
TEST_F(Record, AnOniHoldsWhatAFolderDoes) {
  std::filesystem::remove(folder_.path("in") + "/000007.pgm");
  std::filesystem::resize_file(folder_.path("in") + "/000011.pgm", 50);
  ASSERT_EQ(record(folder_.path("in"), folder_.path("first.oni"), {"--frames", "0"}).exit_code, 0);
  for (const auto& source : {folder_.path("in"), folder_.path("first.oni")}) {
    for (const std::string rotate : {"0", "90"}) {
      const std::string oni = folder_.path("r.oni"), plain = folder_.path("r"), copy = folder_.path("r.copy");
      std::filesystem::remove_all(plain);
      std::filesystem::remove_all(copy);
      const std::vector<std::string> words = {"--frames", "0", "--json", "--rotate", rotate};
      const auto into_oni = record(source, oni, words);
      const auto into_folder = record(source, plain, words);
      ASSERT_EQ(into_oni.exit_code, 0) << into_oni.err;
      ASSERT_EQ(into_folder.exit_code, 0) << into_folder.err;
      auto reported = nlohmann::json::parse(into_oni.out);
      auto expected = nlohmann::json::parse(into_folder.out);
      EXPECT_EQ(reported["path"], oni);
      reported.erase("path");
      expected.erase("path");
      EXPECT_EQ(reported, expected);
      ASSERT_EQ(record(oni, copy, {"--frames", "0"}).exit_code, 0);
      EXPECT_EQ(test::files_in(copy), test::files_in(plain));
      EXPECT_EQ(frame_files(copy), 28);
      for (const auto& name : test::files_in(plain)) {
        if (name.size() == 10) {
          EXPECT_EQ(test::read_text(copy + "/" + name), test::read_text(plain + "/" + name)) << name;
        }
      }
      EXPECT_EQ(matrix_of(oni + ".yaml"), matrix_of(plain + "/camera.yaml"));
    }
  }
}

TEST_F(Record, AFullDiskLeavesAWholeOniOfTheFramesBefore) {
  test::RunOptions options;
  options.file_bytes_max = 60'000;  // a picture of one depth takes 2.6 kB
  const std::string out = folder_.path("out.oni");
  const auto run = record(folder_.path("in"), out, {"--frames", "0"}, options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_NE(run.err.find("free some space"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(out + ".part"));
  EXPECT_TRUE(std::filesystem::exists(out + ".yaml"));
  const int frames = frames_read(out);
  EXPECT_GT(frames, 10);
  EXPECT_LT(frames, 30);
  EXPECT_NE(run.err.find(out + " holds the " + std::to_string(frames) + " frames before"), std::string::npos)
      << run.err;
}

TEST_F(Record, AFullFileSystemLeavesAWholeOniOfTheFramesBefore) {
  const std::string disk = folder_.path("disk");
  std::filesystem::create_directories(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "no right to mount a small disk";
  const auto run = record(folder_.path("in"), disk + "/out.oni", {"--frames", "0"});
  const int frames = std::filesystem::exists(disk + "/out.oni") ? frames_read(disk + "/out.oni") : 0;
  const auto left = test::files_in(disk);
  ::umount(disk.c_str());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_NE(run.err.find("No space left"), std::string::npos) << run.err;
  EXPECT_GT(frames, 0);
  EXPECT_EQ(left.size(), 2U) << "the recording and its calibration";
}

TEST_F(Record, AnOniThatWasNeverClosedIsNotOverwritten) {
  test::write_text(folder_.path("out.oni.part"), "what was saved of an earlier recording");
  const auto run = record(folder_.path("in"), folder_.path("out.oni"));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  EXPECT_EQ(test::read_text(folder_.path("out.oni.part")), "what was saved of an earlier recording");
}
#endif

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
// Records until `recorded` returns true, then kills.
void record_until_killed(std::string source, std::string out, const std::function<bool()>& recorded) {
  std::string program = test::kProgram, verb = "record", flag = "--out", count = "--frames", all = "0";
  std::vector<char*> argv = {program.data(), verb.data(),  source.data(), flag.data(),
                             out.data(),     count.data(), all.data(),    nullptr};
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    test::detail::become(argv, null, null, {});
  }
  const auto end = test::Clock::now() + test::kPatience;
  while (test::Clock::now() < end && !recorded()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

// Killed in mid-recording, again and again: whatever instant it was, the folder is a recording.
TEST_F(Record, AKillLeavesARecordingUpToTheLastFrame) {
  for (const int after : {1, 4, 9}) {
    const std::string out = folder_.path("out" + std::to_string(after));
    record_until_killed(camera("&fps=60"), out,
                        [&] { return std::filesystem::exists(out) && frame_files(out) >= after; });
    const int files = frame_files(out);
    EXPECT_GE(files, after);
    EXPECT_EQ(frames_read(out), files);
  }
}

TEST_F(Record, APulledCableIsWaitedForAndCounted) {
  for (const std::string kind : {"", ".oni"}) {
    const std::string out = folder_.path("out" + kind);
    const auto run = record(camera("&fps=30&unplug_ms=600&replug_ms=200"), out, {"--frames", "40", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto summary = nlohmann::json::parse(run.out);
    EXPECT_EQ(summary["frames"], 40);
    EXPECT_GE(summary["losses"].get<int>(), 1);
    EXPECT_GE(summary["missing"].get<int>(), 1);
    EXPECT_EQ(summary["complete"], false);
    EXPECT_NE(run.err.find("is away"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("is back"), std::string::npos) << run.err;
    EXPECT_EQ(frames_read(out), 40);
    const std::string strict_out = folder_.path("strict" + kind);
    const auto strict = record(camera("&fps=30&unplug_ms=600"), strict_out, {"--frames", "0", "--reconnect", "0"});
    EXPECT_EQ(strict.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(strict.err, "im2fit")) << strict.err;
    EXPECT_NE(
        strict.err.find(strict_out + " holds the " + std::to_string(frames_read(strict_out)) + " frames before"),
        std::string::npos)
        << strict.err;
  }
}

// The file gets its name once it is whole; a kill leaves it and its calibration under their working names.
TEST_F(Record, AKilledOniPlaysToItsLastFrame) {
  for (const std::uintmax_t bytes : {4'000U, 20'000U, 60'000U}) {
    const std::string out = folder_.path("killed" + std::to_string(bytes) + ".oni");
    record_until_killed(camera("&fps=60"), out, [&] {
      std::error_code none;
      const auto size = std::filesystem::file_size(out + ".part", none);
      return !none && size > bytes;
    });
    EXPECT_FALSE(std::filesystem::exists(out));
    ASSERT_TRUE(std::filesystem::exists(out + ".part"));
    std::filesystem::rename(out + ".part", out);
    std::filesystem::rename(out + ".part.yaml", out + ".yaml");
    const auto frames = static_cast<std::uintmax_t>(frames_read(out));
    // But for the frame that was being written.
    EXPECT_GE((frames + 1) * kFrameBytesMax, bytes - kHeadBytesMax) << "nothing that was on the disk is lost";
    const auto copied = test::read_text(folder_.path("copy" + std::to_string(copies_)) + "/camera.yaml");
    EXPECT_NE(copied.find("field_of_view"), std::string::npos) << "the origin its calibration tells";
  }
}
#endif

}  // namespace
}  // namespace im2fit
