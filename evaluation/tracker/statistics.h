// SPDX-License-Identifier: Apache-2.0
// Statistics of the tracker, the same in every table: errors of joints, overlaps of masks, and whether a stated
// chance is the share that comes true.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/joints.h"

namespace im2fit::lab {

inline constexpr float kWithinMm = 100;  // "within 10 cm", as papers on joints count
inline constexpr float kSureMm = 50;     // the promise of a joint's confidence (core/joints.h)

// Nearest rank: the smallest value that a share `q` (0..1) of the values does not exceed; the smallest of all for 0.
// NaN for no values.
double quantile(std::vector<double> values, double q);
double mean(const std::vector<double>& values);  // NaN for no values
// Part of a whole, 0..1; NaN for none.
double share(std::uint64_t part, std::uint64_t whole);

enum class Finding : std::uint8_t {
  person,  // the mask is the person's: more of it on the person than beside
  none,
  other,  // the mask is another person's or a thing's
};

// One frame's joints against the truth.
struct JointFrame {
  Finding finding = Finding::none;
  std::array<float, kJointCount> error_mm{};    // meaningful when the person was found
  std::array<float, kJointCount> confidence{};  // meaningful when the person was found
  std::array<bool, kJointCount> in_picture{};   // the true joint; the others are not counted
};

struct JointSummary {
  std::uint64_t frames = 0;
  std::uint64_t found = 0;   // frames with the person found
  std::uint64_t other = 0;   // frames that took something else
  std::uint64_t joints = 0;  // in the picture, of all frames
  double mean_mm = 0;        // of found people
  double median_mm = 0, p95_mm = 0;
  double within_100mm = 0;  // 0..1, of all frames: a person not found is not within
  double within_50mm = 0;
};

// Accumulates frames, or one joint of them.
class JointTally {
 public:
  void add(const JointFrame& frame);
  void add(const JointFrame& frame, std::size_t joint);
  JointSummary summary() const;

 private:
  void count(const JointFrame& frame);
  std::uint64_t frames_ = 0, found_ = 0, other_ = 0, joints_ = 0;
  std::vector<double> errors_mm_;
};

// Mean error of the joints both frames of a pair have, found in both: the same scene at two resolutions.
class PairedMeans {
 public:
  void add(const JointFrame& first, const JointFrame& second);
  double ratio() const;  // second to first; NaN for none

 private:
  double first_mm_ = 0, second_mm_ = 0;
};

// Stated chance against the share that came true, in bins about 0, 10 % ... 100 %.
struct ReliabilityBin {
  std::uint64_t joints = 0;
  double stated = 0;  // mean of the stated chances, 0..1
  double within = 0;  // share within kSureMm
};
class Reliability {
 public:
  static constexpr std::size_t kBins = 11;
  void add(const JointFrame& frame);
  std::array<ReliabilityBin, kBins> bins() const;
  // Mean distance of stated and within, weighted by joints; NaN for none.
  double calibration_error() const;
  std::uint64_t joints() const { return joints_; }

 private:
  struct Sum {
    std::uint64_t joints = 0, within = 0;
    double stated = 0;
  };
  std::array<Sum, kBins> sums_{};
  std::uint64_t joints_ = 0;
};

}  // namespace im2fit::lab
