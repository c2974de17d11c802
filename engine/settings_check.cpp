// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <string>

#include "core/camera.h"
#include "engine/engine.h"
#include "hal/source.h"

namespace im2fit {
namespace {

Status check_range(const char* name, int value, int low, int high) {
  if (value >= low && value <= high) return Ok{};
  return Error{ErrorCode::invalid_argument, std::string("engine setting ") + name + " is " + std::to_string(value) +
                                                ", expected " + std::to_string(low) + " to " + std::to_string(high)};
}

std::string text_of(const FloorRegion& region) {
  std::string text;
  for (const float mm : {region.x0_mm, region.z0_mm, region.x1_mm, region.z1_mm})
    text += (text.empty() ? "" : ",") + std::to_string(mm * 0.001F);
  return text + " m";
}

}  // namespace

Status check_region(const std::optional<FloorRegion>& region) {
  if (!region || is_region(*region)) return Ok{};
  return Error{ErrorCode::invalid_argument, "the region is " + text_of(*region) +
                                                ", expected x0 < x1 and z0 < z1, each at most 20 m from the camera"};
}

Status check_settings(const EngineSettings& s) {
  if (auto ok = check_range("width", s.width, 1, kImageSideMax); !ok) return ok;
  if (auto ok = check_range("height", s.height, 1, kImageSideMax); !ok) return ok;
  if (auto ok = check_range("frames_wanted", s.frames_wanted, 1, kFramesWantedMax); !ok) return ok;
  if (auto ok = check_range("frames_min", s.frames_min, 1, s.frames_wanted); !ok) return ok;
  if (auto ok = check_range("pool_frames", s.pool_frames, kPoolFramesMin, kPoolFramesMax); !ok) return ok;
  if (s.one_after_another)
    if (auto ok = check_range("pool_frames (one after another)", s.pool_frames, kPoolFramesMin, kAbsentPeriodsMax);
        !ok)
      return ok;
  if (auto ok = check_range("user", s.user, 0, std::numeric_limits<int>::max()); !ok) return ok;
  if (auto ok = check_region(s.region); !ok) return ok;
  if (s.intrinsics.width != s.width || s.intrinsics.height != s.height)
    return Error{ErrorCode::invalid_argument, "engine intrinsics are for " + std::to_string(s.intrinsics.width) +
                                                  "x" + std::to_string(s.intrinsics.height) + ", the frames are " +
                                                  std::to_string(s.width) + "x" + std::to_string(s.height)};
  return hal::check_intrinsics(s.intrinsics, "engine intrinsics");
}

}  // namespace im2fit
