// SPDX-License-Identifier: Apache-2.0
// Depth folders in and out (docs/formats.md): NNNNNN.png or .pgm in mm, camera.yaml, optional timestamps.csv.
//
// timestamps.csv: a header naming its columns, then a row a frame. Columns: frame (the file's number) and host_ns,
// device_us or both; times must grow from row to row. Without it frames are taken to be 1/30 s apart. A camera that
// measures gravity also has down_x, down_y and down_z (FrameInfo::down), empty where it was not read. They refer to
// upright pictures and are ignored in a folder with a rotation.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/folder/depth_file.h"
#include "hal/frame_path.h"

namespace im2fit::hal {

struct FolderOptions {
  std::optional<int> rotate_deg;  // overrides camera.yaml's im2fit_rotate_deg; 0 when neither says
  std::string camera_yaml_path;   // "" for camera.yaml in the folder
  double unit_mm = 1;             // a unit of the pixels; values are rounded, above 65535 mm they are missing
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

 private:
  struct Frame {
    std::string path;
    FrameInfo info;
  };
  FolderSource() = default;
  Status scan(const std::string& path);
  Status check_first_frame(const Intrinsics& camera) const;
  std::optional<Error> foreign(const Frame& frame);  // whose file is in file_bytes_
  Status read_timestamps(const std::string& path);

  SourceInfo info_;
  UprightPath path_;
  std::vector<Frame> frames_;
  std::size_t index_ = 0;
  double unit_mm_ = 1;
  std::vector<std::byte> file_bytes_;
  DepthDecoder decoder_;
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
  // afterwards, the folder is a recording up to the last frame written: a frame appears whole, after its row of
  // timestamps.csv.
  static Result<std::unique_ptr<FolderWriter>> create(const std::string& path, const Intrinsics& intrinsics,
                                                      const Options& options);
  ~FolderWriter();  // finishes; call finish() to learn of errors
  FolderWriter(const FolderWriter&) = delete;
  FolderWriter& operator=(const FolderWriter&) = delete;

  // Files are numbered by info.sequence from 0, so that gaps stay visible. A frame that fails leaves no file behind.
  // Times that do not grow are dropped: the device_us column, or the whole timestamps.csv.
  Status write(DepthView frame, const FrameInfo& info);
  Status finish();  // timestamps.csv to the disk
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
  Status note_times(const Row& row);
  Status rewrite_times();
  std::string line_of(const Row& row) const;
  Status append(const std::string& line);
  void take_back_times();

  std::vector<Row> rows_;
  bool host_times_ = true;
  bool device_times_ = true;
  bool downs_ = false;  // timestamps.csv has columns for them
  int times_fd_ = -1;
  std::int64_t times_bytes_ = 0;  // of timestamps.csv, with the rows of rows_
};

}  // namespace im2fit::hal
