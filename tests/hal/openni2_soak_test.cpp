// SPDX-License-Identifier: Apache-2.0
// Very many frames through the real OpenNI2 runtime, a thousand a second.
#include <gtest/gtest.h>

#include "hal/openni2/openni2_source.h"
#include "known_pictures.h"
#include "tests/hal/long_run.h"

namespace im2fit::hal {
namespace {

constexpr std::int64_t kPeriod_us = 1000;

// On a machine that is busy the runtime leaves frames out, as with a camera: they are counted. A delivered frame
// equals the camera's to the last pixel and microsecond.
TEST(OpenNi2Soak, EveryFrameIsWholeAndItsTimeNeverDrifts) {
  NEED_VIRTUAL_DEVICE();
  const TestFolder folder;
  make_known_folder(folder.path("known"));
  std::vector<Picture> pictures;
  for (int i = 0; i < kPictures; ++i) pictures.push_back(known(i));
  auto source = OpenNi2Source::open(virtual_uri(folder.path("known"), "&size=320x240&fps=1000"), {});
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  Picture out(kWidth, kHeight);
  const int frames = frames_to_test("IM2FIT_OPENNI2_FRAMES");
  Growth growth(frames);
  FrameInfo first, last;
  for (int n = 0; n < frames; ++n) {
    growth.saw(n);
    const auto got = (*source)->next(out.image(), 5000);
    ASSERT_TRUE(got) << "frame " << n << ": " << got.error().message;
    ASSERT_EQ(out.pixels, pictures[static_cast<std::size_t>(got->sequence - 1) % kPictures].pixels) << "frame " << n;
    if (n == 0) first = *got;
    if (n > 0) {
      ASSERT_GT(got->sequence, last.sequence);
      ASSERT_GT(got->host_ns, last.host_ns);
    }
    last = *got;
    ASSERT_EQ(got->device_us - first.device_us,
              static_cast<std::int64_t>(got->sequence - first.sequence) * kPeriod_us);
  }
  growth.expect_none();
  const SourceStats stats = (*source)->stats();
  EXPECT_EQ(stats.delivered, static_cast<std::uint64_t>(frames));
  EXPECT_EQ(stats.delivered + stats.gaps, last.sequence - first.sequence + 1) << "frames are missing in the books";
  EXPECT_EQ(stats.repeats + stats.damaged, 0U);
  // The device never shows a picture before its time: arrivals cannot be closer together than the camera's clock
  // says, but for the first one's own lateness.
  const std::int64_t device_ns = (last.device_us - first.device_us) * 1000;
  EXPECT_GE(last.host_ns - first.host_ns, device_ns - 100'000'000);
  RecordProperty("gaps", static_cast<int>(stats.gaps));
  RecordProperty("late_us", static_cast<int>((last.host_ns - first.host_ns - device_ns) / 1000));
}

}  // namespace
}  // namespace im2fit::hal
