// SPDX-License-Identifier: Apache-2.0
// A scan as a source of frames: a camera that looks at the front, then goes round once, with its poses.
#pragma once

#include <memory>
#include <string>

#include "hal/scan/standing_scan.h"
#include "hal/source.h"

namespace im2fit::hal {

// Pictures from the front, and of the way round: as many as of a person who is walked round in fifteen seconds.
inline constexpr int kScanFrontFrames = 45, kScanRoundFrames = 450, kScanEndFrames = 15;

// `path`: a name for which is_scan_name() is true. Its info().name tells the unit and the axis that were found.
// Errors: as read_scan and stand_scan.
Result<std::unique_ptr<Source>> open_scan(const std::string& path, const ScanOptions& options = {});

}  // namespace im2fit::hal
