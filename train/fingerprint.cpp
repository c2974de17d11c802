// SPDX-License-Identifier: Apache-2.0
#include "train/fingerprint.h"

#include <cstdio>
#include <span>
#include <vector>

#include "body/model_data.h"
#include "core/crc32c.h"
#include "core/rng.h"
#include "index/format.h"
#include "perception/joints/model_data.h"
#include "train/dataset/dataset.h"
#include "train/index/builder.h"
#include "train/makehuman/makehuman.h"
#include "train/population/drawn_people.h"
#include "train/population/shape_space_builder.h"
#include "train/population/start_body_picker.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {
namespace {

class Checksum {
 public:
  template <class T>
  void add(std::span<const T> values) {
    sum_ = crc32c(std::as_bytes(values), sum_);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::span<const T>(values));
  }
  std::string hex() const {
    char text[16];
    std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(sum_));
    return text;
  }

 private:
  std::uint32_t sum_ = 0;
};

void add_sample(Checksum& sum, const index::Sample& sample) {
  sum.add(sample.feature);
  sum.add(std::span<const float>(sample.truth));
  sum.add(sample.body);
  sum.add(sample.fit);
  sum.add(sample.back);
  sum.add(sample.fit_both);
}

// Samples no person is behind: eight hidden numbers make measurements and, with noise, features.
std::vector<index::Sample> invented_samples() {
  constexpr std::uint64_t kSubjects = 400;
  constexpr std::size_t kHidden = 8, kFeatures = 40;
  std::vector<index::Sample> samples;
  for (std::uint64_t s = 0; s < kSubjects; ++s) {
    Rng rng = Rng::for_item(1, 2, s);
    index::Sample sample;
    sample.subject = s;
    for (std::size_t i = 0; i < kHidden; ++i) sample.body.push_back(static_cast<float>(rng.normal(0, 1)));
    for (std::size_t i = 0; i < kFeatures; ++i)
      sample.feature.push_back(100.0F + sample.body[i % kHidden] * static_cast<float>(1 + i / kHidden) +
                               static_cast<float>(rng.normal(0, 0.5)));
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      sample.truth[m] = 1000.0F + 30.0F * sample.body[m % kHidden] + 10.0F * sample.body[(m + 3) % kHidden];
    sample.woman = sample.body[0] > 0;
    sample.calibrate_only = s % 3 == 2;
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace

Result<std::string> body_fingerprint(const body::BodyModel& model) {
  ShapeSpaceOptions options;
  options.people = 24;
  options.points = 200;
  options.shapes = 8;
  const body::ShapeSpace space = build_shape_space(model, options);
  Checksum sum;
  for (const auto* values : {&space.point_mean, &space.point_basis, &space.bone_mean, &space.bone_basis})
    sum.add(*values);
  StartBodyOptions few;
  few.people = 24;
  few.starts = 6;
  const PickedStartBodies starts = pick_start_bodies(model, few);
  for (const auto& sex : {starts.men, starts.women})
    for (const body::StartBody& start : sex) sum.add(std::span<const float>(start.measured));
  return "body " + std::to_string(body::kBodyVersion) + " look " + std::to_string(body::kLookVersion) +
         " population " + std::to_string(body::kPopulationVersion) + " trial " + sum.hex();
}

Result<std::string> tracker_fingerprint(const body::BodyModel& model) {
  TrainOptions options;
  options.image_count = 40;
  options.tree_depth_max = 6;
  options.level_count = 2;
  options.level_tree_count = 8;
  options.pixel_count = 64;
  const auto bytes = train_tracker(model, options);
  if (!bytes) return bytes.error();
  Checksum sum;
  sum.add(*bytes);
  return "tracker " + std::to_string(joints::kTrackerVersion) + " trial " + sum.hex();
}

Result<std::string> index_fingerprint(const body::BodyModel& model, const JointModel& joint_model) {
  Checksum sum;
  DatasetOptions options;
  options.subject_count = 4;
  const auto report = make_dataset(
      model, joint_model, options, [](const DatasetProgress&) {},
      [&](const index::Sample& sample) { add_sample(sum, sample); });
  if (!report) return report.error();
  const std::vector<index::Sample> samples = invented_samples();
  const auto bytes = index::build_index({}, index::source_of(samples));
  if (!bytes) return bytes.error();
  sum.add(*bytes);
  return "index " + std::to_string(index::kVersion) + " dataset " +
         std::to_string(run_key_of(model, options).dataset_version) + " trial " + sum.hex();
}

}  // namespace im2fit::lab
