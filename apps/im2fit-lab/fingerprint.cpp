// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "apps/common/paths.h"
#include "apps/im2fit-lab/commands.h"
#include "body/look.h"
#include "body/model.h"
#include "body/model_data.h"
#include "core/crc32c.h"
#include "core/file.h"
#include "core/rng.h"
#include "core/status.h"
#include "index/format.h"
#include "perception/joints/model_data.h"
#include "perception/joints/tracker.h"
#include "person/data_files.h"
#include "train/dataset/dataset.h"
#include "train/index/builder.h"
#include "train/makehuman/makehuman.h"
#include "train/population/drawn_people.h"
#include "train/population/shape_space_builder.h"
#include "train/population/start_body_picker.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::apps {
namespace {

using namespace lab;  // what commands are about

// What body data, a tracker and an index would be made of by this code: declared versions, and a checksum of a small
// trial run of the same code. Data made earlier is still good when its fingerprint is. A change of arithmetic changes
// the trial's bits; a comment, a name or a message does not.
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

// Shapes of 24 people: some two seconds.
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

// A tracker of 40 renders: some five seconds.
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

// Samples of four people as `joint_model` sees them, and an index of invented samples: some five seconds.
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

struct FingerprintCommand {
  std::string what;
  std::string body = made_body_path();
  std::string tracker = made_tracker_path();
};

Result<std::string> fingerprint_of(const FingerprintCommand& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  if (options.what == "body") return body_fingerprint(*model);
  if (options.what == "tracker") return tracker_fingerprint(*model);
  const auto tracker = Tracker::load(options.tracker);
  if (!tracker) return tracker.error();
  return index_fingerprint(*model, tracker->model());
}

// The body file without its look and start bodies: what trackers and indexes are made of.
Result<int> write_shape(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto shape = body::shape_only(*bytes, path);
  if (!shape) return shape.error();
  if (std::fwrite(shape->data(), 1, shape->size(), stdout) != shape->size())
    return Error{ErrorCode::io, "standard output cannot be written"};
  return kExitOk;
}

Result<int> run_fingerprint(const FingerprintCommand& options) {
  if (options.what == "shape") return write_shape(options.body);
  const auto text = fingerprint_of(options);
  if (!text) return text.error();
  fmt::print("{}\n", *text);
  return kExitOk;
}

}  // namespace

void add_fingerprint(cli::App& app, Command& chosen) {
  auto options = std::make_shared<FingerprintCommand>();
  auto* sub = add_command<FingerprintCommand>(app, chosen, "fingerprint",
                                              "Print the versions of the code that makes data, and the checksum of a "
                                              "small trial run, to check whether earlier data is still valid",
                                              "  im2fit-lab fingerprint tracker", options, run_fingerprint);
  sub->add_option("WHAT", options->what,
                  "body, tracker or index; shape: the bytes of the body file without data for pictures, for a digest")
      ->one_of({"body", "tracker", "index", "shape"})
      ->required();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--tracker", options->tracker, "Tracker file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
