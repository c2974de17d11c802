// SPDX-License-Identifier: Apache-2.0
// An OpenNI2 camera that went away, found again.
#pragma once

#include <memory>
#include <string>

#include "hal/openni2/openni2_source.h"

namespace im2fit::hal {

// A USB camera that is plugged in again has another URI, which its driver announces to the running runtime: so the
// runtime's list is checked. The runtime never accepts a lost URI again until it is restarted. A restart leaks memory
// in the drivers, and it hangs (2.2.0.33: two locks taken in both orders) when a driver announces a device at that
// moment, as does opening a URI that is not in the list. So the runtime is restarted only when the machine's USB
// devices have not changed for two seconds, then with growing pauses up to ten minutes, and not while another source
// of the process holds it.
class OpenNi2Finder {
 public:
  // Opens `uri` as OpenNi2Source::open does; a camera that is not there may be when this is called again.
  Result<std::unique_ptr<OpenNi2Source>> open(const std::string& uri, const OpenNi2Options& options);
  // Opens the camera described by `lost`, wherever it is plugged in now: of the cameras of that name the one
  // with its serial. Without a match another camera is returned; the caller compares.
  Result<std::unique_ptr<OpenNi2Source>> find(const SourceInfo& lost, const OpenNi2Options& options);

 private:
  Status begin();
  Result<std::unique_ptr<OpenNi2Source>> try_open(const std::string& uri, const OpenNi2Options& options);
  Result<std::unique_ptr<OpenNi2Source>> not_listed(const std::string& uri, const OpenNi2Options& options);
  bool time_to_begin_again();

  std::shared_ptr<OpenNi2Runtime> runtime_;
  bool searching_ = false;     // nothing could be opened since the last success
  std::string usb_devices_;    // at the last check while searching
  std::int64_t since_ns_ = 0;  // when searching began, these changed, or the runtime was begun again
  std::int64_t pause_ns_ = 0;
};

}  // namespace im2fit::hal
