// SPDX-License-Identifier: Apache-2.0
// What our writer records, OpenNI2's own player gives back.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>
#include <map>

#include "core/file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/open/open.h"
#include "hal/openni2/oni_reader.h"
#include "hal/openni2/oni_source.h"
#include "hal/openni2/oni_writer.h"
#include "hard_pictures.h"
#include "known_pictures.h"

namespace im2fit::hal {
namespace {

std::int64_t time_us(std::size_t i) {
  return 1'000'000 + static_cast<std::int64_t>(i) * 1'000'000 / 30;
}

bool has_children() {
  return ::waitpid(-1, nullptr, WNOHANG) >= 0;
}

// Records a clip; frame i has the sequence number first + i and comes i / 30 s after 1 s.
void record(const std::string& oni, const std::vector<Picture>& pictures, std::uint64_t first = 0) {
  const Picture& any = pictures.front();
  auto writer = OniWriter::create(oni, centred(any.width, any.height), {"known", IntrinsicsOrigin::field_of_view});
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    ASSERT_TRUE((*writer)->write(pictures[i].view(), {first + i, 0, time_us(i)}));
  const auto finished = (*writer)->finish();
  ASSERT_TRUE(finished) << finished.error().message;
}

std::vector<Picture> known_pictures() {
  std::vector<Picture> pictures;
  for (int i = 0; i < kPictures; ++i) pictures.push_back(known(i));
  return pictures;
}

class Recorded : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    record(oni(), known_pictures());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string oni() { return folder_->path("known.oni"); }
  static TestFolder* folder_;
};
TestFolder* Recorded::folder_ = nullptr;

TEST_F(Recorded, EveryFrameOfAnOniComesBackBitForBit) {
  for (const int rotate_deg : {0, 270}) {
    OpenOptions options;
    options.rotate_deg = rotate_deg;
    auto source = open_source(oni(), options);
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_TRUE((*source)->start());
    const Intrinsics truth = rotate_upright(centred(kWidth, kHeight), rotate_deg);
    EXPECT_EQ((*source)->info().intrinsics.fx, truth.fx);
    EXPECT_EQ((*source)->info().intrinsics.cy, truth.cy);
    EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);
    EXPECT_EQ((*source)->info().frame_count, kPictures);
    Picture out(truth.width, truth.height);
    Picture expected(truth.width, truth.height);
    for (int i = 0; i < kPictures; ++i) {
      const auto frame = (*source)->next(out.image(), 10'000);
      ASSERT_TRUE(frame) << frame.error().message;
      rotate_upright(known(i).view(), rotate_deg, expected.image());
      ASSERT_EQ(out.pixels, expected.pixels) << "frame " << i;
      EXPECT_EQ(frame->sequence, static_cast<std::uint64_t>(i + 1));
      EXPECT_EQ(frame->device_us, time_us(static_cast<std::size_t>(i)));
    }
    EXPECT_EQ((*source)->next(out.image(), 10'000).error().code, ErrorCode::end_of_stream);
    EXPECT_EQ((*source)->stats().gaps, 0U);
  }
}

// 194 pictures a clip, 45 of them noisy, each through the runtime's decoder.
TEST_F(Recorded, PicturesThatAreHardToKeepComeBackBitForBit) {
  for (const auto& [width, height] : {std::pair{320, 240}, {640, 480}, {480, 640}}) {
    const auto pictures = hard_pictures(width, height);
    const std::string path = folder_->path("hard" + std::to_string(width) + ".oni");
    record(path, pictures, 17);
    auto source = open_source(path);
    ASSERT_TRUE(source) << source.error().message;
    Picture out(width, height);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const auto frame = (*source)->next(out.image(), 10'000);
      ASSERT_TRUE(frame) << frame.error().message;
      ASSERT_EQ(out.pixels, pictures[i].pixels) << width << "x" << height << ", frame " << i;
      ASSERT_EQ(frame->device_us, time_us(i));
    }
    EXPECT_EQ((*source)->next(out.image(), 10'000).error().code, ErrorCode::end_of_stream);
    std::filesystem::remove(path);
  }
}

TEST_F(Recorded, MissingNumbersStayMissing) {
  const std::uint64_t sequence[] = {100, 101, 104, 105, 112};
  auto writer = OniWriter::create(folder_->path("gaps.oni"), centred(kWidth, kHeight), {});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE((*writer)->write(known(i).view(), {sequence[i], 0, 40'000 * i}));
  ASSERT_TRUE((*writer)->finish());
  auto source = open_source(folder_->path("gaps.oni"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 5; ++i) {
    const auto frame = (*source)->next(out.image(), 10'000);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->sequence, sequence[i] - 99);
    EXPECT_EQ(out.pixels, known(i).pixels);
  }
  EXPECT_EQ((*source)->next(out.image(), 10'000).error().code, ErrorCode::end_of_stream);
  EXPECT_EQ((*source)->stats().gaps, 8U);
}

// What other OpenNI2 programs see: with no calibration beside it, the field of view.
TEST_F(Recorded, WithoutItsCalibrationTheFieldOfViewTells) {
  const std::string path = folder_->path("alone.oni");
  std::filesystem::copy_file(oni(), path);
  const auto source = open_source(path);
  ASSERT_TRUE(source) << source.error().message;
  const Intrinsics truth = centred(kWidth, kHeight);
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);
  EXPECT_NEAR((*source)->info().intrinsics.fx, truth.fx, 1e-3);
  EXPECT_NEAR((*source)->info().intrinsics.fy, truth.fy, 1e-3);
}

TEST_F(Recorded, TheSidecarAndACalibrationOfTheUsersWinOverTheFieldOfView) {
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
  EXPECT_TRUE(contains(frame.error().message, "delivered no frame for 400 ms")) << frame.error().message;
  EXPECT_FALSE(has_children());
}

TEST_F(Recorded, AReaderThatTalksNonsenseIsRefused) {
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
  auto writer = OniWriter::create(folder_->path("open.oni"), centred(kWidth, kHeight), {});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE((*writer)->write(known(i).view(), {static_cast<std::uint64_t>(i), 0, i}));
  // As a kill leaves them: after a frame, and in the middle of one.
  std::filesystem::copy_file(folder_->path("open.oni.part"), folder_->path("killed.oni"));
  std::filesystem::copy_file(folder_->path("open.oni.part"), folder_->path("torn.oni"));
  const auto size = std::filesystem::file_size(folder_->path("torn.oni"));
  std::filesystem::resize_file(folder_->path("torn.oni"), size - 1000);
  for (const auto& [name, frames] : {std::pair{"killed.oni", 10}, {"torn.oni", 9}}) {
    auto source = open_source(folder_->path(name));
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->info().frame_count, -1);
    Picture out(kWidth, kHeight);
    int count = 0;
    Result<FrameInfo> frame = Error{};
    while ((frame = (*source)->next(out.image(), 10'000))) EXPECT_EQ(out.pixels, known(count++).pixels);
    EXPECT_EQ(count, frames);
    EXPECT_EQ(frame.error().code, ErrorCode::corrupt) << frame.error().message;
    EXPECT_TRUE(contains(frame.error().message, "never closed")) << frame.error().message;
    EXPECT_EQ((*source)->next(out.image(), 10).error().code, ErrorCode::end_of_stream);
  }
}

// Fifty recordings, each cut or with a few bytes changed. Whatever the runtime does with them in the child, the
// parent gets frames and then one error or the end.
TEST_F(Recorded, DamagedRecordingsNeverHarmTheReadersProgram) {
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

TEST_F(Recorded, WhatIsNoRecordingIsRefused) {
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

}  // namespace
}  // namespace im2fit::hal
