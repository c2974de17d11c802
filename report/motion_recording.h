// SPDX-License-Identifier: Apache-2.0
// The joints over time, kept while an engine works and written as .csv, .bvh or .glb; docs/motion.md describes the
// files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "body/export/motion.h"
#include "engine/engine.h"

namespace im2fit {

class MotionRecording {
 public:
  // "" when `path` ends in .csv, .bvh or .glb, else what is wrong with it.
  static std::string fault_of(const std::string& path);

  // A FrameWatch: keeps the joints of the followed person of every frame processed, up to an hour at 30 Hz. Later
  // frames are only counted. Allocates.
  void see(const FrameSeen& frame);
  std::size_t frame_count() const { return frames_.size(); }
  std::size_t left_out() const { return left_out_; }

  // Joints of the person in .bvh and .glb that were inferred in most of that person's frames: their motion in the
  // file is invented. For example the legs or the head of a person seen in half.
  JointFlags hardly_seen() const;

  // Format by the ending of `path`. `avatar`: the moving body of .bvh and .glb; .csv needs none. Errors: the file
  // cannot be written; no person was followed (.bvh and .glb need a pose); as the writers of body/export/motion.h.
  Status write(const std::string& path, const body::Avatar& avatar) const;

 private:
  struct Frame {
    std::uint64_t sequence = 0;
    double time_s = 0;  // since the first frame seen
    int user = 0;       // 0: no person
    ViewSide view = ViewSide::unknown;
    JointSet joints;
    JointFlags inferred = 0;
    FloorPlane floor;
  };
  std::string csv() const;
  int main_user() const;
  Result<std::vector<body::PoseKey>> keys(const body::Avatar& avatar) const;

  std::vector<Frame> frames_;
  std::int64_t first_ns_ = 0;
  std::uint64_t seen_ = 0;
  std::size_t left_out_ = 0;
};

}  // namespace im2fit
