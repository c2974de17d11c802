// SPDX-License-Identifier: Apache-2.0
// A recording of an Azure Kinect or a Femto, as k4arecorder, k4aviewer and Orbbec's wrapper write it: Matroska with
// an uncompressed track of 16-bit big-endian millimetres, and the camera's factory calibration as an attachment.
// Colour, infrared and the accelerometer are not read.
#pragma once

#include <memory>
#include <string>

#include "hal/recording/file_cursor.h"
#include "hal/recording/recording_source.h"

namespace im2fit::hal {

// The depth track is the one that the tag K4A_DEPTH_TRACK names, else the one named DEPTH, else the only
// one with such pictures. The calibration is the attachment calibration.json, or the one that the tag
// K4A_CALIBRATION_FILE names; `options` may replace it.
// Open errors: not_found (no depth track, no calibration), corrupt, unsupported (compressed pictures), io. A file
// that was cut off gives its whole pictures, then `corrupt` once, then end_of_stream.
Result<std::unique_ptr<Source>> open_kinect_recording(const std::string& path, const RecordingOptions& options);
Result<std::unique_ptr<Source>> open_kinect_recording(FileCursor file, const RecordingOptions& options);

}  // namespace im2fit::hal
