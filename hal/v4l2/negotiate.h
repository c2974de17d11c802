// SPDX-License-Identifier: Apache-2.0
// Negotiates a mode from the formats of a V4L2 camera and the requested options.
#pragma once

#include <string>
#include <vector>

#include "hal/v4l2/depth_frame.h"
#include "hal/v4l2/v4l2_options.h"
#include "hal/v4l2/video_device.h"

namespace im2fit::hal {

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
