// SPDX-License-Identifier: Apache-2.0
// The constants of sensor.cpp. When a user is accepted as a person: segment/person_tracker_limits.h.
#pragma once

namespace im2fit::sensor_limits {

inline constexpr float kLostShareMax = 0.30F;  // pixels without data: as in segment/advice_limits.h

}  // namespace im2fit::sensor_limits
