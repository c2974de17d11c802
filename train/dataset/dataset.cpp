// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/dataset.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <mutex>

#include "body/params_vector.h"
#include "core/file.h"
#include "index/refinement.h"
#include "train/common/parallel.h"
#include "train/common/stopwatch.h"
#include "train/dataset/dataset_shard.h"
#include "train/population/ood_subjects.h"
#include "train/population/surface_smoother.h"

namespace im2fit::lab {
namespace {

constexpr auto kArmsClose =
    static_cast<std::size_t>(std::countr_zero(static_cast<GuidanceSet>(Guidance::arms_close)));
constexpr int kAttempts = 3;                   // scenes drawn for one capture before it is given up
constexpr std::uint64_t kDatasetVersion = 22;  // raise when a sample of a subject changes: shards are then made again
constexpr std::string_view kVersionWords = "dataset version ";
constexpr int kBackCaptures = 4096;     // numbers of captures from behind begin here
constexpr int kClothedCaptures = 8192;  // of those in clothes
constexpr int kAgainCaptures = 16384;   // and of people seen again
constexpr std::uint64_t kOutfitStream = 0x0F17, kOutfitAgainStream = 0x0F18, kHairStream = 0x0F19;
constexpr double kReportSeconds = 0.25;
constexpr int kAgainFrames = 29;  // as a device, which takes 30; odd, docs/dataset.md

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

Error invalid(const std::string& why) {
  return {ErrorCode::invalid_argument, "dataset: " + why};
}

Status check(const DatasetOptions& o) {
  if (o.subject_count < 1 || o.subject_count > 1'000'000'000)
    return invalid("subject_count is " + std::to_string(o.subject_count) + ", expected 1 to 1000000000");
  if (o.captures_per_subject < 1 || o.captures_per_subject > 64)
    return invalid("captures_per_subject is " + std::to_string(o.captures_per_subject) + ", expected 1 to 64");
  if (o.ood_every < 0 || o.turn_every < 0 || o.clothed_every < 0)
    return invalid("ood_every, turn_every and clothed_every must not be negative");
  if (o.chunk_size < 1 || o.thread_count < 1) return invalid("chunk_size and thread_count must be at least 1");
  if (o.part_count < 1 || o.part < 0 || o.part >= o.part_count)
    return invalid("part " + std::to_string(o.part) + " of " + std::to_string(o.part_count) +
                   ", expected 0 <= part < count");
  const CaptureVariety& v = o.variety;
  if (v.frames_min < kCaptureFramesMin || v.frames_max < v.frames_min || v.frames_max > 1000)
    return invalid("frames " + std::to_string(v.frames_min) + " to " + std::to_string(v.frames_max) +
                   ", expected 3 <= least <= most <= 1000");
  return Ok{};
}

struct SubjectResult {
  std::vector<index::Sample> samples;
  int failed = 0;
  int missing = 0;
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};
};

struct RenderedSubject {
  Subject subject;
  std::vector<Vec3f> rest;  // mesh
};

// Names one capture of a person.
struct CaptureKey {
  int capture = 0;  // below captures_per_subject
  bool clothed = false;
  bool again = false;
};

CaptureOptions draw_capture_of(const DatasetOptions& o, std::uint64_t number, const CaptureKey& key, bool behind,
                               int attempt) {
  const int drawn = key.capture * kAttempts + attempt + (behind ? kBackCaptures : 0) +
                    (key.clothed ? kClothedCaptures : 0) + (key.again ? kAgainCaptures : 0);
  CaptureVariety variety = o.variety;
  if (key.again) variety.frames_min = variety.frames_max = kAgainFrames;
  return draw_capture(variety, o.seed, number, drawn);
}

// Hair is not a sign of clothes: half of the out-of-distribution people have some when seen bare, and a fifth of the
// dressed have none. Judgement; real people have hair more often, but training people have none.
constexpr double kBareHairShare = 0.5, kDressedBaldShare = 0.2;

void grow_hair(SceneOptions& scene, std::uint64_t seed, std::uint64_t number) {
  Rng rng = Rng::for_item(seed, kHairStream, number);
  scene.hair = rng.uniform() < kBareHairShare;
  scene.outfit_seed = rng.next() | 1U;
}

// Everyday clothes, most with shoes and hair, as they come. Most shirts that people wear untucked hang.
void dress(SceneOptions& scene, std::uint64_t seed, std::uint64_t number, bool again) {
  constexpr std::array kWorn = {Clothing::tight, Clothing::normal, Clothing::loose, Clothing::hanging};
  Rng rng = Rng::for_item(seed, again ? kOutfitAgainStream : kOutfitStream, number);
  scene.clothing = kWorn[static_cast<std::size_t>(rng.index(static_cast<int>(kWorn.size())))];
  scene.outfit_seed = rng.next() | 1U;
  scene.hair = rng.uniform() >= kDressedBaldShare;
}

// From behind, before the same camera; another room, place and noise are as good.
CaptureOptions from_behind(const CaptureOptions& front, CaptureOptions back) {
  back.intrinsics = front.intrinsics;
  back.sensor = front.sensor;
  back.scene.rotate_deg = front.scene.rotate_deg;
  back.scene.distance_mm = front.scene.distance_mm;
  back.scene.enlarge_to_fit = front.scene.enlarge_to_fit;
  back.scene.pose = front.scene.pose;
  back.scene.clothing = front.scene.clothing;
  back.scene.hair = front.scene.hair;
  back.scene.outfit_seed = front.scene.outfit_seed;
  back.scene.back_view = true;
  return back;
}

// The view from behind and the fits into the sample, unless the captures fail.
void turn_round(CaptureRig& rig, const RenderedSubject& person, const CaptureOptions& front, const DatasetOptions& o,
                std::uint64_t number, const CaptureKey& key, index::Sample& sample) {
  rig.keep_front();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Capture& back =
        rig.run(person.subject, from_behind(front, draw_capture_of(o, number, key, true, attempt)), person.rest);
    if (!back.valid) continue;
    CaptureRig::Fits fits = rig.fit_both();
    if (fits.front.empty()) return;
    sample.back.assign(back.feature.begin(), back.feature.end());
    sample.fit = std::move(fits.front);
    sample.fit_both = std::move(fits.both);
    sample.fit_layout = fits.layout;
    sample.back_frame_count = back.frame_count;
    sample.back_distance_mm = back.distance_mm;
    return;
  }
}

// Which views of a person are taken.
struct Views {
  bool ood = false;
  bool turns = false;    // the view from behind, too
  bool clothed = false;  // both once more, in clothes
  bool again = false;    // what turns or is clothed another time
};
Views views_of(const body::BodyModel& model, const DatasetOptions& o, std::uint64_t number) {
  Views views;
  views.ood = o.family == Family::training && is_ood(number, o.ood_every, o.ood_below);
  if (model.shape_space().point_count == 0 || number >= o.turn_below) return views;
  const auto nth = [&](int every, std::uint64_t which) {
    return every > 0 && (views.ood || number / 2 % static_cast<std::uint64_t>(every) == which);
  };
  views.turns = nth(o.turn_every, 0);
  views.clothed = nth(o.clothed_every, o.clothed_every == 1 ? 0 : 1);
  views.again = number < o.again_below;
  return views;
}

index::Sample sample_of(const body::BodyModel& model, const Subject& subject, std::uint64_t number,
                        const Capture& capture) {
  index::Sample s;
  s.subject = number;
  s.feature.assign(capture.feature.begin(), capture.feature.end());
  s.truth = subject.truth;
  s.woman = subject.woman;
  s.age_years = subject.params.age_years;
  s.body = body::pack_params(subject.params, model.modifier_names().size());
  s.frame_count = capture.frame_count;
  s.distance_mm = capture.distance_mm;
  return s;
}

SubjectResult make_subject(const body::BodyModel& model, const SurfaceSmoother& smoother, CaptureRig& rig,
                           const DatasetOptions& o, std::uint64_t number) {
  SubjectResult result;
  Stopwatch watch;
  const Views views = views_of(model, o, number);
  RenderedSubject person;
  person.subject = views.ood ? draw_ood_subject(model, o.seed, number, kOodTrunk, person.rest, &smoother)
                             : draw_subject(model, o.family, o.seed, number, person.rest);
  rig.cost.draw += watch.lap();
  // The front before scenes drawn until one gives enough frames.
  const auto shoot = [&](const CaptureKey& key, CaptureOptions& options) -> const Capture* {
    bool arms_close = false;  // most frames of the attempt before
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      options = draw_capture_of(o, number, key, false, attempt);
      if (key.clothed)
        dress(options.scene, o.seed, number, key.again);
      else if (views.ood)
        grow_hair(options.scene, o.seed, number);
      // Asked to, people hold their arms out.
      if (arms_close) options.scene.pose = StandingPose::arms_out;
      const Capture& taken = rig.run(person.subject, options, person.rest);
      result.frames_seen += taken.frames_seen;
      for (std::size_t g = 0; g < kGuidanceCount; ++g) result.refused[g] += taken.refused[g];
      if (taken.valid) return &taken;
      ++result.failed;
      arms_close = 2 * taken.refused[kArmsClose] > taken.frames_seen;
    }
    ++result.missing;
    return nullptr;
  };
  const auto take_capture = [&](const CaptureKey& key) {
    CaptureOptions options;
    const Capture* capture = shoot(key, options);
    if (capture == nullptr) return;
    index::Sample s = sample_of(model, person.subject, number, *capture);
    s.calibrate_only = views.ood;
    s.clothed = key.clothed;
    if (key.clothed) s.clothes_kind = static_cast<std::uint8_t>(options.scene.clothing);
    s.again = key.again;
    if (key.clothed || views.turns) turn_round(rig, person, options, o, number, key, s);
    fit_to_shard(s);  // made now or read again, it is the same
    if (s.refines() || !(s.clothed || s.again)) result.samples.push_back(std::move(s));
  };
  for (int c = 0; c < o.captures_per_subject; ++c)
    for (const bool again : {false, true}) {
      if (again && !views.again) continue;
      if (!again || views.turns) take_capture({c, false, again});
      if (views.clothed) take_capture({c, true, again});
    }
  return result;
}

Chunk sum_up(std::vector<SubjectResult>& results) {
  Chunk chunk;
  ChunkCounts& counts = chunk.counts;
  for (SubjectResult& r : results) {
    counts.subjects += r.samples.empty() ? 0 : 1;
    counts.captures_failed += r.failed;
    counts.captures_missing += r.missing;
    counts.frames_seen += r.frames_seen;
    for (std::size_t g = 0; g < kGuidanceCount; ++g) counts.refused[g] += r.refused[g];
    std::move(r.samples.begin(), r.samples.end(), std::back_inserter(chunk.samples));
  }
  counts.samples = static_cast<std::int32_t>(chunk.samples.size());
  return chunk;
}

// Counts finished subjects and reports them, not too often.
class Reporter {
 public:
  Reporter(int total, const std::function<void(const DatasetProgress&)>& listener)
      : total_(total), listener_(listener) {}
  void reused(int count) {
    const std::lock_guard lock(mutex_);
    reused_ += count;
    report(true);
  }
  void made() {
    const std::lock_guard lock(mutex_);
    ++made_;
    report(made_ + reused_ == total_);
  }

 private:
  void report(bool now) {
    if (!listener_ || (!now && seconds_since(last_) < kReportSeconds)) return;
    last_ = Clock::now();
    DatasetProgress p{made_ + reused_, total_, 0, 0};
    const double elapsed = seconds_since(start_);
    if (made_ > 0 && elapsed > 0) {
      p.subjects_per_second = made_ / elapsed;
      p.seconds_left = (total_ - p.done) / p.subjects_per_second;
    }
    listener_(p);
  }
  std::mutex mutex_;
  int total_;
  int reused_ = 0;
  int made_ = 0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  const std::function<void(const DatasetProgress&)>& listener_;
};

// The rigs of threads that are not at work.
class RigPool {
 public:
  RigPool(const body::BodyModel& model, const JointModel& joint_model)
      : model_(model), joint_model_(joint_model), smoother_(model) {}
  const SurfaceSmoother& smoother() const { return smoother_; }
  std::unique_ptr<CaptureRig> borrow() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<CaptureRig>(model_, joint_model_);
    auto rig = std::move(idle_.back());
    idle_.pop_back();
    return rig;
  }
  void give_back(std::unique_ptr<CaptureRig> rig) {
    const std::lock_guard lock(mutex_);
    cost_ += rig->cost;
    rig->cost = {};
    idle_.push_back(std::move(rig));
  }
  const CaptureCost& cost() const { return cost_; }

 private:
  const body::BodyModel& model_;
  const JointModel& joint_model_;
  const SurfaceSmoother smoother_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<CaptureRig>> idle_;
  CaptureCost cost_;
};

// Chunks of the part: file numbers that all parts share out evenly.
struct ChunkSpan {
  std::int64_t first, end;
};
ChunkSpan chunks_of_part(const DatasetOptions& o) {
  const std::int64_t chunks = (o.subject_count + std::int64_t{o.chunk_size} - 1) / o.chunk_size;
  return {chunks * o.part / o.part_count, chunks * (o.part + 1) / o.part_count};
}
SubjectRange range_of_chunk(const DatasetOptions& o, std::int64_t chunk) {
  const std::int64_t at = chunk * o.chunk_size;
  return {o.first_subject + static_cast<std::uint64_t>(at),
          static_cast<std::uint64_t>(std::min<std::int64_t>(o.chunk_size, o.subject_count - at))};
}

Chunk make_chunk(const body::BodyModel& model, const DatasetOptions& options, const SubjectRange& range,
                 RigPool& rigs, Reporter& reporter) {
  std::vector<SubjectResult> results(range.count);
  for_each_item(static_cast<int>(range.count), options.thread_count, [&](int i) {
    auto rig = rigs.borrow();
    results[static_cast<std::size_t>(i)] =
        make_subject(model, rigs.smoother(), *rig, options, range.first + static_cast<std::uint64_t>(i));
    rigs.give_back(std::move(rig));
    reporter.made();
  });
  return sum_up(results);
}

}  // namespace

void DatasetReport::add(const ChunkCounts& counts, const SubjectRange& range) {
  subjects_drawn += static_cast<int>(range.count);
  subjects += counts.subjects;
  samples += counts.samples;
  captures_failed += counts.captures_failed;
  captures_missing += counts.captures_missing;
  frames_seen += counts.frames_seen;
  for (std::size_t g = 0; g < kGuidanceCount; ++g) refused[g] += counts.refused[g];
}

bool is_ood(std::uint64_t number, int ood_every, std::uint32_t ood_below) {
  if (ood_every <= 0 || number >= ood_below) return false;
  const auto every = static_cast<std::uint64_t>(ood_every);
  return number % every == every - 1;
}

int subjects_with(int models, int ood_every, std::uint32_t ood_below) {
  int subjects = 0, found = 0;
  for (; found < models && static_cast<std::uint32_t>(subjects) < ood_below; ++subjects)
    found += is_ood(static_cast<std::uint64_t>(subjects), ood_every, ood_below) ? 0 : 1;
  return subjects + models - found;
}

std::uint64_t dataset_version() {
  return kDatasetVersion;
}

std::string dataset_version_text(std::uint64_t version) {
  return std::string(kVersionWords) + std::to_string(version);
}

std::optional<std::uint64_t> dataset_version_in(std::string_view provenance) {
  const std::size_t words = provenance.rfind(kVersionWords);
  if (words == provenance.npos) return {};
  const std::string_view number = provenance.substr(words + kVersionWords.size());
  std::uint64_t version = 0;
  if (std::from_chars(number.data(), number.data() + number.size(), version).ec != std::errc{}) return {};
  return version;
}

RunKey run_key_of(const body::BodyModel& model, const DatasetOptions& o) {
  RunKey run;
  run.dataset_version = kDatasetVersion;
  run.input_key = o.input_key;
  run.seed = o.seed;
  run.family = static_cast<std::uint32_t>(o.family);
  run.captures_per_subject = static_cast<std::uint32_t>(o.captures_per_subject);
  run.frames_min = static_cast<std::uint32_t>(o.variety.frames_min);
  run.frames_max = static_cast<std::uint32_t>(o.variety.frames_max);
  run.wide_share = o.variety.wide_share;
  run.landscape_share = o.variety.landscape_share;
  run.anywhere_share = o.variety.anywhere_share;
  run.other_sensor_share = o.variety.other_sensor_share;
  run.plain = o.variety.plain ? 1 : 0;
  run.ood_every = static_cast<std::uint32_t>(o.ood_every);
  run.ood_below = o.ood_every > 0 ? o.ood_below : 0;
  const std::size_t shapes = model.shape_space().point_count > 0 ? model.shape_space().shape_count : 0;
  run.turn_every = shapes > 0 ? static_cast<std::uint32_t>(o.turn_every) : 0;
  run.clothed_every = shapes > 0 ? static_cast<std::uint32_t>(o.clothed_every) : 0;
  run.turn_below = run.turn_every > 0 || run.clothed_every > 0 ? o.turn_below : 0;
  run.again_below = run.turn_below > 0 ? o.again_below : 0;
  run.shape_key = shapes > 0 ? model.shape_space().key : 0;
  if (shapes > 0) run.fit = body::fit_layout(model.shape_space());
  run.feature_size = static_cast<std::uint32_t>(kFeatureSize);
  run.body_size = static_cast<std::uint32_t>(body::params_vector_size(model.modifier_names().size()));
  return run;
}

namespace {

// Removes half-written files of runs that were killed. Another run may be writing beside this one: only files that
// have long not been touched are removed.
void remove_leftovers(const std::string& folder) {
  constexpr auto kAgeMin = std::chrono::hours(1);  // a shard is written in seconds
  std::error_code code;
  for (std::filesystem::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().filename().string();
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos || !is_temporary_of(name, name.substr(0, dot))) continue;
    if (!name.substr(0, dot).ends_with(".i2d")) continue;
    std::error_code gone;
    const auto written = std::filesystem::last_write_time(it->path(), gone);
    if (!gone && std::filesystem::file_time_type::clock::now() - written > kAgeMin)
      std::filesystem::remove(it->path(), gone);
  }
}

}  // namespace

Result<DatasetReport> make_dataset(const body::BodyModel& model, const JointModel& joint_model,
                                   const DatasetOptions& options,
                                   const std::function<void(const DatasetProgress&)>& progress,
                                   const std::function<void(const index::Sample&)>& sink) {
  if (auto s = check(options); !s) return s.error();
  const bool kept = !options.work_dir.empty();
  if (kept) {
    if (auto s = make_directory(options.work_dir); !s) return s.error();
    remove_leftovers(options.work_dir);
  }
  const auto start = Clock::now();
  const RunKey run = run_key_of(model, options);
  const ChunkSpan chunks = chunks_of_part(options);
  int total = 0;
  for (std::int64_t c = chunks.first; c < chunks.end; ++c)
    total += static_cast<int>(range_of_chunk(options, c).count);
  DatasetReport report;
  Reporter reporter(total, progress);
  RigPool rigs(model, joint_model);
  for (std::int64_t c = chunks.first; c < chunks.end; ++c) {
    const SubjectRange range = range_of_chunk(options, c);
    const std::string path = options.work_dir + "/" + shard_name(run, range);
    Result<Chunk> chunk = kept ? read_shard(path, run, range) : Error{};
    if (chunk) {
      report.subjects_reused += static_cast<int>(range.count);
      reporter.reused(static_cast<int>(range.count));
    } else {
      chunk = make_chunk(model, options, range, rigs, reporter);
      if (kept)
        if (auto s = write_shard(path, run, range, *chunk); !s) return s.error();
    }
    report.add(chunk->counts, range);
    for (const index::Sample& s : chunk->samples) sink(s);
  }
  report.cost = rigs.cost();
  report.shape_key = run.shape_key;
  report.input_key = run.input_key;
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace im2fit::lab
