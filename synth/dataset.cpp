// SPDX-License-Identifier: Apache-2.0
#include "synth/dataset.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <mutex>

#include "base/file.h"
#include "body/params_vector.h"
#include "synth/dataset_shard.h"
#include "synth/strangers.h"
#include "synth/tracker_parallel.h"

namespace im2fit::synth {
namespace {

constexpr int kAttempts = 3;                  // scenes drawn for one capture before it is given up
constexpr std::uint64_t kDatasetVersion = 5;  // raise when the way to a feature changes: shards are then made again
constexpr double kReportSeconds = 0.25;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

Error invalid(const std::string& why) {
  return {ErrorCode::invalid_argument, "dataset: " + why};
}

Status check(const DatasetOptions& o) {
  if (o.subject_count < 1 || o.subject_count > 10'000'000)
    return invalid("subject_count is " + std::to_string(o.subject_count) + ", expected 1 to 10000000");
  if (o.captures_per_subject < 1 || o.captures_per_subject > 64)
    return invalid("captures_per_subject is " + std::to_string(o.captures_per_subject) + ", expected 1 to 64");
  if (o.stranger_every < 0) return invalid("stranger_every must not be negative");
  if (o.chunk_size < 1 || o.thread_count < 1) return invalid("chunk_size and thread_count must be at least 1");
  const CaptureVariety& v = o.variety;
  if (v.frames_min < kCaptureFramesMin || v.frames_max < v.frames_min || v.frames_max > 1000)
    return invalid("frames " + std::to_string(v.frames_min) + " to " + std::to_string(v.frames_max) +
                   ", expected 3 <= least <= most <= 1000");
  return Ok{};
}

// Everything a sample depends on. FNV-1a over words.
std::uint64_t key_of(const body::BodyModel& model, const DatasetOptions& o, std::uint64_t first, int count) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  const auto mix = [&](std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3ULL, hash ^= hash >> 29; };
  mix(kDatasetVersion);
  mix(o.input_key);
  mix(kFeatureSize);
  mix(static_cast<std::uint64_t>(model.vertex_count()));
  mix(model.modifier_names().size());
  mix(static_cast<std::uint64_t>(o.family));
  mix(o.seed);
  mix(first);
  mix(static_cast<std::uint64_t>(count));
  mix(static_cast<std::uint64_t>(o.captures_per_subject));
  mix(static_cast<std::uint64_t>(o.variety.frames_min));
  mix(static_cast<std::uint64_t>(o.variety.frames_max));
  mix(std::bit_cast<std::uint64_t>(o.variety.wide_share));
  mix(std::bit_cast<std::uint64_t>(o.variety.landscape_share));
  mix(o.variety.plain ? 1 : 0);
  mix(static_cast<std::uint64_t>(o.stranger_every));
  return hash;
}

struct SubjectResult {
  std::vector<index::Sample> samples;
  int failed = 0;
  int missing = 0;
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};
};

SubjectResult make_subject(const body::BodyModel& model, CaptureRig& rig, const DatasetOptions& o,
                           std::uint64_t number) {
  SubjectResult result;
  const auto start = Clock::now();
  const bool stranger = o.family == Family::training && o.stranger_every > 0 &&
                        number % static_cast<std::uint64_t>(o.stranger_every) == 5;
  const Subject subject =
      stranger ? draw_stranger(model, o.seed, number) : draw_subject(model, o.family, o.seed, number);
  rig.cost.draw += seconds_since(start);
  for (int c = 0; c < o.captures_per_subject; ++c) {
    bool done = false;
    for (int attempt = 0; attempt < kAttempts && !done; ++attempt) {
      const Capture& capture = rig.run(subject, draw_capture(o.variety, o.seed, number, c * kAttempts + attempt));
      result.frames_seen += capture.frames_seen;
      for (std::size_t g = 0; g < kGuidanceCount; ++g) result.refused[g] += capture.refused[g];
      if (!capture.valid) {
        ++result.failed;
        continue;
      }
      index::Sample& s = result.samples.emplace_back();
      s.subject = number;
      s.feature.assign(capture.feature.begin(), capture.feature.end());
      s.truth = subject.truth;
      s.woman = subject.woman;
      s.body = body::pack_params(subject.params, model.modifier_names().size());
      s.frame_count = capture.frame_count;
      s.calibrate_only = stranger;
      done = true;
    }
    if (!done) ++result.missing;
  }
  return result;
}

Chunk gather(std::vector<SubjectResult>& results) {
  Chunk chunk;
  for (SubjectResult& r : results) {
    chunk.subjects += r.samples.empty() ? 0 : 1;
    chunk.captures_failed += r.failed;
    chunk.captures_missing += r.missing;
    chunk.frames_seen += r.frames_seen;
    for (std::size_t g = 0; g < kGuidanceCount; ++g) chunk.refused[g] += r.refused[g];
    std::move(r.samples.begin(), r.samples.end(), std::back_inserter(chunk.samples));
  }
  return chunk;
}

void add(DatasetReport& report, const Chunk& chunk) {
  report.subjects += chunk.subjects;
  report.samples += static_cast<int>(chunk.samples.size());
  report.captures_failed += chunk.captures_failed;
  report.captures_missing += chunk.captures_missing;
  report.frames_seen += chunk.frames_seen;
  for (std::size_t g = 0; g < kGuidanceCount; ++g) report.refused[g] += chunk.refused[g];
}

// Counts finished subjects and tells, not too often.
class Reporter {
 public:
  Reporter(int total, const std::function<void(const DatasetProgress&)>& tell) : total_(total), tell_(tell) {}
  void reused(int count) {
    const std::lock_guard lock(mutex_);
    reused_ += count;
    say(true);
  }
  void made() {
    const std::lock_guard lock(mutex_);
    ++made_;
    say(made_ + reused_ == total_);
  }

 private:
  void say(bool now) {
    if (!tell_ || (!now && seconds_since(last_) < kReportSeconds)) return;
    last_ = Clock::now();
    DatasetProgress p{made_ + reused_, total_, 0, 0};
    const double elapsed = seconds_since(start_);
    if (made_ > 0 && elapsed > 0) {
      p.subjects_per_second = made_ / elapsed;
      p.seconds_left = (total_ - p.done) / p.subjects_per_second;
    }
    tell_(p);
  }
  std::mutex mutex_;
  int total_;
  int reused_ = 0;
  int made_ = 0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  const std::function<void(const DatasetProgress&)>& tell_;
};

}  // namespace

Result<DatasetReport> make_dataset(const body::BodyModel& model, const JointModel& joint_model,
                                   const DatasetOptions& options,
                                   const std::function<void(const DatasetProgress&)>& progress,
                                   const std::function<void(const index::Sample&)>& sink) {
  if (auto s = check(options); !s) return s.error();
  if (!options.work_dir.empty())
    if (auto s = make_directory(options.work_dir); !s) return s.error();
  const auto start = Clock::now();
  DatasetReport report;
  Reporter reporter(options.subject_count, progress);
  std::vector<std::unique_ptr<CaptureRig>> rigs;  // those not in use
  std::mutex rigs_mutex;
  const auto borrow = [&] {
    const std::lock_guard lock(rigs_mutex);
    if (rigs.empty()) return std::make_unique<CaptureRig>(model, joint_model);
    auto rig = std::move(rigs.back());
    rigs.pop_back();
    return rig;
  };
  const auto give_back = [&](std::unique_ptr<CaptureRig> rig) {
    const std::lock_guard lock(rigs_mutex);
    report.cost += rig->cost;
    rig->cost = {};
    rigs.push_back(std::move(rig));
  };

  for (int at = 0; at < options.subject_count; at += options.chunk_size) {
    const int count = std::min(options.chunk_size, options.subject_count - at);
    const std::uint64_t first = options.first_subject + static_cast<std::uint64_t>(at);
    const std::uint64_t key = key_of(model, options, first, count);
    char name[64];
    std::snprintf(name, sizeof name, "/shard-%016llx.i2d", static_cast<unsigned long long>(key));
    const std::string path = options.work_dir + name;
    Chunk chunk;
    bool found = false;
    if (!options.work_dir.empty())
      if (auto shard = read_shard(path, key)) {
        chunk = std::move(*shard);
        found = true;
        report.subjects_reused += count;
        reporter.reused(count);
      }
    if (!found) {
      std::vector<SubjectResult> results(static_cast<std::size_t>(count));
      for_each_item(count, options.thread_count, [&](int i) {
        auto rig = borrow();
        results[static_cast<std::size_t>(i)] =
            make_subject(model, *rig, options, first + static_cast<std::uint64_t>(i));
        give_back(std::move(rig));
        reporter.made();
      });
      chunk = gather(results);
      if (!options.work_dir.empty())
        if (auto s = write_shard(path, key, chunk); !s) return s.error();
    }
    add(report, chunk);
    for (const index::Sample& s : chunk.samples) sink(s);
  }
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace im2fit::synth
