// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/v4l2/negotiate.h"

namespace im2fit::hal {

// Micrometres to a step of the camera's values. V4L2 fixes none for Z16 and has no control for it, so: what the user
// says, else the driver's control the user names, else 1000. INZI cameras have units of their own and no default.
// Errors: invalid_argument, not_found (no such control; the error lists those there are), unsupported.
Result<int> depth_unit_um(VideoDevice& device, V4l2Format format, const V4l2Options& options,
                          const std::string& what);

}  // namespace im2fit::hal
