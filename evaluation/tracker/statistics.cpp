// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace im2fit::lab {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::uint64_t count_within(const std::vector<double>& errors_mm, float limit_mm) {
  return static_cast<std::uint64_t>(
      std::count_if(errors_mm.begin(), errors_mm.end(), [&](double e) { return e <= limit_mm; }));
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNaN;
  const double rank = std::ceil(q * static_cast<double>(values.size()));
  const auto index = static_cast<std::size_t>(std::clamp(rank, 1.0, static_cast<double>(values.size()))) - 1;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return kNaN;
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : kNaN;
}

void JointTally::count(const JointFrame& frame) {
  ++frames_;
  if (frame.finding == Finding::person) ++found_;
  if (frame.finding == Finding::other) ++other_;
}

void JointTally::add(const JointFrame& frame) {
  count(frame);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!frame.in_picture[j]) continue;
    ++joints_;
    if (frame.finding == Finding::person) errors_mm_.push_back(frame.error_mm[j]);
  }
}

void JointTally::add(const JointFrame& frame, std::size_t joint) {
  if (!frame.in_picture[joint]) return;
  count(frame);
  ++joints_;
  if (frame.finding == Finding::person) errors_mm_.push_back(frame.error_mm[joint]);
}

JointSummary JointTally::summary() const {
  JointSummary s;
  s.frames = frames_;
  s.found = found_;
  s.other = other_;
  s.joints = joints_;
  s.mean_mm = mean(errors_mm_);
  s.median_mm = quantile(errors_mm_, 0.5);
  s.p95_mm = quantile(errors_mm_, 0.95);
  s.within_100mm = share(count_within(errors_mm_, kWithinMm), joints_);
  s.within_50mm = share(count_within(errors_mm_, kSureMm), joints_);
  return s;
}

void PairedMeans::add(const JointFrame& first, const JointFrame& second) {
  if (first.finding != Finding::person || second.finding != Finding::person) return;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!first.in_picture[j] || !second.in_picture[j]) continue;
    first_mm_ += first.error_mm[j];
    second_mm_ += second.error_mm[j];
  }
}

double PairedMeans::ratio() const {
  return first_mm_ > 0 ? second_mm_ / first_mm_ : kNaN;
}

void Reliability::add(const JointFrame& frame) {
  if (frame.finding != Finding::person) return;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!frame.in_picture[j]) continue;
    const double stated = std::clamp(static_cast<double>(frame.confidence[j]), 0.0, 1.0);
    Sum& sum = sums_[static_cast<std::size_t>(std::lround(stated * (kBins - 1)))];
    ++sum.joints;
    ++joints_;
    sum.stated += stated;
    if (frame.error_mm[j] <= kSureMm) ++sum.within;
  }
}

std::array<ReliabilityBin, Reliability::kBins> Reliability::bins() const {
  std::array<ReliabilityBin, kBins> out;
  for (std::size_t i = 0; i < kBins; ++i) {
    const Sum& sum = sums_[i];
    out[i] = {sum.joints, sum.joints > 0 ? sum.stated / static_cast<double>(sum.joints) : kNaN,
              share(sum.within, sum.joints)};
  }
  return out;
}

double Reliability::calibration_error() const {
  double sum = 0;
  for (const ReliabilityBin& bin : bins())
    if (bin.joints > 0) sum += static_cast<double>(bin.joints) * std::abs(bin.stated - bin.within);
  return joints_ > 0 ? sum / static_cast<double>(joints_) : kNaN;
}

}  // namespace im2fit::lab
