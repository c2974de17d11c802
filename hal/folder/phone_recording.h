// SPDX-License-Identifier: Apache-2.0
// What the recordings of iPhones and iPads with LiDAR have in common, whatever app made them: ARKit's poses and the
// lens of its colour picture.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/folder/calibration_words.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/pose_rows.h"

namespace im2fit::hal {

struct PhoneRecording {
  std::string path;                          // the folder, for SourceInfo
  FolderContents contents;                   // paths of frames, confidence and table; the rest is filled in
  std::pair<DepthHeader, std::string> size;  // of the pictures, and the one that it is known from
  std::vector<PoseRow> rows;                 // empty: a phone on a stand
  PinholeLens colour_lens{};  // of the colour picture in landscape; rows with a lens replace it by their mean
  std::string lens_path;      // its file
};

bool file_exists(const std::string& path);
// The size of the folder's first picture with a sound header, and its path. Errors: as FolderSource::open.
Result<std::pair<DepthHeader, std::string>> first_depth_size(const std::string& folder);

// The intrinsics are those of the colour picture, scaled; the pictures are turned upright by the gravity of the first
// pose. Without rows the phone is taken to be held upright, and frames to be 1/60 s apart. Pictures that somebody has
// turned upright (3 wide, 4 high) are read as such. `options` may replace calibration and rotation.
Result<std::unique_ptr<FolderSource>> open_phone_recording(PhoneRecording recording, const FolderOptions& options);

}  // namespace im2fit::hal
