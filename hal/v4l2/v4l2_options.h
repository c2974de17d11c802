// SPDX-License-Identifier: Apache-2.0
// The user's options for a V4L2 camera: /dev/video0?format=Y16&unit_um=1000&hfov=58
#pragma once

#include <optional>
#include <string>

#include "hal/intrinsics.h"

namespace im2fit::hal {

// Z16: depth, the unit is the camera's. INZI: an infrared picture, then Z16 (SR300). Y16: nominally grey; depth only
// where the user specifies it.
enum class V4l2Format { z16, inzi, y16 };

struct V4l2Options {
  std::string path;                  // /dev/videoN; "": the first depth camera, or the one with `serial`
  std::string serial;                // as USB reports it; "": any
  std::optional<V4l2Format> format;  // unset: Z16, else INZI
  int width = 640;                   // wanted; the nearest the camera offers is taken
  int height = 480;
  int fps = 30;
  std::optional<int> unit_um;     // 1..100'000; unset: `unit_control`, else 1000 (INZI has no default)
  std::string unit_control;       // name of a driver's control that holds the unit in micrometres
  std::optional<float> hfov_deg;  // of the whole picture, square pixels; used without calibration
  int rotate_deg = 0;
  std::optional<Calibration> calibration;  // of the mode's size. Its rotate_deg is ignored
  int buffer_count = 4;                    // 2..32 in flight
};

// `text`: the part after "v4l2:"; keys format, unit_um, unit_control, hfov, size (WxH), fps and serial replace those
// of `defaults`. Error: invalid_argument, naming the key.
Result<V4l2Options> parse_v4l2_uri(const std::string& text, const V4l2Options& defaults);
// The URI, "v4l2:" included, that opens the same camera in the same mode again, given the same calibration: by its
// serial number if it has one, else by path.
std::string v4l2_uri(const V4l2Options& options);

}  // namespace im2fit::hal
