// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "hal/depth16.h"
#include "hal/v4l2/v4l2_source.h"
#include "tests/hal/fake_video_device.h"
#include "tests/hal/support.h"

namespace im2fit::hal {
namespace {

using testing::HasSubstr;

V4l2Options with_angle(int width = 4, int height = 3) {
  V4l2Options options;
  options.path = "/dev/video7";
  options.hfov_deg = 60.0F;
  options.width = width;
  options.height = height;
  return options;
}

FakeVideo small_camera() {
  FakeVideo fake;
  fake.formats[0].sizes = {{4, 3}};
  return fake;
}

Result<std::unique_ptr<V4l2Source>> open(FakeVideo& fake, const V4l2Options& options) {
  return V4l2Source::open(std::make_unique<FakeVideoDevice>(fake), "/dev/video7", options);
}

// The picture's rows of 16-bit little-endian values, `padding` bytes of 0xEE behind each.
std::vector<std::byte> bytes_of(const Picture& picture, std::size_t padding = 0) {
  std::vector<std::byte> bytes;
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      const std::uint16_t value = picture.pixels[static_cast<std::size_t>(v * picture.width + u)];
      bytes.push_back(static_cast<std::byte>(value & 0xFF));
      bytes.push_back(static_cast<std::byte>(value >> 8));
    }
    bytes.insert(bytes.end(), padding, std::byte{0xEE});
  }
  return bytes;
}

Picture counting(int width, int height, int first = 1000) {
  Picture picture(width, height);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] = static_cast<std::uint16_t>(first + static_cast<int>(i));
  return picture;
}

FakeVideo::Event frame(std::vector<std::byte> bytes, std::uint32_t sequence = 0) {
  FakeVideo::Event event;
  event.bytes = std::move(bytes);
  event.sequence = sequence;
  return event;
}

TEST(V4l2, DeliversTheBuffersPixelsTimeAndNumber) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().uri, "v4l2:/dev/video7?hfov=60&size=4x3");
  EXPECT_EQ((*source)->info().name, "Fake depth");
  EXPECT_TRUE((*source)->info().live);
  ASSERT_TRUE((*source)->start());
  EXPECT_EQ(fake.queued.size(), 4U);
  const Picture sent = counting(4, 3);
  fake.events.push_back(frame(bytes_of(sent), 41));
  fake.events.back().time_us = 12'345'678;
  Picture got(4, 3);
  const auto info = (*source)->next(got.image(), 100);
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(got.pixels, sent.pixels);
  EXPECT_EQ(info->sequence, 41U);
  EXPECT_EQ(info->host_ns, 12'345'678'000);
  EXPECT_EQ(info->device_us, -1);
  EXPECT_EQ(fake.queued.size(), 4U) << "the buffer goes back to the driver";
  (*source)->stop();
  EXPECT_FALSE(fake.streaming);
  EXPECT_EQ(fake.mapped, 0);
}

TEST(V4l2, StampsOfAnotherClockAreNotTaken) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  fake.events.push_back(frame(bytes_of(counting(4, 3))));
  fake.events.back().flags = V4L2_BUF_FLAG_TIMESTAMP_COPY;
  fake.events.back().time_us = 77;
  Picture got(4, 3);
  const std::int64_t before_ns = monotonic_ns();
  const auto info = (*source)->next(got.image(), 100);
  ASSERT_TRUE(info);
  EXPECT_GE(info->host_ns, before_ns);
  // Nor what no clock shows: before the start, nothing at all, centuries on.
  for (const std::int64_t absurd_us : {std::int64_t{-5'000'000}, std::int64_t{0}, std::int64_t{1} << 62}) {
    fake.events.push_back(frame(bytes_of(counting(4, 3)), 1));
    fake.events.back().time_us = absurd_us;
    const auto late = (*source)->next(got.image(), 100);
    ASSERT_TRUE(late);
    EXPECT_GE(late->host_ns, before_ns);
    EXPECT_LT(late->host_ns, before_ns + 60'000'000'000);
  }
}

TEST(V4l2, LinesMayBePadded) {
  FakeVideo fake = small_camera();
  fake.padding_bytes = 6;
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  const Picture sent = counting(4, 3);
  auto bytes = bytes_of(sent, 6);
  bytes.erase(bytes.end() - 6, bytes.end());  // the last line's padding may be missing
  fake.events.push_back(frame(bytes));
  Picture got(4, 3);
  ASSERT_TRUE((*source)->next(got.image(), 100));
  EXPECT_EQ(got.pixels, sent.pixels);
}

TEST(V4l2, InziIsInfraredThenDepth) {
  FakeVideo fake = small_camera();
  fake.formats[0].fourcc = V4L2_PIX_FMT_INZI;
  V4l2Options options = with_angle();
  const auto no_unit = open(fake, options);
  ASSERT_FALSE(no_unit);
  EXPECT_THAT(no_unit.error().message, HasSubstr("unit_um"));
  options.unit_um = 1000;
  auto source = open(fake, options);
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_TRUE((*source)->start());
  const Picture sent = counting(4, 3);
  auto bytes = bytes_of(counting(4, 3, 1));  // infrared
  const auto depth = bytes_of(sent);
  bytes.insert(bytes.end(), depth.begin(), depth.end());
  ASSERT_EQ(bytes.size(), fake.pix.sizeimage);
  fake.events.push_back(frame(bytes));
  Picture got(4, 3);
  ASSERT_TRUE((*source)->next(got.image(), 100));
  EXPECT_EQ(got.pixels, sent.pixels);
}

TEST(V4l2, UnitsBecomeMillimetres) {
  FakeVideo fake = small_camera();
  fake.formats[0].sizes = {{4, 1}};
  V4l2Options options = with_angle(4, 1);
  Picture sent(4, 1);
  Picture got(4, 1);
  struct Case {
    int unit_um;
    std::vector<std::uint16_t> raw, mm;
  };
  // 125 um: 4 steps are half a millimetre and round up; 2500 um: 26214 steps are 65,535 mm, one more is beyond.
  for (const Case& c :
       {Case{125, {0, 3, 4, 65535}, {0, 0, 1, 8192}}, Case{100, {4, 5, 25000, 65535}, {0, 1, 2500, 6554}},
        Case{2500, {1, 26214, 26215, 2}, {3, 65535, 0, 5}}}) {
    options.unit_um = c.unit_um;
    auto source = open(fake, options);
    ASSERT_TRUE(source && (*source)->start());
    sent.pixels = c.raw;
    fake.events.push_back(frame(bytes_of(sent)));
    ASSERT_TRUE((*source)->next(got.image(), 100));
    EXPECT_EQ(got.pixels, c.mm) << c.unit_um;
  }
}

TEST(V4l2, UnitFromTheDriversControl) {
  FakeVideo fake = small_camera();
  fake.controls = {{10, "Gain", 3}, {20, "Depth Units", 250}, {30, "Odd", 0}};
  V4l2Options options = with_angle();
  options.unit_control = "Depth Units";
  auto source = open(fake, options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->mode().layout.unit_um, 250);
  options.unit_um = 500;  // the user's word wins
  source = open(fake, options);
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->mode().layout.unit_um, 500);
  options.unit_um.reset();
  options.unit_control = "Odd";
  EXPECT_EQ(open(fake, options).error().code, ErrorCode::unsupported);
  options.unit_control = "Scale";
  const auto missing = open(fake, options);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_THAT(missing.error().message, HasSubstr("'Depth Units'"));
}

TEST(V4l2, GreyIsDepthOnlyByAgreement) {
  FakeVideo fake = small_camera();
  fake.formats = {{V4L2_PIX_FMT_YUYV, {}}, {V4L2_PIX_FMT_Y16, {{4, 3}}}};
  V4l2Options options = with_angle();
  const auto refused = open(fake, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("?format=Y16"));
  options.format = V4l2Format::y16;
  EXPECT_TRUE(open(fake, options));
  options.format = V4l2Format::z16;
  EXPECT_THAT(open(fake, options).error().message, HasSubstr("YUYV, Y16"));
}

TEST(V4l2, TakesTheNearestSizeAndTheRate) {
  FakeVideo fake;
  fake.formats[0].sizes = {{320, 240}, {848, 480}, {1280, 720}, {4096, 3072}};
  V4l2Options options = with_angle(640, 480);
  options.fps = 15;
  auto source = open(fake, options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.width, 848);
  EXPECT_EQ((*source)->info().intrinsics.height, 480);
  EXPECT_EQ(fake.period.denominator, 15U);
  EXPECT_EQ((*source)->mode().fps, 15.0F);
}

TEST(V4l2, OfADriverThatListsNoSizesTheWantedOneIsRequested) {
  FakeVideo fake;
  fake.formats[0].sizes.clear();
  fake.errors[VIDIOC_G_PARM] = ENOTTY;
  auto source = open(fake, with_angle(320, 200));
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.width, 320);
  EXPECT_EQ((*source)->mode().fps, 0.0F);
}

TEST(V4l2, RefusesWhatCannotBeAPicture) {
  struct Case {
    const char* what;
    std::function<void(FakeVideo&)> make;
  };
  const std::vector<Case> cases = {
      {"is impossible", [](FakeVideo& f) { f.bytes_per_line = 7; }},
      {"is impossible", [](FakeVideo& f) { f.bytes_per_line = 0xFFFFFFF0U; }},
      {"is impossible", [](FakeVideo& f) { f.size_image = 23; }},
      {"interlaced", [](FakeVideo& f) { f.field = V4L2_FIELD_INTERLACED; }},
      {"but delivers Y16", [](FakeVideo& f) { f.other_fourcc = V4L2_PIX_FMT_Y16; }},
      {"does not stream", [](FakeVideo& f) { f.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING; }},
      {"not a V4L2 device", [](FakeVideo& f) { f.errors[VIDIOC_QUERYCAP] = ENOTTY; }},
  };
  for (const Case& c : cases) {
    FakeVideo fake = small_camera();
    c.make(fake);
    const auto source = open(fake, with_angle());
    ASSERT_FALSE(source) << c.what;
    EXPECT_EQ(source.error().code, ErrorCode::unsupported);
    EXPECT_THAT(source.error().message, HasSubstr(c.what));
    EXPECT_TRUE(fake.closed);
  }
}

TEST(V4l2, IntrinsicsAreGivenOrOpeningIsRefused) {
  FakeVideo fake;
  V4l2Options options;
  const auto none = open(fake, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(none.error().message, HasSubstr("--camera"));
  options.hfov_deg = 57.0F;
  auto source = open(fake, options);
  ASSERT_TRUE(source) << source.error().message;
  // Pinhole: half the width over the tangent of half the angle; square pixels.
  const double fx = 320.0 / std::tan(57.0 / 2 * 3.14159265358979323846 / 180);
  EXPECT_NEAR((*source)->info().intrinsics.fx, fx, 1e-3);
  EXPECT_NEAR((*source)->info().intrinsics.fy, fx, 1e-3);
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);

  Calibration calibration;
  calibration.intrinsics = {640, 480, 571.0F, 572.0F, 310.0F, 250.0F};
  options.calibration = calibration;
  source = open(fake, options);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().intrinsics.fx, 571.0F);
  EXPECT_EQ((*source)->info().intrinsics_origin, IntrinsicsOrigin::calibration_file);
  options.calibration->intrinsics.width = 320;
  EXPECT_THAT(open(fake, options).error().message, HasSubstr("calibration is of 320x480"));
}

TEST(V4l2, IsTurnedUpright) {
  FakeVideo fake = small_camera();
  V4l2Options options = with_angle();
  options.rotate_deg = 90;
  auto source = open(fake, options);
  ASSERT_TRUE(source && (*source)->start());
  const Picture sent = counting(4, 3);
  fake.events.push_back(frame(bytes_of(sent)));
  Picture got(3, 4);
  ASSERT_TRUE((*source)->next(got.image(), 100));
  for (int v = 0; v < 4; ++v) {
    for (int u = 0; u < 3; ++u)
      EXPECT_EQ(got.pixels[static_cast<std::size_t>(v * 3 + u)],
                sent.pixels[static_cast<std::size_t>((3 - 1 - u) * 4 + v)]);
  }
}

TEST(V4l2, ShortAndFaultyFramesAreDamagedAndTheNextIsFine) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  const Picture sent = counting(4, 3);
  auto cut = bytes_of(sent);
  cut.pop_back();
  fake.events.push_back(frame(cut, 0));
  fake.events.push_back(frame(bytes_of(sent), 1));
  fake.events.back().flags |= V4L2_BUF_FLAG_ERROR;
  fake.events.push_back(frame({}, 2));
  fake.events.push_back(frame(bytes_of(sent), 5));
  Picture got(4, 3);
  for (int i = 0; i < 3; ++i) {
    const auto damaged = (*source)->next(got.image(), 100);
    ASSERT_FALSE(damaged);
    EXPECT_EQ(damaged.error().code, ErrorCode::corrupt) << damaged.error().message;
    EXPECT_EQ(fake.queued.size(), 4U);
  }
  EXPECT_EQ(got.pixels, std::vector<std::uint16_t>(12)) << "a damaged frame leaves the destination alone";
  ASSERT_TRUE((*source)->next(got.image(), 100));
  EXPECT_EQ(got.pixels, sent.pixels);
  EXPECT_EQ((*source)->stats().damaged, 3U);
  EXPECT_EQ((*source)->stats().delivered, 1U);
}

TEST(V4l2, CountsGapsAndWrapsNumbers) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  const auto bytes = bytes_of(counting(4, 3));
  Picture got(4, 3);
  std::vector<std::uint64_t> numbers;
  for (const std::uint32_t sequence : {0xFFFFFFFDU, 0xFFFFFFFFU, 0U, 3U}) {
    fake.events.push_back(frame(bytes, sequence));
    const auto info = (*source)->next(got.image(), 100);
    ASSERT_TRUE(info);
    numbers.push_back(info->sequence);
  }
  EXPECT_THAT(numbers, testing::ElementsAre(0xFFFFFFFDU, 0xFFFFFFFFU, 0x100000000U, 0x100000003U));
  EXPECT_EQ((*source)->stats().gaps, 3U);
  EXPECT_EQ((*source)->stats().repeats, 0U);
}

TEST(V4l2, ADeviceThatGoesIsLostForGood) {
  for (const int error : {ENODEV, EIO, ENXIO}) {
    FakeVideo fake = small_camera();
    auto source = open(fake, with_angle());
    ASSERT_TRUE(source && (*source)->start());
    fake.events.push_back({});
    fake.events.back().dequeue_error = error;
    fake.events.push_back(frame(bytes_of(counting(4, 3))));
    Picture got(4, 3);
    for (int i = 0; i < 2; ++i) {
      const auto lost = (*source)->next(got.image(), 100);
      ASSERT_FALSE(lost);
      EXPECT_EQ(lost.error().code, ErrorCode::no_device);
    }
    EXPECT_EQ((*source)->start().error().code, ErrorCode::no_device) << "while started: " << error;
    (*source)->stop();
    EXPECT_EQ(fake.mapped, 0);
    EXPECT_EQ((*source)->start().error().code, ErrorCode::no_device);
  }
  for (const short events : {short{POLLERR}, short{POLLHUP}, short{POLLERR | POLLHUP}, short{POLLNVAL}}) {
    FakeVideo fake = small_camera();
    auto source = open(fake, with_angle());
    ASSERT_TRUE(source && (*source)->start());
    fake.events.push_back({});
    fake.events.back().poll_events = events;
    Picture got(4, 3);
    EXPECT_EQ((*source)->next(got.image(), 100).error().code, ErrorCode::no_device) << events;
  }
}

TEST(V4l2, AFrameTakenBeforeTheLossIsDelivered) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  const Picture sent = counting(4, 3);
  fake.events.push_back(frame(bytes_of(sent)));
  fake.errors[VIDIOC_QBUF] = ENODEV;
  Picture got(4, 3);
  ASSERT_TRUE((*source)->next(got.image(), 100));
  EXPECT_EQ(got.pixels, sent.pixels);
  EXPECT_EQ((*source)->next(got.image(), 100).error().code, ErrorCode::no_device);
}

TEST(V4l2, FalseAlarmsEndInAnErrorNotASpin) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  Picture got(4, 3);
  EXPECT_EQ((*source)->next(got.image(), 5).error().code, ErrorCode::timeout);
  EXPECT_EQ(fake.calls_of_wait, 1) << "one sleep to a deadline";
  for (int i = 0; i < 100; ++i) {
    fake.events.push_back({});
    fake.events.back().dequeue_error = EAGAIN;
  }
  const auto alarmed = (*source)->next(got.image(), 1000);
  EXPECT_EQ(alarmed.error().code, ErrorCode::io);
  EXPECT_LE(fake.calls_of_wait, 8);
}

TEST(V4l2, StartIsUndoneWhenItFails) {
  for (const unsigned long request :
       {static_cast<unsigned long>(VIDIOC_REQBUFS), static_cast<unsigned long>(VIDIOC_QUERYBUF),
        static_cast<unsigned long>(VIDIOC_QBUF), static_cast<unsigned long>(VIDIOC_STREAMON)}) {
    FakeVideo fake = small_camera();
    auto source = open(fake, with_angle());
    ASSERT_TRUE(source);
    fake.errors[request] = EBUSY;
    const auto refused = (*source)->start();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::io);
    EXPECT_THAT(refused.error().message, HasSubstr("another program"));
    EXPECT_EQ(fake.mapped, 0);
    fake.errors.clear();
    ASSERT_TRUE((*source)->start()) << "and can be tried again";
    fake.events.push_back(frame(bytes_of(counting(4, 3))));
    Picture got(4, 3);
    EXPECT_TRUE((*source)->next(got.image(), 100));
  }
  FakeVideo fake = small_camera();
  fake.buffers_given = 1;
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source);
  EXPECT_THAT((*source)->start().error().message, HasSubstr("at least 2"));
}

TEST(V4l2, ABufferThatDoesNotExistIsRefused) {
  FakeVideo fake = small_camera();
  auto source = open(fake, with_angle());
  ASSERT_TRUE(source && (*source)->start());
  fake.events.push_back(frame(bytes_of(counting(4, 3))));
  fake.events.back().index_added = 100;
  Picture got(4, 3);
  EXPECT_EQ((*source)->next(got.image(), 100).error().code, ErrorCode::io);
}

TEST(V4l2, ReadsTheUri) {
  V4l2Options defaults;
  defaults.width = 320;
  const auto all = parse_v4l2_uri(
      "/dev/video3?format=Y16&unit_um=125&hfov=57.25&size=848x480&fps=15&serial=A%201&unit_control=Depth%20Units",
      defaults);
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->path, "/dev/video3");
  EXPECT_EQ(all->format, V4l2Format::y16);
  EXPECT_EQ(all->unit_um, 125);
  EXPECT_EQ(all->hfov_deg, 57.25F);
  EXPECT_EQ(all->width, 848);
  EXPECT_EQ(all->height, 480);
  EXPECT_EQ(all->fps, 15);
  EXPECT_EQ(all->serial, "A 1");
  EXPECT_EQ(all->unit_control, "Depth Units");
  const auto plain = parse_v4l2_uri("/dev/video0", defaults);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->width, 320);
  EXPECT_FALSE(plain->format);
  for (const char* bad : {"?format=YUYV", "?unit_um=0", "?unit_um=100001", "?unit_um=1mm", "?hfov=9", "?hfov=151",
                          "?hfov=57,3", "?hfov=", "?size=640", "?size=640x", "?size=2049x1", "?fps=0", "?colour=1",
                          "?unit_control=", "?=", "?size=-1x4"}) {
    const auto refused = parse_v4l2_uri(bad, defaults);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  }
}

// A camera that comes back is opened by these words: in another unit or format it would lie.
TEST(V4l2, TheUriOpensTheSameAgain) {
  const std::string words[] = {"/dev/video3", "/dev/video3?format=Y16&unit_um=125&hfov=57.25&size=848x480&fps=15",
                               "?serial=A%201%26%3F%25&format=INZI&unit_control=Depth%20Units&hfov=58.007", ""};
  for (const std::string& text : words) {
    const auto options = parse_v4l2_uri(text, {});
    ASSERT_TRUE(options);
    EXPECT_EQ(v4l2_uri(*options), "v4l2:" + text);
  }
  V4l2Options by_number = with_angle();
  by_number.serial = "7";
  EXPECT_EQ(v4l2_uri(by_number), "v4l2:?serial=7&hfov=60&size=4x3") << "the number finds it on any node";
  by_number.calibration = Calibration{};
  EXPECT_EQ(v4l2_uri(by_number), "v4l2:?serial=7&size=4x3");
}

TEST(V4l2, WhatIsNoCameraIsRefusedInPlainWords) {
  EXPECT_EQ(open_video_device("/dev/im2fit-no-such-node").error().code, ErrorCode::not_found);
  auto null = open_video_device("/dev/null");
  ASSERT_TRUE(null) << null.error().message;
  const auto source = V4l2Source::open(std::move(*null), "/dev/null", with_angle());
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::unsupported);
  V4l2Options options = with_angle();
  options.path = "";
  options.serial = "no such serial";
  EXPECT_EQ(V4l2Source::open(options).error().code, ErrorCode::no_device);
}

// The whole domain, against the documentation's words: top three bits confidence with 0 for 100 %, else (n - 1) / 7;
// the low thirteen millimetres.
TEST(Depth16, SplitsConfidenceAndMillimetres) {
  for (int sample = 0; sample < 65536; ++sample) {
    const int confidence = sample / 8192;
    const double sure = confidence == 0 ? 1.0 : (confidence - 1) / 7.0;
    for (int sevenths_min = 0; sevenths_min <= 7; ++sevenths_min) {
      const int mm = sure * 7 + 1e-9 >= sevenths_min ? sample % 8192 : 0;
      ASSERT_EQ(depth16_mm(static_cast<std::uint16_t>(sample), sevenths_min), mm) << sample << " " << sevenths_min;
    }
  }
  std::vector<std::uint16_t> samples = {2000, 0x2000 | 2000, 0xE000 | 8191, 0};
  depth16_to_mm(samples.data(), samples.size(), 6, samples.data());
  EXPECT_THAT(samples, testing::ElementsAre(2000, 0, 8191, 0));
}

}  // namespace
}  // namespace im2fit::hal
