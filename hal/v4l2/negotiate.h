// SPDX-License-Identifier: Apache-2.0
// Negotiates a mode from the formats of a V4L2 camera and the requested options, and reads the depth of its buffers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "hal/v4l2/v4l2_options.h"
#include "hal/v4l2/video_device.h"

namespace im2fit::hal {

// Where the depth lies in a V4L2 buffer, and its conversion to millimetres.
struct DepthLayout {
  int width = 0;
  int height = 0;
  std::size_t offset_bytes = 0;  // of the first depth row
  std::size_t stride_bytes = 0;  // from row to row, at least 2 * width
  int unit_um = 1000;            // of one step of the 16-bit values, 1..100'000

  // Up to the last pixel: drivers may leave out the padding behind it.
  std::size_t size_bytes() const;
};

// Fills `out`, rounded to mm, 0.5 up; depths beyond 65,535 mm become 0, no data. False, with `out` untouched,
// when `buffer` is too short or `out` has another size. The values are little-endian, as Z16 and Y16 are.
bool copy_depth(std::span<const std::byte> buffer, const DepthLayout& layout, DepthImage out);

struct V4l2Camera {
  std::string name;                    // card, as the driver calls it
  std::string bus;                     // where it is plugged in
  std::vector<std::uint32_t> formats;  // fourccs it offers
  bool offers(V4l2Format format) const;
  bool is_depth() const { return offers(V4l2Format::z16) || offers(V4l2Format::inzi); }
};

// Errors: unsupported (no V4L2, no streaming capture), no_device.
Result<V4l2Camera> describe_camera(VideoDevice& device, const std::string& what);

struct V4l2Mode {
  V4l2Format format = V4l2Format::z16;
  DepthLayout layout;
  std::size_t buffer_bytes = 0;  // a whole buffer, as the driver has it
  float fps = 0;                 // 0: the driver does not report it
};

// Sets format, size nearest to the one wanted, and frame rate. Errors: unsupported, io, no_device.
Result<V4l2Mode> negotiate(VideoDevice& device, const V4l2Camera& camera, const V4l2Options& options,
                           const std::string& what);

std::uint32_t fourcc_of(V4l2Format format);
// An errno in our words: ENODEV, ENXIO and EIO mean that the camera is gone.
Error device_error(int error, const std::string& what, const std::string& doing);

}  // namespace im2fit::hal
