// SPDX-License-Identifier: Apache-2.0
// What our virtual OpenNI2 device shows, the runtime's recorder writes, and its player reads back.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <thread>

#include "base/file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_folder.h"
#include "hal/intrinsics.h"
#include "hal/open/open.h"
#include "hal/openni2/oni_file.h"
#include "hal/openni2/oni_reader.h"
#include "hal/openni2/oni_source.h"
#include "hal/openni2/openni2_source.h"
#include "known_pictures.h"

namespace im2fit::hal {
namespace {

bool has_children() {
  return ::waitpid(-1, nullptr, WNOHANG) >= 0;
}

// Records `count` frames of a known folder; returns how many next() gave.
int record_known(const std::string& folder, const std::string& oni, int count) {
  auto camera = OpenNi2Source::open(virtual_uri(folder, "&fps=120"), {});
  EXPECT_TRUE(camera) << camera.error().message;
  if (!camera) return 0;
  EXPECT_TRUE((*camera)->begin_recording(oni));
  EXPECT_TRUE((*camera)->start());
  Picture out(kWidth, kHeight);
  int seen = 0;
  for (; seen < count; ++seen) {
    const auto frame = (*camera)->next(out.image(), 5000);
    EXPECT_TRUE(frame) << frame.error().message;
    if (!frame) break;
    const int number = static_cast<int>((frame->sequence - 1) % kPictures);
    EXPECT_EQ(out.pixels, known(number).pixels);
  }
  (*camera)->stop();
  const auto summary = (*camera)->end_recording();
  EXPECT_TRUE(summary) << summary.error().message;
  if (summary) {
    EXPECT_EQ(summary->pixels_beyond_range, 0U);
  }
  return seen;
}

class Recorded : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!have_virtual_device()) return;
    folder_ = new TestFolder;
    make_known_folder(folder_->path("known"));
    seen_ = record_known(folder_->path("known"), oni(), kPictures);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string oni() { return folder_->path("known.oni"); }
  static TestFolder* folder_;
  static int seen_;
};
TestFolder* Recorded::folder_ = nullptr;
int Recorded::seen_ = 0;

TEST_F(Recorded, EveryFrameOfAnOniComesBackBitForBit) {
  NEED_VIRTUAL_DEVICE();
  for (const int rotate_deg : {0, 270}) {
    OpenOptions options;
    options.rotate_deg = rotate_deg;
    auto source = open_source(oni(), options);
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_TRUE((*source)->start());
    const Intrinsics truth = rotate_upright(centred(kWidth, kHeight), rotate_deg);
    EXPECT_NEAR((*source)->info().intrinsics.fx, truth.fx, 0.01);
    EXPECT_NEAR((*source)->info().intrinsics.fy, truth.fy, 0.01);
    EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);
    EXPECT_GE((*source)->info().frame_count, seen_);
    Picture out(truth.width, truth.height);
    Picture expected(truth.width, truth.height);
    int count = 0;
    int first = -1;
    std::int64_t last_us = -1;
    for (;; ++count) {
      const auto frame = (*source)->next(out.image(), 10'000);
      if (!frame) {
        EXPECT_EQ(frame.error().code, ErrorCode::end_of_stream) << frame.error().message;
        break;
      }
      if (first < 0) {
        Picture upright(kWidth, kHeight);
        rotate_upright(out.view(), (360 - rotate_deg) % 360, upright.image());
        first = upright.pixels.front() - 1;
      }
      rotate_upright(known((first + count) % kPictures).view(), rotate_deg, expected.image());
      ASSERT_EQ(out.pixels, expected.pixels) << "frame " << count;
      EXPECT_GT(frame->device_us, last_us);
      last_us = frame->device_us;
    }
    EXPECT_EQ(first, 0) << "the first frame is in the recording";
    EXPECT_GE(count, kPictures);
    EXPECT_EQ(count, (*source)->info().frame_count);
    EXPECT_EQ((*source)->stats().gaps, 0U);
    const auto contents = inspect_oni(oni());
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->frames, static_cast<std::uint64_t>(count));
    EXPECT_TRUE(contents->closed);
    RecordProperty("frames_bit_exact", count);
  }
}

TEST_F(Recorded, TheSidecarAndACalibrationOfTheUsersWinOverTheFieldOfView) {
  NEED_VIRTUAL_DEVICE();
  const auto sidecar = load_camera_yaml(oni_sidecar_path(oni()));
  ASSERT_TRUE(sidecar) << sidecar.error().message;
  EXPECT_EQ(sidecar->origin, IntrinsicsOrigin::field_of_view);
  Intrinsics mine = centred(kWidth, kHeight);
  mine.cx += 5;
  ASSERT_TRUE(write_file_atomically(folder_->path("mine.yaml"), yaml_of(mine, "mine", 180)));
  OpenOptions options;
  options.camera_yaml_path = folder_->path("mine.yaml");
  auto source = open_source(oni(), options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::calibration_file);
  EXPECT_EQ((*source)->info().rotate_deg, 180);
  EXPECT_EQ((*source)->info().intrinsics.cx, static_cast<float>(kWidth - 1) - mine.cx);
  ASSERT_TRUE(write_file_atomically(folder_->path("mine.yaml"), yaml_of(centred(640, 480), "other", 0)));
  EXPECT_EQ(open_source(oni(), options).error().code, ErrorCode::invalid_argument);
  options.camera_yaml_path = folder_->path("absent.yaml");
  EXPECT_EQ(open_source(oni(), options).error().code, ErrorCode::not_found);
}

TEST_F(Recorded, AnyChangedByteOfOurOwnRecordingIsSeen) {
  NEED_VIRTUAL_DEVICE();
  const auto good = read_file(oni());
  ASSERT_TRUE(good);
  const std::string path = folder_->path("changed.oni");
  std::filesystem::copy_file(oni_sidecar_path(oni()), oni_sidecar_path(path));
  ASSERT_TRUE(write_file_atomically(path, *good));
  EXPECT_TRUE(open_source(path));
  for (const std::size_t at : {std::size_t{30}, good->size() / 2, good->size() - 1}) {
    auto bytes = *good;
    bytes[at] ^= std::byte{1};
    ASSERT_TRUE(write_file_atomically(path, bytes));
    const auto source = open_source(path);
    ASSERT_FALSE(source) << at;
    EXPECT_EQ(source.error().code, ErrorCode::corrupt) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "changed.oni")) << source.error().message;
  }
}

// Where the reader program is missing the process forks itself.
TEST_F(Recorded, AForkOfTheProgramPlaysTheSameFrames) {
  NEED_VIRTUAL_DEVICE();
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the thread sanitizer does not follow a fork of a program with threads";
#endif
  if (std::getenv("IM2FIT_EMULATED") != nullptr)
    GTEST_SKIP() << "the emulator does not follow a fork of a program with threads";
  auto child = ChildProcess::fork([](int pipe) { return serve_oni(oni(), pipe); });
  ASSERT_TRUE(child) << child.error().message;
  const auto take = [&](void* to, std::size_t size) {
    for (std::size_t have = 0; have < size;) {
      std::size_t count = 0;
      const auto read = child->read(static_cast<char*>(to) + have, size - have, 20'000, count);
      if (read != ChildProcess::Read::some) return false;
      have += count;
    }
    return true;
  };
  oni::Header header;
  oni::Hello hello;
  ASSERT_TRUE(take(&header, sizeof header) && take(&hello, sizeof hello));
  EXPECT_EQ(hello.width, kWidth);
  for (int i = 0; i < hello.frame_count; ++i) {
    oni::Frame frame;
    Picture picture(kWidth, kHeight);
    ASSERT_TRUE(take(&header, sizeof header) && take(&frame, sizeof frame) &&
                take(picture.pixels.data(), picture.pixels.size() * 2));
    ASSERT_EQ(picture.pixels, known(i % kPictures).pixels);
  }
  oni::End end;
  ASSERT_TRUE(take(&header, sizeof header) && take(&end, sizeof end));
  EXPECT_EQ(end.complete, 1U);
  EXPECT_EQ(child->reap(), "exited with 0");
}

TEST_F(Recorded, StartPlaysFromTheFirstFrameAgain) {
  NEED_VIRTUAL_DEVICE();
  auto source = OniSource::open(oni(), {});
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE((*source)->start());
    for (int i = 0; i < 3; ++i) ASSERT_TRUE((*source)->next(out.image(), 10'000));
    EXPECT_EQ(out.pixels, known(2).pixels);
    (*source)->stop();
    EXPECT_EQ((*source)->next(out.image(), 10).error().code, ErrorCode::end_of_stream);
  }
}

TEST_F(Recorded, AKilledReaderIsOneClearErrorAndLeavesNothing) {
  NEED_VIRTUAL_DEVICE();
  const int files = open_files();
  {
    auto source = OniSource::open(oni(), {});
    ASSERT_TRUE(source) << source.error().message;
    Picture out(kWidth, kHeight);
    ASSERT_TRUE((*source)->next(out.image(), 10'000));
    ASSERT_EQ(::kill((*source)->child_pid(), SIGKILL), 0);
    Result<FrameInfo> frame = Error{};
    for (int i = 0; i < 100; ++i) {
      frame = (*source)->next(out.image(), 10'000);
      if (!frame) break;
    }
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, ErrorCode::io) << frame.error().message;
    EXPECT_TRUE(contains(frame.error().message, "signal 9")) << frame.error().message;
    EXPECT_EQ((*source)->next(out.image(), 10).error().message, frame.error().message);
  }
  EXPECT_EQ(open_files(), files);
  EXPECT_FALSE(has_children());
}

TEST_F(Recorded, ASilentReaderIsEndedByTheWatchdog) {
  NEED_VIRTUAL_DEVICE();
  OniOptions options;
  options.stall_ms = 400;
  auto source = OniSource::open(oni(), options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_EQ(::kill((*source)->child_pid(), SIGSTOP), 0);
  Picture out(kWidth, kHeight);
  Result<FrameInfo> frame = Error{ErrorCode::timeout, ""};
  for (int i = 0; i < 200 && (frame || frame.error().code == ErrorCode::timeout); ++i)
    frame = (*source)->next(out.image(), 100);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(frame.error().message, "gave nothing for 400 ms")) << frame.error().message;
  EXPECT_FALSE(has_children());
}

TEST_F(Recorded, AReaderThatTalksNonsenseIsRefused) {
  NEED_VIRTUAL_DEVICE();
  const auto script = [&](const std::string& name, const std::string& body) {
    const std::string path = folder_->path(name);
    EXPECT_TRUE(write_file_atomically(path, "#!/bin/sh\n" + body));
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    OniOptions options;
    options.reader_path = path;
    options.stall_ms = 500;
    return OniSource::open(oni(), options);
  };
  for (const char* body : {"exec cat /dev/urandom >&3\n", "exit 7\n", "sleep 60\n", "printf I2OR >&3; exit 0\n",
                           "printf 'I2OR\\001\\0\\0\\0\\377\\377\\377\\377\\0\\0\\0\\0' >&3; sleep 60\n"}) {
    const auto source = script("reader.sh", body);
    ASSERT_FALSE(source) << body;
    EXPECT_EQ(source.error().code, ErrorCode::corrupt) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "known.oni")) << source.error().message;
  }
  OniOptions absent;
  absent.reader_path = folder_->path("no-such-reader");
  EXPECT_FALSE(OniSource::open(oni(), absent));
}

TEST_F(Recorded, ARecordingThatWasNeverClosedGivesItsFramesAndSaysSo) {
  NEED_VIRTUAL_DEVICE();
  // As a killed recorder leaves it: the header still counts 2^32 - 1 frames.
  auto camera = OpenNi2Source::open(virtual_uri(folder_->path("known"), "&fps=120"), {});
  ASSERT_TRUE(camera);
  ASSERT_TRUE((*camera)->begin_recording(folder_->path("open.oni")));
  ASSERT_TRUE((*camera)->start());
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE((*camera)->next(out.image(), 5000));
  (*camera)->stop();
  // The runtime's recorder writes in a thread of its own, when it gets to it.
  const auto frames_written = [&] {
    std::filesystem::copy_file(folder_->path("open.oni.part"), folder_->path("killed.oni"),
                               std::filesystem::copy_options::overwrite_existing);
    const auto contents = inspect_oni(folder_->path("killed.oni"));
    if (contents) return static_cast<int>(contents->frames);
    const std::string& broken_off = contents.error().message;  // "... breaks off ..., after N frames"
    const auto after = broken_off.rfind("after ");
    return after == std::string::npos ? 0 : std::stoi(broken_off.substr(after + 6));
  };
  for (int i = 0; i < 300 && frames_written() < 8; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_GE(frames_written(), 8);
  ASSERT_TRUE((*camera)->end_recording());
  auto source = open_source(folder_->path("killed.oni"));
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().frame_count, -1);
  int count = 0;
  Result<FrameInfo> frame = Error{};
  while ((frame = (*source)->next(out.image(), 10'000))) EXPECT_EQ(out.pixels, known(count++).pixels);
  EXPECT_GE(count, 8);
  EXPECT_EQ(frame.error().code, ErrorCode::corrupt) << frame.error().message;
  EXPECT_TRUE(contains(frame.error().message, "never closed")) << frame.error().message;
  EXPECT_EQ((*source)->next(out.image(), 10).error().code, ErrorCode::end_of_stream);
}

// Fifty recordings, each cut or with a few bytes changed. Whatever the runtime does with them in the child, the
// parent gets frames and then one error or the end.
TEST_F(Recorded, DamagedRecordingsNeverHarmTheReadersProgram) {
  NEED_VIRTUAL_DEVICE();
  const auto good = read_file(oni());
  ASSERT_TRUE(good);
  const int files = open_files();
  const std::string path = folder_->path("damaged.oni");
  Rng rng(20240501);
  std::map<std::string, int> outcomes;
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 50; ++i) {
    auto bytes = *good;
    const int size = static_cast<int>(bytes.size());
    if (i % 5 == 0) {
      bytes.resize(static_cast<std::size_t>(rng.index(size)));
    } else {
      // Half of the changes near the beginning and the end, where the file's structure is.
      const int low = i % 5 == 1 ? 0 : i % 5 == 2 ? size - 2000 : 0;
      const int range = i % 5 <= 2 ? 2000 : size;
      for (int n = 0; n < 8; ++n)
        bytes[static_cast<std::size_t>(low + rng.index(range))] ^= static_cast<std::byte>(1 + rng.index(255));
    }
    ASSERT_TRUE(write_file_atomically(path, bytes));
    OniOptions options;
    options.stall_ms = 1500;
    auto source = OniSource::open(path, options);
    if (!source) {
      ++outcomes["refused"];
      EXPECT_FALSE(contains(source.error().message, "\n"));
      EXPECT_TRUE(contains(source.error().message, "damaged.oni")) << source.error().message;
      continue;
    }
    if ((*source)->info().intrinsics.width != kWidth || (*source)->info().intrinsics.height != kHeight) {
      ++outcomes["other size"];
      continue;
    }
    Result<FrameInfo> frame = Error{};
    int count = 0;
    for (; count < 1000; ++count) {
      frame = (*source)->next(out.image(), 10'000);
      if (!frame && frame.error().code != ErrorCode::timeout) break;
    }
    ASSERT_FALSE(frame) << "more frames than were recorded";
    ++outcomes[frame.error().code == ErrorCode::end_of_stream ? "played" : "stopped with an error"];
  }
  EXPECT_EQ(open_files(), files);
  EXPECT_FALSE(has_children());
  EXPECT_GT(outcomes["refused"] + outcomes["stopped with an error"], 0);
  for (const auto& [name, count] : outcomes) {
    std::printf("damaged recordings: %d %s\n", count, name.c_str());
    RecordProperty(name, count);
  }
}

TEST_F(Recorded, EveryCutOfARecordingIsSeenByItsStructure) {
  NEED_VIRTUAL_DEVICE();
  const std::string path = folder_->path("cut.oni");
  std::filesystem::copy_file(oni(), path);
  Rng rng(7);
  for (auto size = std::filesystem::file_size(path); size > 0;) {
    size -= std::min<std::uintmax_t>(size, 1 + static_cast<std::uintmax_t>(rng.index(200'000)));
    std::filesystem::resize_file(path, size);
    const auto contents = inspect_oni(path);
    EXPECT_FALSE(contents && contents->closed) << size;
  }
}

TEST_F(Recorded, WhatIsNoRecordingIsRefused) {
  NEED_VIRTUAL_DEVICE();
  for (const auto& [name, text] : {std::pair<const char*, std::string>{"empty.oni", ""},
                                   {"text.oni", "hello"},
                                   {"zeros.oni", std::string(9999, '\0')}}) {
    ASSERT_TRUE(write_file_atomically(folder_->path(name), text));
    const auto source = open_source(folder_->path(name));
    ASSERT_FALSE(source) << name;
    EXPECT_EQ(source.error().code, ErrorCode::corrupt) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, name)) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "does not take it for a recording")) << source.error().message;
  }
}

TEST_F(Recorded, ARecordingThatCannotBeWrittenLeavesNothingBehind) {
  NEED_VIRTUAL_DEVICE();
  auto camera = OpenNi2Source::open(virtual_uri(folder_->path("known"), "&fps=120"), {});
  ASSERT_TRUE(camera);
  const auto nowhere = (*camera)->begin_recording(folder_->path("no/such/folder/x.oni"));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(nowhere.error().message, "x.oni")) << nowhere.error().message;
  // The file-size limit stands in for a full disk.
  rlimit was{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &was), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{200'000, was.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  ASSERT_TRUE((*camera)->begin_recording(folder_->path("full.oni")));
  ASSERT_TRUE((*camera)->start());
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE((*camera)->next(out.image(), 5000));
  (*camera)->stop();
  const auto summary = (*camera)->end_recording();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &was), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::io);
  EXPECT_TRUE(contains(summary.error().message, "is the disk full?")) << summary.error().message;
  for (const char* name : {"full.oni", "full.oni.part", "full.oni.yaml"})
    EXPECT_FALSE(std::filesystem::exists(folder_->path(name))) << name;
}

}  // namespace
}  // namespace im2fit::hal
