// SPDX-License-Identifier: Apache-2.0
#include "capi/settings.h"

#include <cstdint>
#include <limits>
#include <string>

#include "core/camera.h"
#include "engine/engine.h"
#include "hal/source.h"

namespace im2fit::c {
namespace {

struct Field {
  const char* name;
  std::int32_t value, low, high;
};

}  // namespace

Status check_settings(const im2fit_settings& s) {
  const Field fields[] = {
      {"width", s.width, 1, kImageSideMax},
      {"height", s.height, 1, kImageSideMax},
      {"frames_wanted", s.frames_wanted, 1, kFramesWantedMax},
      {"frames_min", s.frames_min, 1, s.frames_wanted},
      {"calibration_psi", s.calibration_psi, 0, 1},
      {"live", s.live, 0, 1},
      {"single_thread", s.single_thread, 0, 1},
      {"pool_frames", s.pool_frames, kPoolFramesMin, kPoolFramesMax},
      {"user_id", s.user_id, 0, std::numeric_limits<std::int32_t>::max()},
      {"turn", s.turn, 0, 1},
      {"clothing", s.clothing, IM2FIT_CLOTHING_UNKNOWN, IM2FIT_CLOTHING_DRESSED},
      {"sensor", s.sensor, IM2FIT_SENSOR_UNKNOWN, IM2FIT_SENSOR_TIME_OF_FLIGHT},
  };
  for (const Field& field : fields)
    if (field.value < field.low || field.value > field.high)
      return Error{ErrorCode::invalid_argument, std::string("settings.") + field.name + " is " +
                                                    std::to_string(field.value) + ", expected " +
                                                    std::to_string(field.low) + " to " + std::to_string(field.high)};
  return hal::check_intrinsics({s.width, s.height, s.fx, s.fy, s.cx, s.cy}, "settings");
}

}  // namespace im2fit::c
