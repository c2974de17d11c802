// SPDX-License-Identifier: Apache-2.0
// Through the real OpenNI2 runtime: our virtual device shows folders of known pictures.
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/intrinsics.h"
#include "hal/open/open.h"
#include "hal/openni2/openni2_source.h"
#include "hal/openni2/raw_frame.h"
#include "known_pictures.h"
#include "support.h"

namespace im2fit::hal {
namespace {

// Begun once for all tests, ended before the program's statics are.
class HoldRuntime : public testing::Environment {
 public:
  void SetUp() override {
    auto runtime = OpenNi2Runtime::get();
    if (runtime) runtime_ = *runtime;
  }
  void TearDown() override { runtime_.reset(); }

 private:
  std::shared_ptr<OpenNi2Runtime> runtime_;
};
[[maybe_unused]] const auto* const hold_runtime = testing::AddGlobalTestEnvironment(new HoldRuntime);

TEST(OpenNi2, TheVirtualDeviceGivesItsPicturesAndIntrinsics) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  for (const int rotate_deg : {0, 90}) {
    OpenOptions options;
    options.rotate_deg = rotate_deg;
    auto source = open_source("openni2:" + virtual_uri(folder.path("known"), "&fps=60"), options);
    ASSERT_TRUE(source) << source.error().message;
    const SourceInfo info = (*source)->info();
    EXPECT_TRUE(info.live);
    EXPECT_EQ(info.name, "im2fit virtual depth camera");
    EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::field_of_view);
    const Intrinsics truth = rotate_upright(centred(kWidth, kHeight), rotate_deg);
    EXPECT_EQ(info.intrinsics.width, truth.width);
    EXPECT_NEAR(info.intrinsics.fx, truth.fx, 0.01);
    EXPECT_NEAR(info.intrinsics.fy, truth.fy, 0.01);
    EXPECT_NEAR(info.intrinsics.cx, truth.cx, 0.01);
    EXPECT_NEAR(info.intrinsics.cy, truth.cy, 0.01);
    ASSERT_TRUE((*source)->start());
    Picture out(truth.width, truth.height);
    Picture expected(truth.width, truth.height);
    std::int64_t last_us = -1;
    for (int i = 0; i < 20; ++i) {
      const auto frame = (*source)->next(out.image(), 5000);
      ASSERT_TRUE(frame) << frame.error().message;
      rotate_upright(known(static_cast<int>(frame->sequence - 1) % kPictures).view(), rotate_deg, expected.image());
      EXPECT_EQ(out.pixels, expected.pixels);
      EXPECT_GT(frame->device_us, last_us);
      last_us = frame->device_us;
    }
    (*source)->stop();
    EXPECT_EQ((*source)->stats().delivered, 20U);
  }
}

TEST(OpenNi2, HundredMicrometresAreRoundedToMillimetres) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  OpenNi2Options options;
  options.fine_units = true;
  auto source = OpenNi2Source::open(virtual_uri(folder.path("known")), options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  Picture out(kWidth, kHeight);
  const auto frame = (*source)->next(out.image(), 5000);
  ASSERT_TRUE(frame) << frame.error().message;
  Picture expected = known(static_cast<int>(frame->sequence - 1));
  for (auto& value : expected.pixels)
    if (value > 6553) value = 0;  // beyond 16 bits of 100 um
  EXPECT_EQ(out.pixels, expected.pixels);
}

TEST(OpenNi2, ADeviceThatIsNotThereIsOneClearError) {
  NEED_VIRTUAL_DEVICE();
  for (const char* uri : {"openni2:1d27/0600@1/4", "openni2:im2fit-virtual://x?rotate=7",
                          "openni2:im2fit-virtual://1?folder=/nowhere/at/all"}) {
    const auto source = open_source(uri);
    ASSERT_FALSE(source) << uri;
    EXPECT_EQ(source.error().code, ErrorCode::no_device);
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
  }
  EXPECT_TRUE(contains(open_source("openni2:im2fit-virtual://1?folder=/nowhere/at/all").error().message, "/nowhere"));
}

TEST(OpenNi2, PullingTheCableIsReportedAsNoDevice) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  auto source = OpenNi2Source::open(virtual_uri(folder.path("known"), "&unplug_ms=300"), {});
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  Picture out(kWidth, kHeight);
  ErrorCode code = ErrorCode::invalid_argument;
  for (int i = 0; i < 1000; ++i) {
    const auto frame = (*source)->next(out.image(), 10'000);
    if (frame) continue;
    code = frame.error().code;
    break;
  }
  EXPECT_EQ(code, ErrorCode::no_device);
  EXPECT_GT((*source)->stats().delivered, 0U);
  EXPECT_EQ((*source)->next(out.image(), 10).error().code, ErrorCode::no_device) << "it stays lost";
}

// As a USB camera does, it comes back under another URI; its serial shows that it is the same.
TEST(OpenNi2, PluggedInAgainItGoesOnTwentyTimes) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  std::vector<std::int64_t> away_ms;
  ReconnectOptions patient;
  patient.changed = [&](const ReconnectStats& stats) {
    if (stats.presence == Presence::present) away_ms.push_back(stats.lost_ns / 1'000'000);
  };
  auto source = open_reconnecting(
      "openni2:" + virtual_uri(folder.path("known"), "&fps=100&unplug_ms=150&replug_ms=100"), {}, patient);
  ASSERT_TRUE(source) << source.error().message;
  const std::string serial = (*source)->info().serial;
  ASSERT_TRUE((*source)->start());
  Picture out(kWidth, kHeight);
  std::uint64_t last = 0;
  int files = 0;
  int frames = 0;
  while (away_ms.size() < 20) {
    const auto frame = (*source)->next(out.image(), 5000);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_GT(frame->sequence, last);
    last = frame->sequence;
    ++frames;
    EXPECT_EQ(out.pixels, known((out.pixels.front() - 1) % kPictures).pixels);
    if (away_ms.size() == 2) files = open_files();
  }
  EXPECT_LE(open_files(), files);
  EXPECT_EQ((*source)->info().serial, serial);
  EXPECT_GE((*source)->stats().gaps, 20U);
  RecordProperty("frames", frames);
  RecordProperty("longest_away_ms", static_cast<int>(*std::max_element(away_ms.begin(), away_ms.end())));
}

TEST(OpenNi2, OpeningAndClosingManyTimesLeaksNoFile) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  Picture out(kWidth, kHeight);
  int after_first = 0;
  for (int i = 0; i < 8; ++i) {
    {
      auto source = OpenNi2Source::open(virtual_uri(folder.path("known"), "&fps=200"), {});
      ASSERT_TRUE(source) << source.error().message;
      ASSERT_TRUE((*source)->start());
      ASSERT_TRUE((*source)->next(out.image(), 5000));
    }
    if (i == 0) after_first = open_files();
  }
  EXPECT_EQ(open_files(), after_first);
}

TEST(RawFrame, CropsMirrorsAndUnitsAreUndone) {
  const std::uint16_t data[] = {10, 20, 99, 34, 44, 99};  // 2 x 2 with a padded stride
  Picture out(4, 3);
  out.pixels.assign(out.pixels.size(), 7);
  RawFrame frame{data, sizeof data, 2, 2, 6, 1, 1, 1000, false};
  ASSERT_TRUE(copy_raw_frame(frame, out.image()));
  EXPECT_EQ(out.pixels, (std::vector<std::uint16_t>{0, 0, 0, 0, 0, 10, 20, 0, 0, 34, 44, 0}));
  frame.crop_x = 0;
  frame.mirrored = true;
  frame.unit_um = 100;
  ASSERT_TRUE(copy_raw_frame(frame, out.image()));
  EXPECT_EQ(out.pixels, (std::vector<std::uint16_t>{0, 0, 0, 0, 0, 0, 2, 1, 0, 0, 4, 3}));
}

TEST(RawFrame, SizesThatDoNotFitAreRefused) {
  std::vector<std::uint16_t> data(12);
  Picture out(4, 3);
  const RawFrame good{data.data(), 24, 4, 3, 8, 0, 0, 1000, false};
  ASSERT_TRUE(copy_raw_frame(good, out.image()));
  const auto refused = [&](auto change) {
    RawFrame bad = good;
    change(bad);
    return !copy_raw_frame(bad, out.image());
  };
  EXPECT_TRUE(refused([](RawFrame& f) { f.data = nullptr; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.size_bytes = 23; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.width = 5; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.height = 4; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.height = 0; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.crop_x = 1; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.crop_y = -1; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.stride_bytes = 6; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.stride_bytes = 1 << 30; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.unit_um = 1; }));
}

}  // namespace
}  // namespace im2fit::hal
