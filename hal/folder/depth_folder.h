// SPDX-License-Identifier: Apache-2.0
// Depth folders in and out (docs/cameras): NNNNNN.png or .pgm in mm, camera.yaml, and optionally timestamps.csv,
// poses.csv (hal/folder/pose_rows.h) and confidence/NNNNNN.png.
//
// timestamps.csv: a header naming its columns, then a row a frame. Columns: frame (the file's number) and host_ns,
// device_us or both; times must grow from row to row. Without it frames are taken to be 1/30 s apart. A camera that
// measures gravity also has down_x, down_y and down_z (FrameInfo::down), empty where it was not read. They refer to
// upright pictures and are ignored in a folder with a rotation.
//
// poses.csv: for the frames as stored; a frame without a row has no pose. confidence/: one 8-bit picture for each
// frame; pixels below camera.yaml's im2fit_confidence_min have no depth.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_file.h"
#include "hal/frame_path.h"

namespace im2fit::hal {

// Where camera.yaml does not specify it: the highest of ARKit's levels 0, 1, 2.
inline constexpr int kConfidenceMin = 2;

// What another recorder keeps in files of its own (hal/folder/stray_scanner.h). For frames as stored.
struct FolderContents {
  std::string frames_path, confidence_path;  // the second is empty where the recorder keeps no confidence
  bool confidence_beside = false;            // that of depth_00012.png is conf_00012.png, in its folder
  CameraFile camera;
  std::map<std::uint64_t, FrameInfo> frames;  // by number; empty: there are neither times nor poses
  std::int64_t frame_ns = 0;                  // from frame to frame, where `frames` is empty
  std::string camera_path, table_path;        // the files of `camera` and `frames`, for errors
  SensorKind sensor = SensorKind::unknown;
  // Files whose names are not numbers, in order: in place of `frames_path` and `frames`.
  struct Listed {
    std::string path;
    FrameInfo info;
  };
  std::vector<Listed> listed;
};

struct FolderOptions {
  std::optional<int> rotate_deg;  // overrides camera.yaml's im2fit_rotate_deg; 0 when neither says
  std::string camera_yaml_path;   // "" for camera.yaml in the folder
  double unit_mm =
      0;  // 0: as the folder has it, 1 mm; a unit of the pixels; values are rounded, above 65535 mm they are missing
  const FolderContents* contents = nullptr;  // in place of camera.yaml and the tables beside it; for open() only
};

// Replays every frame in order of number, as fast as it is read; a missing number is counted as a gap. open() lists
// the folder and reads the header of the first sound picture; all others are opened when their turn comes. One rule
// for damage, whatever it is (empty, cut off, a wrong checksum): that frame gives `corrupt` once, is counted in
// stats().damaged, and the frame after it comes next; when not one picture has a sound header, open() gives the first
// one's error. A picture of another size or kind ends the recording: next() gives invalid_argument or unsupported.
class FolderSource final : public Source {
 public:
  static Result<std::unique_ptr<FolderSource>> open(const std::string& path, const FolderOptions& options = {});

  const SourceInfo& info() const override { return info_; }
  Status start() override;
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override {}
  SourceStats stats() const override { return book_.stats(); }
  // Pixels that the recording is not sure of have no depth.
  bool uses_confidence() const { return !confidence_of(frames_.front()).empty(); }

 private:
  struct Frame {
    std::string path;
    FrameInfo info;
  };
  FolderSource() = default;
  Status scan(const std::string& path);
  Result<DepthHeader> first_header() const;
  std::optional<Error> foreign(const Frame& frame);  // whose file is in file_bytes_
  Status read_timestamps(const std::string& path);
  Status read_poses(const std::string& path);
  Status take_tables(const std::string& path);
  Status take_contents(const FolderContents& contents);
  Status check_confidence();
  std::string confidence_of(const Frame& frame) const;  // "": there is none
  Status drop_unsure(const Frame& frame);

  SourceInfo info_;
  UprightPath path_;
  std::vector<Frame> frames_;
  std::size_t index_ = 0;
  std::vector<std::byte> file_bytes_;
  DepthDecoder decoder_;
  std::string confidence_folder_;  // "": there is none
  bool confidence_beside_ = false;
  int confidence_min_ = kConfidenceMin;
  std::vector<std::uint8_t> confidence_;
  SequenceBook book_;
};

class FolderWriter {
 public:
  struct Options {
    DepthFormat format = DepthFormat::png;
    std::string camera_name = "depth camera";
    int rotate_deg = 0;  // for camera.yaml: what a reader must undo; 0 for pictures that are upright already
    IntrinsicsOrigin origin = IntrinsicsOrigin::calibration_file;
  };
  // Makes the folder and writes camera.yaml. Refuses a folder that already holds frames. Whatever ends the program
  // afterwards, the folder is a recording up to the last frame written: a frame appears whole, after its rows of
  // timestamps.csv and, of a camera that moves, poses.csv.
  static Result<std::unique_ptr<FolderWriter>> create(const std::string& path, const Intrinsics& intrinsics,
                                                      const Options& options);
  ~FolderWriter();  // finishes; call finish() to learn of errors
  FolderWriter(const FolderWriter&) = delete;
  FolderWriter& operator=(const FolderWriter&) = delete;

  // Files are numbered by info.sequence from 0, so that gaps stay visible. A frame that fails leaves no file behind.
  // Times that do not grow are dropped: the device_us column, or the whole timestamps.csv.
  Status write(DepthView frame, const FrameInfo& info);
  Status finish();  // timestamps.csv and poses.csv to the disk
  int frame_count() const { return static_cast<int>(rows_.size()); }

 private:
  FolderWriter(std::string path, const Intrinsics& intrinsics, const Options& options);
  std::string path_;
  Intrinsics intrinsics_;
  Options options_;
  struct Row {
    std::uint64_t number = 0;
    FrameInfo info;
  };
  // A table that grows by a line a frame. A line may be taken back until keep().
  struct Table {
    int fd = -1;  // -1: closed
    std::int64_t bytes = 0;
    Status begin(const std::string& path, const std::string& text);  // with `text`, then open for more
    Status append(const std::string& path, const std::string& line);
    void keep();
    void take_back();
    void close();
  };
  Status note_times(const Row& row);
  Status rewrite_times();
  std::string line_of(const Row& row) const;
  Status note_pose(const Row& row);
  void take_back();
  std::string times_path() const { return path_ + "/timestamps.csv"; }
  std::string poses_path() const { return path_ + "/poses.csv"; }

  std::vector<Row> rows_;
  bool host_times_ = true;
  bool device_times_ = true;
  bool downs_ = false;  // timestamps.csv has columns for them
  Table times_, poses_;
  int poses_count_ = 0;  // rows of poses.csv whose frames are there
};

}  // namespace im2fit::hal
