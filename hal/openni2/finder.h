// SPDX-License-Identifier: Apache-2.0
// An OpenNI2 camera that went away, found again.
#pragma once

#include <memory>
#include <string>

#include "hal/openni2/openni2_source.h"

namespace im2fit::hal {

// A USB camera that is plugged in again has another URI, which its driver announces to the running runtime. A URI
// that went away the runtime never takes back until it is begun again; that leaves memory behind in the drivers, so
// it is done when the machine's USB devices changed, else with growing pauses up to ten minutes, and only while no
// other source of the process holds the runtime.
class OpenNi2Finder {
 public:
  // Opens `uri` as OpenNi2Source::open does.
  Result<std::unique_ptr<OpenNi2Source>> open(const std::string& uri, const OpenNi2Options& options);
  // Opens the camera that said `lost` of itself, wherever it is plugged in now: of the cameras of that name the one
  // with its serial. A stranger is returned when there is no better; the caller compares.
  Result<std::unique_ptr<OpenNi2Source>> find(const SourceInfo& lost, const OpenNi2Options& options);

 private:
  Status begin_again_at_times();
  std::shared_ptr<OpenNi2Runtime> runtime_;
  std::string usb_devices_;  // when the runtime was begun
  std::int64_t begun_ns_ = 0;
  std::int64_t pause_ns_ = 0;
};

}  // namespace im2fit::hal
