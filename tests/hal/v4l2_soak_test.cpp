// SPDX-License-Identifier: Apache-2.0
// Very many frames through the V4L2 source, from a device in the process (the kernel's own drivers:
// scripts/firmware-test
// --soak).
#include <gtest/gtest.h>

#include <cstring>

#include "hal/v4l2/v4l2_source.h"
#include "tests/hal/fake_video_device.h"
#include "tests/hal/long_run.h"
#include "tests/hal/support.h"

namespace im2fit::hal {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr std::size_t kPictures = 30;

TEST(V4l2Soak, EveryFrameIsWholeAndItsTimeNeverDrifts) {
  FakeVideo fake;
  fake.formats[0].sizes = {{kWidth, kHeight}};
  V4l2Options options;
  options.path = "/dev/video7";
  options.hfov_deg = 60.0F;
  options.width = kWidth;
  options.height = kHeight;
  auto source = V4l2Source::open(std::make_unique<FakeVideoDevice>(fake), options.path, options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < kPictures; ++i) pictures.push_back(random_picture(kWidth, kHeight, i));
  Picture out(kWidth, kHeight);
  const int frames = frames_to_test("IM2FIT_V4L2_FRAMES");
  const std::uint32_t first = 0xFFFFFFFF - static_cast<std::uint32_t>(frames / 2);  // wraps within the test
  constexpr std::int64_t kStart_us = 5'000'000;
  Growth growth(frames);
  for (int n = 0; n < frames; ++n) {
    growth.saw(n);
    const Picture& sent = pictures[static_cast<std::size_t>(n) % kPictures];
    FakeVideo::Event event;
    event.bytes.resize(sent.pixels.size() * 2);
    std::memcpy(event.bytes.data(), sent.pixels.data(), event.bytes.size());
    event.sequence = first + static_cast<std::uint32_t>(n);
    event.time_us = kStart_us + std::int64_t{n} * 100'000 / 3;
    fake.events.push_back(std::move(event));
    const auto got = (*source)->next(out.image(), 0);
    ASSERT_TRUE(got) << "frame " << n << ": " << got.error().message;
    ASSERT_EQ(out.pixels, sent.pixels) << "frame " << n;
    ASSERT_EQ(got->sequence, first + static_cast<std::uint64_t>(n));
    ASSERT_EQ(got->host_ns, (kStart_us + std::int64_t{n} * 100'000 / 3) * 1000);
  }
  growth.expect_none();
  const SourceStats stats = (*source)->stats();
  EXPECT_EQ(stats.delivered, static_cast<std::uint64_t>(frames));
  EXPECT_EQ(stats.gaps + stats.repeats + stats.damaged, 0U);
  EXPECT_EQ(fake.queued.size(), 4U) << "buffers are missing";
}

}  // namespace
}  // namespace im2fit::hal
