// SPDX-License-Identifier: Apache-2.0
// The Kinect's motor and accelerometer: the direction of down, and tilting.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/hal/usb_rig.h"

namespace im2fit::hal {
namespace {

TEST(UsbKinect, KnowsTheDirectionOfDown) {
  Rig rig;
  expect_ok(rig.open());
  expect_direction(rig.source->down(), 0, 1, 0);
  // The head looks down by 30 degrees: z points to the floor and feels the push upwards as negative.
  rig.motor.set_acceleration(0, 709, -410);
  expect_direction(rig.source->down(), 0, 0.866F, 0.5F);
  // Rolled clockwise as seen from behind: its left side points up.
  rig.motor.set_acceleration(410, 709, 0);
  expect_direction(rig.source->down(), 0.5F, 0.866F, 0);
  rig.motor.set_acceleration(0, 1200, 0);
  EXPECT_FALSE(rig.source->down()) << "it is being pushed";
  rig.motor.set_acceleration(0, 0, 0);
  EXPECT_FALSE(rig.source->down());
  rig.motor.stalls = true;
  EXPECT_FALSE(rig.source->down());
  rig.motor.stalls = false;
  rig.motor.set_acceleration(0, 819, 0);
  rig.bus.unplug("1-1.2");
  EXPECT_FALSE(rig.source->down()) << "the motor is gone; the camera is not";
  expect_ok(rig.source->start());
}

// A camera on its side: turning the picture upright turns the direction of gravity along with it.
TEST(UsbKinect, TurnsDownWithThePicture) {
  struct {
    int rotate_deg;
    int x, y;  // felt by the camera as it hangs
  } const mountings[] = {{0, 0, 819}, {90, 819, 0}, {180, 0, -819}, {270, -819, 0}};
  for (const auto& mounting : mountings) {
    Rig rig;
    KinectOptions options;
    options.rotate_deg = mounting.rotate_deg;
    expect_ok(rig.open(options));
    rig.motor.set_acceleration(mounting.x, mounting.y, 0);
    expect_direction(rig.source->down(), 0, 1, 0);
  }
  // The same by pixels: down in the camera's picture, one step, lands one step down in the upright one.
  for (const int rotate_deg : {0, 90, 180, 270}) {
    const bool quarter = rotate_deg % 180 != 0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
      Picture in(9, 5), out(quarter ? 5 : 9, quarter ? 9 : 5);
      in.image().at(4, 2) = 1;
      in.image().at(4 + dx, 2 + dy) = 2;
      rotate_upright(in.view(), rotate_deg, out.image());
      int from = 0, to = 0;
      for (int i = 0; i < 45; ++i) {
        if (out.pixels[static_cast<std::size_t>(i)] == 1) from = i;
        if (out.pixels[static_cast<std::size_t>(i)] == 2) to = i;
      }
      const Vec3f got = rotate_upright(Vec3f{static_cast<float>(dx), static_cast<float>(dy), 3}, rotate_deg);
      EXPECT_EQ(got.x, static_cast<float>(to % out.width - from % out.width)) << rotate_deg;
      EXPECT_EQ(got.y, static_cast<float>(to / out.width - from / out.width)) << rotate_deg;
      EXPECT_EQ(got.z, 3.0F);
    }
  }
}

TEST(UsbKinect, Tilts) {
  Rig rig;
  expect_ok(rig.open());
  KinectMotor* motor = rig.source->motor();
  ASSERT_NE(motor, nullptr);
  expect_ok(motor->set_tilt(-12.5F));
  EXPECT_EQ(rig.motor.target_half_deg(), -25);
  auto state = motor->state();
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->moving);
  EXPECT_FALSE(state->tilt_deg);
  EXPECT_FALSE(rig.source->down()) << "moving";
  rig.bus.idle("1-1.2", 2'000'000);
  state = motor->state();
  ASSERT_TRUE(state);
  EXPECT_FALSE(state->moving);
  EXPECT_EQ(state->tilt_deg, -12.5F);
  EXPECT_NEAR(state->acceleration_g.y, 1, 1e-6);
  for (const float beyond : {31.5F, -32.0F, NAN})
    EXPECT_EQ(motor->set_tilt(beyond).error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(rig.motor.target_half_deg(), -25) << "beyond its range the motor gets no command";
  expect_ok(motor->set_tilt(31));
  rig.bus.idle("1-1.2", 9'000'000);
  EXPECT_TRUE(motor->state()->at_limit);
  rig.bus.unplug("1-1.2");
  EXPECT_EQ(motor->state().error().code, ErrorCode::no_device);
  EXPECT_EQ(motor->set_tilt(0).error().code, ErrorCode::no_device);
}

TEST(UsbKinect, NeedsNoMotor) {
  Rig rig({}, false);
  expect_ok(rig.open());
  EXPECT_EQ(rig.source->motor(), nullptr);
  EXPECT_FALSE(rig.source->down());
  KinectSettings settings;
  settings.for_windows = true;
  Rig windows(settings);  // the motor there is another camera's
  expect_ok(windows.open());
  EXPECT_EQ(windows.source->motor(), nullptr);
  EXPECT_EQ(windows.source->info().name, "Kinect for Windows");
  EXPECT_EQ(windows.source->info().intrinsics_origin, IntrinsicsOrigin::device);
  expect_ok(windows.source->start());
  EXPECT_EQ(windows.bus.port("1-1.1").interface_setting, 1);
  windows.run(kFrame_us);
  ASSERT_TRUE(windows.source->next(windows.out.image(), 0));
  EXPECT_TRUE(windows.is_frame(0));
}

}  // namespace
}  // namespace im2fit::hal
