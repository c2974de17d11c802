// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/usb/libusb_cameras.h"
#include "tests/devices/kinect_model.h"
#include "tests/devices/process_state.h"
#include "tests/devices/thread_starts.h"
#include "tests/libusb/fake_libusb.h"

namespace im2fit::hal {
namespace {

using devices::KinectCameraModel;
using devices::KinectMotorModel;
using devices::KinectSettings;

constexpr std::size_t kPixels = 640 * 480;

// Cheap to make and to check, and another one for each frame.
std::uint16_t raw_at(std::uint64_t number, std::size_t i) {
  return static_cast<std::uint16_t>((number * 131 + i * 7 + i / 640) % 2048);
}
void picture(std::uint64_t number, std::span<std::uint16_t> raw) {
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = raw_at(number, i);
}

std::vector<std::uint16_t> millimetres() {
  std::vector<std::uint16_t> table(2048);
  for (int raw = 0; raw < 2048; ++raw)
    table[static_cast<std::size_t>(raw)] = devices::mm_of_shift({}, static_cast<std::uint16_t>(raw));
  return table;
}

class Libusb : public testing::Test {
 protected:
  void SetUp() override {
    fake::reset();
    std::thread([] {}).join();  // the thread sanitizer keeps one of its own from the first on
    threads_ = devices::threads();
  }
  void TearDown() override {
    EXPECT_TRUE(fake::debts().none()) << "contexts, handles, claims, transfers or lists are left";
    // A joined thread may be seen for a moment more, under an emulator above all.
    for (int i = 0; i < 200 && devices::threads() > threads_; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_LE(devices::threads(), threads_);
  }
  static std::unique_ptr<KinectSource> opened(const std::string& device) {
    auto source = open_usb_camera(device, {});
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }
  static Error refused(const std::string& device) {
    const auto source = open_usb_camera(device, {});
    EXPECT_FALSE(source) << device;
    return source ? Error{} : source.error();
  }
  // The camera's clock says which frame it must be, however many were missed.
  bool is_right(const FrameInfo& frame, std::uint64_t offset = 0) const {
    const auto number = static_cast<std::uint64_t>((frame.device_us * 3 + 50'000) / 100'000) + offset;
    for (std::size_t i = 0; i < kPixels; ++i)
      if (depth_[i] != table_[raw_at(number, i)]) return false;
    return true;
  }
  DepthImage image() { return {depth_.data(), 640, 480}; }
  static bool says(const Error& error, const std::string& part) {
    return error.message.find(part) != std::string::npos;
  }

  KinectCameraModel camera_{{}, picture};
  KinectMotorModel motor_;
  std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(kPixels);
  std::vector<std::uint16_t> table_ = millimetres();
  int threads_ = 0;
};

TEST_F(Libusb, StreamsAndGivesEverythingBack) {
  fake::plug("1-1.1", camera_);
  fake::plug("1-1.2", motor_);
  {
    const auto source = opened("A00364A13385040A");
    ASSERT_TRUE(source);
    ASSERT_NE(source->motor(), nullptr);
    for (int round = 0; round < 3; ++round) {
      ASSERT_TRUE(source->start());
      for (int n = 0; n < 10; ++n) {
        const auto frame = source->next(image(), 5000);
        ASSERT_TRUE(frame) << frame.error().message;
        ASSERT_TRUE(is_right(*frame)) << frame->sequence;
        EXPECT_TRUE(source->down()) << "control transfers run while packets come";
      }
      source->stop();
      EXPECT_EQ(fake::debts().in_flight, 0);
      EXPECT_FALSE(camera_.streaming());
    }
    EXPECT_EQ(source->stats().damaged, 0U);
    EXPECT_FALSE(fake::port("1-1.1").kernel_driver);
  }
  EXPECT_GE(fake::most_in_flight(), 16);
  for (const char* name : {"1-1.1", "1-1.2"}) {
    EXPECT_TRUE(fake::port(name).kernel_driver) << "its driver has it back";
    EXPECT_EQ(fake::port(name).times_detached, 1);
    EXPECT_FALSE(fake::port(name).busy);
  }
}

TEST_F(Libusb, ClosesWhileStreaming) {
  fake::plug("1-1.1", camera_);
  for (int round = 0; round < 20; ++round) {
    const auto source = opened("");
    ASSERT_TRUE(source);
    ASSERT_TRUE(source->start());
    if (round % 2 == 0) {
      ASSERT_TRUE(source->next(image(), 5000));
    }
  }
}

TEST_F(Libusb, IsPulledOutAndPutBackTwentyTimes) {
  fake::plug("1-1.1", camera_);
  fake::plug("1-1.2", motor_);
  for (int round = 0; round < 20; ++round) {
    const auto source = opened("A00364A13385040A");
    ASSERT_TRUE(source) << round;
    ASSERT_TRUE(source->start());
    const auto frame = source->next(image(), 5000);
    ASSERT_TRUE(frame) << frame.error().message;
    fake::unplug("1-1.1");
    Error lost;
    for (int i = 0; i < 12 && lost.code != ErrorCode::no_device; ++i)
      if (const auto got = source->next(image(), 5000); !got) lost = got.error();
    EXPECT_EQ(lost.code, ErrorCode::no_device) << lost.message;
    EXPECT_EQ(refused("A00364A13385040A").code, ErrorCode::no_device);
    if (round % 2 == 0) source->stop();  // or only closed
    fake::plug("1-1.1", camera_);
  }
}

TEST_F(Libusb, SurvivesTransfersThatFailAndGivesUpOnAStreamThatIsDead) {
  fake::plug("1-1.1", camera_);
  const auto source = opened("");
  ASSERT_TRUE(source);
  ASSERT_TRUE(source->start());
  ASSERT_TRUE(source->next(image(), 5000));
  fake::fail_transfers("1-1.1", 40);
  for (int good = 0, tries = 0; good < 5; ++tries) {
    ASSERT_LT(tries, 100);
    const auto frame = source->next(image(), 5000);
    if (frame) {
      EXPECT_TRUE(is_right(*frame));
      ++good;
    } else {
      EXPECT_EQ(frame.error().code, ErrorCode::corrupt);
    }
  }
  fake::fail_transfers("1-1.1", 1'000'000);
  Error last;
  for (int i = 0; i < 20 && last.code != ErrorCode::io; ++i)
    if (const auto got = source->next(image(), 5000); !got) last = got.error();
  EXPECT_EQ(last.code, ErrorCode::io) << last.message;
  EXPECT_TRUE(says(last, "transfers fail")) << last.message;
}

TEST_F(Libusb, SaysWhyItDoesNotOpenOrStart) {
  fake::plug("1-1.1", camera_).forbidden = true;
  Error error = refused("1-1.1");
  EXPECT_EQ(error.code, ErrorCode::io);
  EXPECT_TRUE(says(error, "60-im2fit-kinect.rules")) << error.message;

  fake::plug("1-1.1", camera_).busy = true;
  error = refused("");
  EXPECT_EQ(error.code, ErrorCode::io);
  EXPECT_TRUE(says(error, "another program")) << error.message;

  for (const int accepted : {0, 1, 9}) {
    fake::plug("1-1.1", camera_).refuse_submits_after = accepted;
    const auto source = opened("");
    ASSERT_TRUE(source);
    const auto started = source->start();
    ASSERT_FALSE(started);
    EXPECT_EQ(started.error().code, ErrorCode::io);
    EXPECT_TRUE(says(started.error(), "transfer " + std::to_string(accepted + 1))) << started.error().message;
    EXPECT_EQ(fake::debts().in_flight, 0);
    fake::refuse_submits_after("1-1.1", -1);
    ASSERT_TRUE(source->start());
    EXPECT_TRUE(source->next(image(), 5000));
  }

  // A motor that may not be opened is left out.
  fake::plug("1-1.1", camera_);
  fake::plug("1-1.2", motor_).forbidden = true;
  const auto source = opened("");
  ASSERT_TRUE(source);
  EXPECT_EQ(source->motor(), nullptr);
}

// Transfers are in flight by then, and the kernel writes into them until they are cancelled and handled.
TEST_F(Libusb, WithoutAThreadForItsEventsTakesItsTransfersBack) {
  fake::plug("1-1.1", camera_);
  const auto source = opened("");
  ASSERT_TRUE(source);
  fail_thread_start_after(0);
  const auto started = source->start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, ErrorCode::io);
  EXPECT_TRUE(says(started.error(), "thread")) << started.error().message;
  EXPECT_GE(fake::most_in_flight(), 16) << "it failed before there was anything to take back";
  EXPECT_EQ(fake::debts().in_flight, 0);
  EXPECT_EQ(fake::debts().transfers, 0);
  ASSERT_TRUE(source->start());
  EXPECT_TRUE(source->next(image(), 5000));
}

TEST_F(Libusb, AMachineWithoutUsbHasNoCameras) {
  fake::plug("1-1.1", camera_);
  fake::no_usb(true);
  const auto cameras = list_usb_cameras();
  ASSERT_TRUE(cameras);
  EXPECT_TRUE(cameras->empty());
  EXPECT_EQ(refused("").code, ErrorCode::no_device);
}

TEST_F(Libusb, ListsWhatIsThere) {
  devices::KinectSettings settings;
  settings.serial = "B 1";  // characters that a URI does not allow are left out
  KinectCameraModel other(settings, picture);
  fake::plug("1-1.1", camera_);
  fake::plug("2-3", other);
  fake::plug("1-1.2", motor_);
  const auto cameras = list_usb_cameras();
  ASSERT_TRUE(cameras);
  ASSERT_EQ(cameras->size(), 2U);
  EXPECT_EQ((*cameras)[0].id, "B1");
  EXPECT_EQ((*cameras)[1].id, "A00364A13385040A");
  EXPECT_EQ((*cameras)[1].camera.port, "1-1.1");
}

TEST_F(Libusb, TakesTheSettingThatCarriesTheStream) {
  KinectSettings settings;
  settings.for_windows = true;
  KinectCameraModel windows(settings, picture);
  fake::plug("3-1", windows);
  const auto source = opened("");
  ASSERT_TRUE(source);
  ASSERT_TRUE(source->start());
  EXPECT_EQ(fake::port("3-1").alternate_setting, 1);
  const auto frame = source->next(image(), 5000);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(is_right(*frame));
}

TEST_F(Libusb, StreamsTwoAtOnce) {
  KinectSettings settings;
  settings.serial = "OTHER";
  KinectCameraModel other(settings,
                          [](std::uint64_t n, std::span<std::uint16_t> raw) { picture(n + 1'000'003, raw); });
  fake::plug("1-1", camera_);
  fake::plug("1-2", other);
  const auto a = opened("A00364A13385040A");
  const auto b = opened("OTHER");
  ASSERT_TRUE(a && b);
  ASSERT_TRUE(a->start());
  ASSERT_TRUE(b->start());
  for (int n = 0; n < 15; ++n) {
    const auto one = a->next(image(), 5000);
    ASSERT_TRUE(one) << one.error().message;
    EXPECT_TRUE(is_right(*one));
    const auto two = b->next(image(), 5000);
    ASSERT_TRUE(two) << two.error().message;
    EXPECT_TRUE(is_right(*two, 1'000'003));
  }
  fake::unplug("1-2");
  for (int n = 0; n < 5; ++n) EXPECT_TRUE(a->next(image(), 5000)) << "only the other one was pulled out";
}

// Android: no bus may be listed, a descriptor is all there is.
TEST_F(Libusb, OpensWhatAnotherProcessOpened) {
  fake::no_usb(true);
  fake::plug("1-1.1", camera_);
  fake::plug("1-1.2", motor_);
  fake::give_descriptor(41, "1-1.1");
  fake::give_descriptor(42, "1-1.2");
  {
    const auto source = opened("fd=41,42");
    ASSERT_TRUE(source);
    EXPECT_TRUE(fake::discovery_was_off());
    EXPECT_EQ(source->info().uri, "usb:fd=41,42");
    EXPECT_EQ(source->info().serial, "A00364A13385040A");
    EXPECT_TRUE(source->down());
    ASSERT_TRUE(source->start());
    for (int n = 0; n < 3; ++n) {
      const auto frame = source->next(image(), 5000);
      ASSERT_TRUE(frame) << frame.error().message;
      EXPECT_TRUE(is_right(*frame));
    }
    fake::unplug("1-1.1");
    Error lost;
    for (int i = 0; i < 12 && lost.code != ErrorCode::no_device; ++i)
      if (const auto got = source->next(image(), 5000); !got) lost = got.error();
    EXPECT_EQ(lost.code, ErrorCode::no_device);
  }
  fake::plug("1-1.1", camera_);
  Error error = refused("fd=42");
  EXPECT_EQ(error.code, ErrorCode::unsupported);
  EXPECT_TRUE(says(error, "no Kinect camera")) << error.message;
  error = refused("fd=7");
  EXPECT_EQ(error.code, ErrorCode::invalid_argument);
  EXPECT_TRUE(says(error, "file descriptor 7")) << error.message;
  EXPECT_EQ(refused("fd=41,7").code, ErrorCode::invalid_argument);
}

}  // namespace
}  // namespace im2fit::hal
