// SPDX-License-Identifier: Apache-2.0
// Depth frames of any source into a .oni file that OpenNI2's own player gives back bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/openni2/oni_codec.h"
#include "hal/openni2/oni_records.h"
#include "hal/source.h"

namespace im2fit::hal {

// Where the calibration of a recording lies: FILE.oni.yaml.
std::string oni_sidecar_path(const std::string& oni_path);
// Of the whole file, as stored in that calibration.
Result<std::uint32_t> oni_crc32c(const std::string& oni_path);

// The file is FILE.oni.part, with its calibration in FILE.oni.part.yaml, until finish() has completed it. If the
// program ends before, the file plays up to its last frame when renamed to FILE.oni.
class OniWriter {
 public:
  struct Options {
    std::string camera_name = "depth camera";
    IntrinsicsOrigin origin = IntrinsicsOrigin::calibration_file;
  };
  // Errors: invalid_argument (FILE.oni.part is there: a recording that was never closed, or one that is being made),
  // unsupported (larger pictures than OpenNI2 plays, 2,880,000 pixels), io. A FILE.oni that is there is replaced by
  // finish().
  static Result<std::unique_ptr<OniWriter>> create(const std::string& path, const Intrinsics& intrinsics,
                                                   const Options& options);
  ~OniWriter();  // finishes; call finish() to learn of errors
  OniWriter(const OniWriter&) = delete;
  OniWriter& operator=(const OniWriter&) = delete;

  // Frames are numbered by info.sequence from 1, so that gaps stay visible. Their time is device_us, or host_ns where
  // the first frame has none; a time that does not grow is taken to be 1/30 s after the one before. A frame that
  // fails leaves nothing behind. Errors: io, unsupported (more than 32768 different depths in a picture).
  Status write(DepthView frame, const FrameInfo& info);
  // Completes the file and gives it its name. On a full disk the last frames make room for that, which is reported as
  // an error too. Another error leaves the .part. Without a frame no file is left, and an error reports that.
  Status finish();
  std::uint64_t frame_count() const { return frames_.size(); }
  // Where the frames are now: under the name given to create() once the file is whole.
  const std::string& kept_path() const { return whole_ ? path_ : part_; }

 private:
  OniWriter(const std::string& path, const Intrinsics& intrinsics, const Options& options);
  Status open();
  oni::FrameEntry entry(const FrameInfo& info) const;
  int write_at(std::span<const std::byte> bytes, std::uint64_t at);
  Status close_file();
  Status write_tail();
  Status write_checksum();
  Status put_in_place();
  void remove();
  Error failed(const std::string& what, const std::string& path, int code) const;

  std::string path_;
  std::string part_;
  Intrinsics intrinsics_;
  Options options_;
  oni::Head head_;
  OniEncoder encoder_;
  oni::Bytes record_;
  std::vector<oni::FrameEntry> frames_;
  std::uint64_t last_sequence_ = 0;
  bool device_clock_ = false;
  int fd_ = -1;
  std::uint64_t size_ = 0;         // up to the end of the last whole frame
  std::uint64_t checksum_at_ = 0;  // in the calibration's file
  bool whole_ = false;
};

}  // namespace im2fit::hal
