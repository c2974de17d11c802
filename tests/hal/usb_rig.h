// SPDX-License-Identifier: Apache-2.0
// A Kinect in software with its motor, opened as a real one is, and what each of its pixels must become.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/usb/kinect_open.h"
#include "tests/devices/kinect_model.h"
#include "tests/hal/support.h"
#include "tests/hal/usb_model_bus.h"

namespace im2fit::hal {

using devices::KinectCameraModel;
using devices::KinectMotorModel;
using devices::KinectSettings;

constexpr int kWidth = 640;  // other rigs have others
constexpr int kHeight = 480;
inline constexpr std::int64_t kFrame_us = 33'500;  // a little more than one

// Any value at any place, another in each frame.
inline std::uint16_t raw_at(std::uint64_t number, std::size_t i) {
  const std::uint64_t z = (number * 307'201 + i + 1) * 0x9E3779B97F4A7C15ULL;
  return static_cast<std::uint16_t>((z >> 40) % 2048);
}
inline void picture(std::uint64_t number, std::span<std::uint16_t> raw) {
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = raw_at(number, i);
}

// What the camera means, in millimetres.
inline std::vector<std::uint16_t> millimetres(const KinectSettings& settings) {
  std::vector<std::uint16_t> table(2048);
  for (int raw = 0; raw < 2048; ++raw)
    table[static_cast<std::size_t>(raw)] = devices::mm_of_shift(settings, static_cast<std::uint16_t>(raw));
  return table;
}

struct Rig {
  explicit Rig(const KinectSettings& s = {}, bool with_motor = true)
      : settings(s), camera(s, picture), table(millimetres(s)), out(kWidth, kHeight) {
    bus.plug("1-1.1", camera);
    if (with_motor) bus.plug("1-1.2", motor);
  }
  Status open(const KinectOptions& options = {}, const std::string& id = "") {
    source.reset();
    auto opened = open_kinect(bus, id, options);
    if (!opened) return opened.error();
    source = std::move(*opened);
    return Ok{};
  }
  void run(std::int64_t us) { bus.run("1-1.1", us); }
  // Whether `out` is frame `number` of the model to the last pixel.
  bool is_frame(std::uint64_t number) const {
    for (std::size_t i = 0; i < out.pixels.size(); ++i)
      if (out.pixels[i] != table[raw_at(number, i)]) return false;
    return true;
  }

  KinectSettings settings;
  KinectCameraModel camera;
  KinectMotorModel motor;
  ModelBus bus;
  std::vector<std::uint16_t> table;
  std::unique_ptr<KinectSource> source;
  Picture out;
};

inline void expect_ok(const Status& status) {
  EXPECT_TRUE(status) << status.error().message;
}

inline void expect_direction(const std::optional<Vec3f>& got, float x, float y, float z) {
  ASSERT_TRUE(got);
  EXPECT_NEAR(got->x, x, 0.002);
  EXPECT_NEAR(got->y, y, 0.002);
  EXPECT_NEAR(got->z, z, 0.002);
}

}  // namespace im2fit::hal
