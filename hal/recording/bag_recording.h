// SPDX-License-Identifier: Apache-2.0
// Depth in a rosbag of ROS 1: of RealSense's programs (realsense-viewer, rs-record), or of any camera as sensor_msgs.
#pragma once

#include <memory>
#include <string>

#include "hal/recording/file_cursor.h"
#include "hal/recording/recording_source.h"

namespace im2fit::hal {

// The depth topic is the one of type sensor_msgs/Image with the word depth in its name: RealSense's own, else
// image_raw, image_rect_raw, image_rect, image, and the camera's own view before one that follows the colour camera.
// Pictures are mono16 or 16UC1 (mm; RealSense's in its option Depth_Units) or 32FC1 (m). The calibration is
// the first camera_info beside them; `options` may replace it.
// Open errors: not_found (no depth topic, no camera_info), invalid_argument (several depth topics), corrupt,
// unsupported, io. A damaged chunk gives `corrupt` once, and those behind it are read; so does a wrong
// time (frame_times.h).
Result<std::unique_ptr<Source>> open_bag_recording(const std::string& path, const RecordingOptions& options);
Result<std::unique_ptr<Source>> open_bag_recording(FileCursor file, const RecordingOptions& options);

}  // namespace im2fit::hal
