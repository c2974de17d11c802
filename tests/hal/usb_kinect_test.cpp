// SPDX-License-Identifier: Apache-2.0
// The whole Kinect path against a camera model that shares nothing with it: every pixel of every frame.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/hal/long_run.h"
#include "tests/hal/usb_rig.h"

namespace im2fit::hal {
namespace {

int frames_to_test() {
  return hal::frames_to_test("IM2FIT_USB_FRAMES");
}

TEST(UsbKinect, DeliversEveryFrameToTheLastPixel) {
  KinectSettings settings;
  settings.first_ticks = 0xFFFFFFFF - 20'000'000;  // its clock wraps within the test
  settings.first_number = 200;
  Rig rig(settings);
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  std::int64_t first_us = -1, last_us = -1;
  const int frames = frames_to_test();
  Growth growth(frames);
  for (int n = 0; n < frames; ++n) {
    growth.saw(n);
    rig.run(n == 0 ? kFrame_us : 100'000 / 3 + (n % 3 == 0 ? 1 : 0));  // exactly 30 a second
    const auto got = rig.source->next(rig.out.image(), 0);
    ASSERT_TRUE(got) << "frame " << n << ": " << got.error().message;
    EXPECT_EQ(got->sequence, static_cast<std::uint64_t>(n));
    ASSERT_TRUE(rig.is_frame(got->sequence)) << "frame " << n;
    if (n == 0) first_us = got->device_us;
    if (n > 0) {
      EXPECT_NEAR(static_cast<double>(got->device_us - last_us), 33'333.3, 1.0);
    }
    last_us = got->device_us;
    EXPECT_GT(got->host_ns, 0);
  }
  EXPECT_NEAR(static_cast<double>(last_us - first_us), (frames - 1) * 1e6 / 30, 1.0) << "time drifts";
  growth.expect_none();
  const SourceStats stats = rig.source->stats();
  EXPECT_EQ(stats.delivered, static_cast<std::uint64_t>(frames));
  EXPECT_EQ(stats.gaps + stats.repeats + stats.damaged, 0U);
  rig.source->stop();
  EXPECT_EQ(rig.camera.register_value(0x06), 0) << "the camera is left streaming";
}

// The model's own arithmetic, by which all else is judged, against values computed by hand.
TEST(UsbKinect, TheModelKnowsItsDistances) {
  const KinectSettings settings;
  EXPECT_EQ(devices::mm_of_shift(settings, 0), 317);
  EXPECT_EQ(devices::mm_of_shift(settings, 803), 1206);
  EXPECT_EQ(devices::mm_of_shift(settings, 1000), 3864);
  EXPECT_EQ(devices::mm_of_shift(settings, 1084), 0);
  EXPECT_EQ(devices::mm_of_shift(settings, 2047), 0);
  EXPECT_EQ(devices::shift_of_mm(settings, 0), 2047);
  EXPECT_EQ(devices::shift_of_mm(settings, 1207), 803);
  for (int raw = 0; raw <= 1054; ++raw) {  // 1055 is beyond 10 m
    const std::uint16_t mm = devices::mm_of_shift(settings, static_cast<std::uint16_t>(raw));
    ASSERT_GT(mm, 0);
    EXPECT_EQ(devices::mm_of_shift(settings, devices::shift_of_mm(settings, mm)), mm) << raw;
  }
}

TEST(UsbKinect, SaysWhoseItsIntrinsicsAre) {
  KinectSettings settings;
  settings.pixel_cm = 0.1052F;
  Rig rig(settings);
  expect_ok(rig.open());
  const SourceInfo& info = rig.source->info();
  EXPECT_EQ(info.uri, "usb:A00364A13385040A");
  EXPECT_EQ(info.serial, "A00364A13385040A");
  EXPECT_TRUE(info.live);
  EXPECT_EQ(info.sensor, SensorKind::structured_light);
  EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::device);
  EXPECT_NEAR(info.intrinsics.fx, 120.0 / (2 * 0.1052), 1e-3);
  EXPECT_EQ(info.intrinsics.fx, info.intrinsics.fy);
  EXPECT_EQ(info.intrinsics.cx, 319.5F);
  EXPECT_EQ(info.intrinsics.cy, 239.5F);

  settings.faults.refused_opcode = 0x04;
  Rig silent(settings);
  expect_ok(silent.open());
  EXPECT_EQ(silent.source->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);
  EXPECT_NEAR(silent.source->info().intrinsics.fx, 575.816, 1e-3);
  EXPECT_EQ(silent.source->zero_plane().pixel_nm, 1'042'000);

  settings.faults = {};
  settings.emitter_cm = 7500.0F;
  Rig absurd(settings);
  expect_ok(absurd.open());
  EXPECT_EQ(absurd.source->info().intrinsics_origin, IntrinsicsOrigin::field_of_view);
}

TEST(UsbKinect, TakesACalibrationAndAMounting) {
  Rig rig;
  KinectOptions options;
  options.rotate_deg = 90;
  options.calibration =
      Calibration{{kWidth, kHeight, 580, 581, 315, 242}, {}, {}, IntrinsicsOrigin::calibration_file};
  expect_ok(rig.open(options));
  EXPECT_EQ(rig.source->info().intrinsics_origin, IntrinsicsOrigin::calibration_file);
  EXPECT_EQ(rig.source->info().intrinsics.width, kHeight);
  EXPECT_EQ(rig.source->info().intrinsics.fx, 581.0F);
  EXPECT_EQ(rig.source->info().intrinsics.cy, 315.0F);
  expect_ok(rig.source->start());
  rig.run(kFrame_us);
  Picture upright(kHeight, kWidth);
  ASSERT_TRUE(rig.source->next(upright.image(), 0));
  for (int v = 0; v < kWidth; ++v)
    for (int u = 0; u < kHeight; ++u) {
      const std::size_t i = static_cast<std::size_t>(kHeight - 1 - u) * kWidth + static_cast<std::size_t>(v);
      ASSERT_EQ(upright.image().at(u, v), rig.table[raw_at(0, i)]) << u << " " << v;
    }
  EXPECT_EQ(rig.source->next(rig.out.image(), 0).error().code, ErrorCode::invalid_argument)
      << "a picture not upright";

  options.calibration->intrinsics.width = 320;
  const auto wrong = open_kinect(rig.bus, "", options);
  ASSERT_FALSE(wrong);
  options = {};
  options.rotate_deg = 45;
  rig.source.reset();
  EXPECT_EQ(open_kinect(rig.bus, "", options).error().code, ErrorCode::invalid_argument);
}

// Two thousand packets of a million, as in the guest: four frames in ten are hit.
struct Accounts {
  std::uint64_t delivered = 0, corrupt = 0, wrong = 0;
};
Accounts drain(Rig& rig, std::uint64_t& last, std::vector<std::uint64_t>& damaged) {
  Accounts accounts;
  for (;;) {
    const auto got = rig.source->next(rig.out.image(), 0);
    if (got) {
      ++accounts.delivered;
      last = got->sequence;
      // The camera's clock says which one it is, should the first ones never have been heard of.
      if (!rig.is_frame(static_cast<std::uint64_t>((got->device_us * 3 + 50'000) / 100'000))) ++accounts.wrong;
    } else if (got.error().code == ErrorCode::corrupt) {
      ++accounts.corrupt;
      EXPECT_TRUE(contains(got.error().message, "of 242 packets")) << got.error().message;
      const auto at = got.error().message.find("frame ");
      damaged.push_back(std::stoull(got.error().message.substr(at + 6)));
    } else {
      EXPECT_EQ(got.error().code, ErrorCode::timeout);
      return accounts;
    }
  }
}

void expect_books_to_balance(const devices::KinectFaults& faults, std::int64_t step_us, int steps, bool exact) {
  KinectSettings settings;
  settings.faults = faults;
  Rig rig(settings);
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  Accounts sum;
  std::uint64_t last = 0;
  std::vector<std::uint64_t> damaged;
  for (int i = 0; i < steps; ++i) {
    rig.run(step_us);
    const Accounts now = drain(rig, last, damaged);
    sum.delivered += now.delivered;
    sum.corrupt += now.corrupt;
    sum.wrong += now.wrong;
  }
  rig.camera.faults().lost_ppm = rig.camera.faults().truncated_ppm = 0;
  for (int i = 0; i < 2; ++i) {  // the last frames are whole, so that the frames before are known
    rig.run(kFrame_us);
    const Accounts now = drain(rig, last, damaged);
    sum.delivered += now.delivered;
    sum.corrupt += now.corrupt;
    sum.wrong += now.wrong;
  }
  EXPECT_EQ(sum.wrong, 0U) << "frames delivered that are not what the camera sent";
  const SourceStats stats = rig.source->stats();
  EXPECT_EQ(stats.delivered, sum.delivered);
  EXPECT_GE(stats.damaged, sum.corrupt) << "many at once may push one another out, but are counted";
  EXPECT_EQ(stats.repeats, 0U);
  EXPECT_EQ(stats.delivered + stats.damaged + stats.gaps, last + 1) << "frames are missing in the books";
  EXPECT_GT(sum.delivered, 0U);
  if (!exact) return;
  // Each spoiled frame is refused, and no other.
  EXPECT_EQ(stats.gaps, rig.camera.unsent().size());
  EXPECT_EQ(stats.damaged, sum.corrupt);
  EXPECT_EQ(damaged, std::vector<std::uint64_t>(rig.camera.spoiled().begin(), rig.camera.spoiled().end()));
  EXPECT_GT(damaged.size(), 0U);
}

TEST(UsbKinect, RefusesEveryFrameThatLostAPacketAndNoOther) {
  devices::KinectFaults faults;
  faults.lost_ppm = 2000;
  expect_books_to_balance(faults, 100'000 / 3, 2 * frames_to_test(), true);
}

TEST(UsbKinect, RefusesEveryFrameThatWasCut) {
  devices::KinectFaults faults;
  faults.truncated_ppm = 2000;
  faults.seed = 5;
  expect_books_to_balance(faults, 100'000 / 3, frames_to_test(), true);
}

TEST(UsbKinect, IsNotDisturbedByPacketsThatComeTwice) {
  devices::KinectFaults faults;
  faults.duplicated_ppm = 20'000;
  KinectSettings settings;
  settings.faults = faults;
  Rig rig(settings);
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  std::uint64_t last = 0;
  std::vector<std::uint64_t> damaged;
  Accounts sum;
  for (int i = 0; i < 40; ++i) {
    rig.run(kFrame_us);
    const Accounts now = drain(rig, last, damaged);
    sum.delivered += now.delivered;
    sum.wrong += now.wrong;
  }
  EXPECT_GE(sum.delivered, 40U);
  EXPECT_EQ(sum.wrong, 0U);
  EXPECT_TRUE(damaged.empty());
  EXPECT_GT(rig.source->packet_stats().repeated, 50U);
}

// A tenth of all packets: no frame survives but by luck, pieces of several run into one another.
TEST(UsbKinect, NeverDeliversAWrongFrameHoweverBadTheCable) {
  for (const int lost_ppm : {20'000, 100'000, 900'000}) {
    devices::KinectFaults faults;
    faults.lost_ppm = lost_ppm;
    faults.truncated_ppm = 5'000;
    faults.duplicated_ppm = 5'000;
    faults.seed = static_cast<std::uint64_t>(lost_ppm);
    expect_books_to_balance(faults, 100'000 / 3, 40, false);
  }
}

TEST(UsbKinect, DropsTheOldestWhenNoneAreTakenAndCountsThem) {
  Rig rig;
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  rig.run(20 * 33'334);
  std::uint64_t last = 0;
  std::vector<std::uint64_t> damaged;
  const Accounts accounts = drain(rig, last, damaged);
  EXPECT_EQ(accounts.delivered, 3U);
  EXPECT_EQ(accounts.wrong, 0U);
  EXPECT_EQ(last, rig.camera.frames_ended() - 1) << "the newest are kept";
  EXPECT_EQ(rig.source->stats().gaps, last + 1 - 3);
}

// The host slept: frames of which it knows nothing but the camera's clock.
TEST(UsbKinect, CountsFramesItWasTooBusyToFetch) {
  Rig rig;
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  rig.run(kFrame_us);
  ASSERT_TRUE(rig.source->next(rig.out.image(), 0));
  rig.bus.idle("1-1.1", 400'000);
  for (int i = 0; i < 4; ++i) rig.run(kFrame_us);
  std::uint64_t last = 0;
  std::vector<std::uint64_t> damaged;
  const Accounts accounts = drain(rig, last, damaged);
  EXPECT_EQ(accounts.wrong, 0U);
  EXPECT_GE(accounts.delivered, 2U);
  const SourceStats stats = rig.source->stats();
  EXPECT_EQ(stats.delivered + stats.damaged + stats.gaps, last + 1);
  EXPECT_GE(stats.gaps, 9U);
}

TEST(UsbKinect, IsLostWhenPulledOutAndComesBack) {
  Rig rig;
  for (int round = 0; round < 20; ++round) {
    expect_ok(rig.open({}, "A00364A13385040A"));
    expect_ok(rig.source->start());
    rig.run(2 * kFrame_us);
    const auto first = rig.source->next(rig.out.image(), 0);
    ASSERT_TRUE(first) << round << ": " << first.error().message;
    ASSERT_TRUE(rig.is_frame(first->sequence));
    rig.bus.unplug("1-1.1");
    ErrorCode code = ErrorCode::timeout;
    for (int i = 0; i < 8 && code != ErrorCode::no_device; ++i) {
      const auto got = rig.source->next(rig.out.image(), 0);
      code = got ? ErrorCode::timeout : got.error().code;
    }
    EXPECT_EQ(code, ErrorCode::no_device);
    EXPECT_EQ(rig.source->next(rig.out.image(), 1000).error().code, ErrorCode::no_device) << "it comes at once";
    EXPECT_EQ(open_kinect(rig.bus, "A00364A13385040A", {}).error().code, ErrorCode::no_device);
    rig.source->stop();
    EXPECT_EQ(rig.source->start().error().code, ErrorCode::no_device);
    rig.bus.plug("1-1.1", rig.camera);
    EXPECT_EQ(rig.source->start().error().code, ErrorCode::no_device) << "what was opened before is not this one";
  }
}

TEST(UsbKinect, StopsAndStartsAgain) {
  Rig rig;
  expect_ok(rig.open());
  EXPECT_EQ(rig.source->next(rig.out.image(), 0).error().code, ErrorCode::invalid_argument);
  for (int round = 0; round < 3; ++round) {
    expect_ok(rig.source->start());
    expect_ok(rig.source->start());  // again: nothing happens
    rig.run(2 * kFrame_us + 1000 * round);
    for (int n = 0; n < 2; ++n) {
      const auto got = rig.source->next(rig.out.image(), 0);
      ASSERT_TRUE(got) << got.error().message;
      EXPECT_EQ(got->sequence, static_cast<std::uint64_t>(n));
      EXPECT_TRUE(rig.is_frame(got->sequence));
    }
    rig.source->stop();
    rig.source->stop();
    rig.run(kFrame_us);
    EXPECT_EQ(rig.source->stats().delivered, 2U);
  }
  rig.source.reset();
  EXPECT_FALSE(rig.bus.port("1-1.1").claimed) << "closing gives the device back";
  EXPECT_FALSE(rig.bus.port("1-1.2").claimed);
}

// The program before us was killed in the middle of a frame: the camera still sends.
TEST(UsbKinect, StartsCleanlyOnACameraLeftStreaming) {
  Rig rig;
  for (int round = 0; round < 3; ++round) {
    expect_ok(rig.open());
    expect_ok(rig.source->start());
    rig.run(kFrame_us + 11'000);
    const auto got = rig.source->next(rig.out.image(), 0);
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_TRUE(rig.is_frame(0));
    rig.bus.unplug("1-1.1");  // in software nothing loses its power
    rig.bus.plug("1-1.1", rig.camera);
    rig.source.reset();
    EXPECT_TRUE(rig.camera.streaming());
  }
}

// A start-up that fails says which command, and leaves nothing streaming.
TEST(UsbKinect, SaysWhatWentWrongAtTheStart) {
  {
    KinectSettings settings;
    settings.faults.refused_register = 0x12;
    Rig rig(settings);
    expect_ok(rig.open());
    const auto failed = rig.source->start();
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::io);
    EXPECT_TRUE(contains(failed.error().message, "register 0x12")) << failed.error().message;
    EXPECT_TRUE(contains(failed.error().message, "refused with code 6")) << failed.error().message;
    EXPECT_EQ(rig.bus.port("1-1.1").sink, nullptr);
    rig.camera.faults() = {};
    expect_ok(rig.source->start());
    rig.run(kFrame_us);
    EXPECT_TRUE(rig.source->next(rig.out.image(), 0));
  }
  {
    KinectSettings settings;
    settings.faults.stalled_opcode = 0x03;
    Rig rig(settings);
    expect_ok(rig.open());
    const auto failed = rig.source->start();
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::unsupported);
    EXPECT_TRUE(contains(failed.error().message, "command 0x3 cannot be sent")) << failed.error().message;
  }
  {
    KinectSettings settings;
    settings.faults.mute = true;
    Rig rig(settings);
    const auto failed = rig.open();
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::timeout);
    EXPECT_TRUE(contains(failed.error().message, "no reply within a second")) << failed.error().message;
  }
  {
    KinectSettings settings;
    settings.faults.silent = true;
    Rig rig(settings);
    expect_ok(rig.open());
    expect_ok(rig.source->start());
    rig.run(kFrame_us);
    EXPECT_EQ(rig.source->next(rig.out.image(), 1).error().code, ErrorCode::timeout);
  }
}

TEST(UsbKinect, WaitsForAnswersAndLeavesOldOnesAlone) {
  KinectSettings settings;
  settings.faults.polls_until_answer = 3;
  settings.faults.stale_answers = true;
  settings.reference_cm = 110;
  Rig rig(settings);
  expect_ok(rig.open());
  EXPECT_EQ(rig.source->zero_plane().distance_nm, 1'100'000'000);
  expect_ok(rig.source->start());
  rig.run(kFrame_us);
  ASSERT_TRUE(rig.source->next(rig.out.image(), 0));
  EXPECT_TRUE(rig.is_frame(0));
}

// The bus runs in a thread of its own, as libusb's does, and the reader is slower than the camera: delivered frames
// are whole, in order, and the books balance.
TEST(UsbKinect, HandsFramesFromOneThreadToAnother) {
  Rig rig;
  expect_ok(rig.open());
  expect_ok(rig.source->start());
  const int frames = frames_to_test();
  std::atomic<bool> over{false};
  std::thread wire([&] {
    rig.run(frames * std::int64_t{33'334});
    over = true;
  });
  std::uint64_t delivered = 0, next = 0;
  for (;;) {
    const bool was_over = over;  // a frame that is missing after the end will not come
    const auto got = rig.source->next(rig.out.image(), 50);
    if (!got) {
      EXPECT_EQ(got.error().code, ErrorCode::timeout);
      if (was_over) break;
      continue;
    }
    EXPECT_GE(got->sequence, next);
    next = got->sequence + 1;
    EXPECT_TRUE(rig.is_frame(got->sequence)) << "frame " << got->sequence << " is torn";
    ++delivered;
  }
  wire.join();
  const SourceStats stats = rig.source->stats();
  EXPECT_EQ(stats.delivered, delivered);
  EXPECT_EQ(stats.delivered + stats.gaps, next);
  EXPECT_EQ(stats.damaged, 0U);
  EXPECT_GT(delivered, 2U);
}

TEST(UsbKinect, StopsWhileTheBusIsBusy) {
  Rig rig;
  for (int round = 0; round < 10; ++round) {
    expect_ok(rig.open());
    expect_ok(rig.source->start());
    std::thread wire([&] { rig.run(4 * kFrame_us); });
    if (round % 2 == 0) (void)rig.source->next(rig.out.image(), 20);
    if (round % 3 == 0)
      rig.source.reset();
    else
      rig.source->stop();
    wire.join();
  }
}

TEST(UsbKinect, TwoAtOnceDoNotMix) {
  KinectSettings left, right;
  left.serial = "LEFT";
  right.serial = "RIGHT";
  right.pixel_cm = 0.1052F;
  right.faults.lost_ppm = 3000;
  KinectCameraModel camera_left(left, picture);
  KinectCameraModel camera_right(
      right, [](std::uint64_t number, std::span<std::uint16_t> raw) { picture(number + 1'000'000, raw); });
  KinectMotorModel motor_left, motor_right;
  motor_right.set_acceleration(0, 579, -579);
  ModelBus bus;
  bus.plug("1-1", camera_left);
  bus.plug("1-2", motor_left);
  bus.plug("1-9", camera_right);
  bus.plug("1-10", motor_right);
  const auto entries = list_kinects(bus);
  ASSERT_TRUE(entries);
  ASSERT_EQ(entries->size(), 2U);
  auto a = open_kinect(bus, "LEFT", {});
  auto b = open_kinect(bus, "RIGHT", {});
  ASSERT_TRUE(a && b);
  const auto again = open_kinect(bus, "LEFT", {});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::io);
  expect_direction((*a)->down(), 0, 1, 0);
  expect_direction((*b)->down(), 0, 0.7071F, 0.7071F);
  expect_ok((*a)->start());
  expect_ok((*b)->start());
  const auto table_left = millimetres(left), table_right = millimetres(right);
  Picture out(kWidth, kHeight);
  int right_seen = 0;
  for (int n = 0; n < 20; ++n) {
    bus.run("1-1", kFrame_us);
    bus.run("1-9", kFrame_us);
    const auto from_left = (*a)->next(out.image(), 0);
    ASSERT_TRUE(from_left);
    for (std::size_t i = 0; i < out.pixels.size(); ++i)
      ASSERT_EQ(out.pixels[i], table_left[raw_at(from_left->sequence, i)]);
    const auto from_right = (*b)->next(out.image(), 0);
    if (!from_right) continue;
    ++right_seen;
    for (std::size_t i = 0; i < out.pixels.size(); ++i)
      ASSERT_EQ(out.pixels[i], table_right[raw_at(from_right->sequence + 1'000'000, i)]);
  }
  EXPECT_GT(right_seen, 3);
  bus.unplug("1-9");
  bus.run("1-1", kFrame_us);
  EXPECT_TRUE((*a)->next(out.image(), 0)) << "the other one is pulled out";
}

TEST(UsbKinect, IsFoundBySerialPortOrAtAll) {
  KinectSettings none, twin;
  none.serial = "0000000000000000";
  twin.serial = "TWIN";
  KinectCameraModel first(none, picture), second(twin, picture), third(twin, picture);
  ModelBus bus;
  EXPECT_TRUE(list_kinects(bus)->empty());
  const auto nothing = open_kinect(bus, "", {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, ErrorCode::no_device);
  EXPECT_TRUE(contains(nothing.error().message, "none is plugged in")) << nothing.error().message;
  bus.plug("1-2.3", first);
  bus.plug("1-4", second);
  const auto two = list_kinects(bus);
  ASSERT_EQ(two->size(), 2U);
  EXPECT_EQ((*two)[0].id, "1-2.3") << "zeros are no serial number";
  EXPECT_EQ((*two)[1].id, "TWIN");
  bus.plug("2-1", third);
  EXPECT_EQ((*list_kinects(bus))[1].id, "1-4") << "two of one name are distinguished by where they are";
  for (const char* id : {"", "1-2.3"}) {
    const auto opened = open_kinect(bus, id, {});
    ASSERT_TRUE(opened) << id;
    EXPECT_EQ((*opened)->info().uri, "usb:1-2.3");
  }
  const auto wrong = open_kinect(bus, "A0036", {});
  ASSERT_FALSE(wrong);
  EXPECT_TRUE(contains(wrong.error().message, "usb:1-2.3, usb:1-4, usb:2-1")) << wrong.error().message;
}

}  // namespace
}  // namespace im2fit::hal
