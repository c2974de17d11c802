// SPDX-License-Identifier: Apache-2.0
// What the virtual camera shows: the environment gives defaults, the URI's query overrides them.
#pragma once

#include <cstdint>
#include <string>

#include "core/status.h"

namespace im2fit::openni2_virtual {

inline constexpr const char* kScheme = "im2fit-virtual://";

// Query key and environment variable of each are beside it.
struct Settings {
  std::uint64_t seed = 0;           // im2fit-virtual://SEED          IM2FIT_VIRTUAL_SEED
  std::string body_path;            // body=                          IM2FIT_VIRTUAL_BODY, else IM2FIT_BODY
  std::string folder;               // folder=: replay this folder    IM2FIT_VIRTUAL_FOLDER
  std::string family = "held_out";  // family=training|held_out|paper IM2FIT_VIRTUAL_FAMILY
  std::string pose = "relaxed";     // pose=relaxed|a_pose|psi|free   IM2FIT_VIRTUAL_POSE
  int width = 640;                  // size=640x480 or 320x240        IM2FIT_VIRTUAL_SIZE
  int height = 480;
  int fps = 30;             // fps=1..1000                    IM2FIT_VIRTUAL_FPS
  int rotate_deg = 90;      // rotate=0|90|180|270            IM2FIT_VIRTUAL_ROTATE
  int furniture_count = 3;  // furniture=0..20                IM2FIT_VIRTUAL_FURNITURE
  int noise = 1;            // noise=0|1: 0 is a perfect sensor IM2FIT_VIRTUAL_NOISE
  int back_view = 0;        // back=0|1                       IM2FIT_VIRTUAL_BACK
  int unplug_ms = -1;       // unplug_ms=: pulled out so long after the stream starts; IM2FIT_VIRTUAL_UNPLUG_MS
  int replug_ms = -1;       // replug_ms=: put back so long after that, under another URI; IM2FIT_VIRTUAL_REPLUG_MS
  int plug = 0;             // plug=: how often it was put back: nothing but another URI
};

// The URI the driver announces of itself: only when the environment names a virtual camera, so that a real camera
// stays the default device. "" when it does not.
std::string announced_uri();
// The URI of the same device when it was unplugged and plugged in again.
std::string plugged_in_again(const std::string& uri);
// Error: invalid_argument naming the key.
Result<Settings> settings_of(const std::string& uri);

}  // namespace im2fit::openni2_virtual
