// SPDX-License-Identifier: Apache-2.0
// The words for USB cameras, and libusb itself as far as a machine without one goes. Inside the guest there is more.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "hal/open/open.h"
#include "tests/hal/support.h"

namespace im2fit::hal {
namespace {

#if IM2FIT_HAVE_USB

TEST(UsbOpen, ACameraThatIsNotThereIsNoDevice) {
  const auto source = open_source("usb:im2fit-no-such-serial");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::no_device) << source.error().message;
  EXPECT_TRUE(contains(source.error().message, "usb:im2fit-no-such-serial")) << source.error().message;
  EXPECT_TRUE(contains(source.error().message, "plug it in")) << source.error().message;
}

TEST(UsbOpen, NothingPluggedInIsAnEmptyListAndNoError) {
  const auto devices = list_devices();
  ASSERT_TRUE(devices) << devices.error().message;
  for (const auto& device : *devices) EXPECT_NE(device.uri, "usb:") << device.name;
}

// As Android hands a device over. What is no USB device is refused, and stays open: it is the caller's.
TEST(UsbOpen, AFileDescriptorThatIsNoUsbDeviceIsRefused) {
  const int descriptor = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  for (int round = 0; round < 3; ++round) {
    const auto source = open_source("usb:fd=" + std::to_string(descriptor));
    ASSERT_FALSE(source);
    EXPECT_TRUE(contains(source.error().message, "file descriptor " + std::to_string(descriptor)))
        << source.error().message;
    EXPECT_NE(::fcntl(descriptor, F_GETFD), -1) << "it was closed";
  }
  ::close(descriptor);
  EXPECT_FALSE(open_source("usb:fd=" + std::to_string(descriptor))) << "a closed one";
  for (const char* bad : {"usb:fd=", "usb:fd=x", "usb:fd=-1", "usb:fd=3,", "usb:fd=3,x", "usb:fd=99999999999"}) {
    const auto source = open_source(bad);
    ASSERT_FALSE(source) << bad;
    EXPECT_EQ(source.error().code, ErrorCode::invalid_argument) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "usb:fd=")) << source.error().message;
  }
}

TEST(UsbOpen, ReadsTheCalibrationBeforeItLooksForTheCamera) {
  OpenOptions options;
  options.camera_yaml_path = "/nonexistent/camera.yaml";
  const auto source = open_source("usb", options);
  ASSERT_FALSE(source);
  EXPECT_TRUE(contains(source.error().message, "/nonexistent/camera.yaml")) << source.error().message;
}

#else

TEST(UsbOpen, WithoutLibusbSaysSo) {
  for (const char* word : {"usb", "usb:A0123"}) {
    const auto source = open_source(word);
    ASSERT_FALSE(source);
    EXPECT_EQ(source.error().code, ErrorCode::unsupported);
    EXPECT_TRUE(contains(source.error().message, "libusb-1.0-0-dev")) << source.error().message;
  }
}

#endif

}  // namespace
}  // namespace im2fit::hal
