// SPDX-License-Identifier: Apache-2.0
// Matroska (RFC 9559, in EBML of RFC 8794) as far as a recording of depth needs it: tracks, tags, attachments, and
// the blocks of one track in order. Nothing is decompressed, and cues are not used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "hal/recording/file_cursor.h"

namespace im2fit::hal {

struct MatroskaTrack {
  std::uint64_t number = 0, uid = 0, type = 0;  // type 1: video
  std::string name, codec;
  std::uint64_t width = 0, height = 0;
  std::string codec_private, colour_space;
  bool encoded = false;  // compressed or encrypted block by block
};

struct MatroskaTag {
  std::string name, value;
  std::uint64_t track_uid = 0, attachment_uid = 0;  // 0: of the whole file
};

struct MatroskaAttachment {
  std::string name;
  std::uint64_t uid = 0;
  std::uint64_t at = 0, size = 0;  // of its bytes in the file
};

struct MatroskaHead {
  std::uint64_t timestamp_scale_ns = 1'000'000;
  std::vector<MatroskaTrack> tracks;
  std::vector<MatroskaTag> tags;
  std::vector<MatroskaAttachment> attachments;
  std::uint64_t first_cluster_at = 0;
  bool whole = true;  // false: the file ends within an element
};

// All of the file but its blocks is looked at, so that what stands behind them is found. A file that was cut off
// gives what it has. Errors: corrupt (no Matroska; an element too large for its kind), unsupported (more of them than
// a recording has), io.
Result<MatroskaHead> read_matroska_head(FileCursor& file);
// At most kTextBytesMax. Errors: corrupt, unsupported, io.
Result<std::string> read_matroska_attachment(FileCursor& file, const MatroskaAttachment& attachment);

struct MatroskaBlock {
  std::int64_t time = 0;   // in units of timestamp_scale_ns
  std::uint64_t size = 0;  // of its bytes, which come next in the file
  bool laced = false;      // several frames: a byte with their number less one, their sizes in some form, their bytes
};

class MatroskaBlocks {
 public:
  MatroskaBlocks(FileCursor& file, std::uint64_t track) : file_(file), track_(track) {}
  // To the first block from `at` on, which lies before a cluster.
  void restart(std::uint64_t at);
  // None: there are no more. Errors: corrupt, io; nothing follows them.
  Result<std::optional<MatroskaBlock>> next();

 private:
  Result<std::optional<MatroskaBlock>> block(std::uint64_t end);

  FileCursor& file_;
  std::uint64_t track_;
  std::uint64_t next_at_ = 0;  // behind the block delivered last
  std::uint64_t cluster_time_ = 0;
};

}  // namespace im2fit::hal
