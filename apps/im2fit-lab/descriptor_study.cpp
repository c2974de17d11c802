// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/descriptor_study.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "apps/im2fit-lab/evaluation/evaluation.h"
#include "apps/im2fit-lab/parallel.h"
#include "body/params_vector.h"
#include "hal/source.h"
#include "index/builder.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/fuse/decimate.h"
#include "kernels/normals/normals.h"
#include "synth/strangers.h"

namespace im2fit::apps {
namespace {

constexpr int kSideMaxPx = 640;
constexpr int kAttempts = 3;
constexpr std::uint64_t kStrangerEvery = 13;  // as the dataset: they only calibrate
constexpr std::uint64_t kStrangerPlace = 5;
constexpr float kNormalStepMm = 60.0F;   // as the device
constexpr float kExactNormalMm = 30.0F;  // of every pixel's window: what facts about PCL use
constexpr std::size_t kFpfhFirst = 6;    // after four lengths and two ratios
constexpr std::size_t kFpfhCount = static_cast<std::size_t>(kFpfhSize) * kJointCount;
using Descriptor = std::array<float, kFpfhCount>;

// FPFH of gathered frames at another spacing than the device's.
class Describer {
 public:
  void run(const DescriptorWay& way, const Fuser& gathered, const Intrinsics& k, const JointSet& joints,
           Descriptor& out) {
    const float z = joints[Joint::TO].z;
    const bool exact = way.spacing_mm == 0;
    const int step = exact ? 1 : std::clamp(static_cast<int>(std::lround(way.spacing_mm * k.fx / z)), 2, 16);
    const int radius = exact ? std::max(1, static_cast<int>(std::lround(kExactNormalMm * k.fx / z))) : 1;
    const Intrinsics g = grid_intrinsics(k, step);
    const auto size = static_cast<std::size_t>(g.width) * static_cast<std::size_t>(g.height);
    const auto plane = [&](std::size_t i) { return std::span(planes_).subspan(i * size, size); };
    decimate(gathered.depth_q4(), gathered.mask(), g, step, plane(0), plane(1), plane(2));
    normals(g, plane(0).data(), plane(1).data(), plane(2).data(), radius, kNormalStepMm, plane(3).data(),
            plane(4).data(), plane(5).data());
    const OrganisedCloud cloud{
        g, plane(0).data(), plane(1).data(), plane(2).data(), plane(3).data(), plane(4).data(), plane(5).data()};
    fpfh(cloud, joints.position_mm, kFpfhRadiusMm, work_, out);
  }

 private:
  FpfhWorkspace work_{kSideMaxPx, kSideMaxPx};
  std::vector<float> planes_ = std::vector<float>(static_cast<std::size_t>(kSideMaxPx) * kSideMaxPx * 6);
};

struct Row {
  bool valid = false;
  index::Sample sample;  // as the device describes it
  std::array<Descriptor, kDescriptorWays.size()> descriptors;
};

// One worker's tools, made where it runs.
struct Bench {
  Bench(const body::BodyModel& model, const JointModel& joint_model) : rig(model, joint_model) {}
  synth::CaptureRig rig;
  Describer describer;
};

bool capture(Bench& bench, const synth::Subject& subject, const synth::CaptureOptions& options, Row& row) {
  const synth::Capture& got = bench.rig.run(subject, options);
  if (!got.valid) return false;
  const Intrinsics upright = hal::rotate_upright(options.intrinsics, options.scene.rotate_deg);
  row.sample.feature.assign(got.feature.begin(), got.feature.end());
  row.sample.frame_count = got.frame_count;
  row.sample.distance_mm = got.distance_mm;
  std::copy_n(got.feature.begin() + kFpfhFirst, kFpfhCount, row.descriptors[0].begin());
  for (std::size_t w = 1; w < kDescriptorWays.size(); ++w)
    bench.describer.run(kDescriptorWays[w], *bench.rig.gathered(), upright, got.joints, row.descriptors[w]);
  row.valid = true;
  return true;
}

Row training_row(Bench& bench, const body::BodyModel& model, std::uint64_t seed, std::uint64_t number) {
  Row row;
  const bool stranger = number % kStrangerEvery == kStrangerPlace;
  const synth::Subject subject = stranger ? synth::draw_stranger(model, seed, number)
                                          : synth::draw_subject(model, synth::Family::training, seed, number);
  row.sample.subject = number;
  row.sample.truth = subject.truth;
  row.sample.woman = subject.woman;
  row.sample.body = body::pack_params(subject.params, model.modifier_names().size());
  row.sample.calibrate_only = stranger;
  for (int attempt = 0; attempt < kAttempts && !row.valid; ++attempt)
    capture(bench, subject, synth::draw_capture({}, seed, number, attempt), row);
  return row;
}

Row held_out_row(Bench& bench, const body::BodyModel& model, std::uint64_t number) {
  Row row;
  HeldOutPerson person = draw_person(model, {}, number);
  row.sample.truth = person.subject.truth;
  for (int attempt = 0; attempt < kAttempts && !row.valid; ++attempt) {
    capture(bench, person.subject, person.capture, row);
    ++person.capture.seed;
  }
  return row;
}

index::Sample described(const Row& row, std::size_t way) {
  index::Sample sample = row.sample;
  std::copy(row.descriptors[way].begin(), row.descriptors[way].end(),
            sample.feature.begin() + static_cast<std::ptrdiff_t>(kFpfhFirst));
  return sample;
}

Result<std::vector<MeasurementValues>> errors_of(std::size_t way, const std::vector<Row>& training,
                                                 const std::vector<Row>& people) {
  index::BuildOptions options;
  options.groups = synth::feature_groups();
  std::vector<index::Sample> samples;
  for (const Row& row : training)
    if (row.valid) samples.push_back(described(row, way));
  auto bytes = index::build_index(options, index::source_of(samples));
  if (!bytes) return bytes.error();
  const auto index = index::Index::parse(std::move(*bytes), kDescriptorWays[way].name);
  if (!index) return index.error();
  const auto scratch = index->make_scratch();
  std::vector<MeasurementValues> errors;
  for (const Row& row : people) {
    if (!row.valid) continue;
    const index::Sample asked = described(row, way);
    index::QueryOptions query;
    query.frame_count = asked.frame_count;
    query.distance_mm = asked.distance_mm;
    const auto answer = index->query(asked.feature, query, *scratch);
    if (!answer) return answer.error();
    MeasurementValues& error = errors.emplace_back();
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      error[m] = std::fabs(answer->measurements[m].value - asked.truth[m]);
  }
  return errors;
}

}  // namespace

Result<DescriptorStudy> study_descriptors(const body::BodyModel& model, const JointModel& joint_model,
                                          const DescriptorStudyOptions& options) {
  const auto rows = [&](const char* what, int count, auto make) {
    std::vector<Row> out(static_cast<std::size_t>(count));
    parallel_items(what, out.size(), options.threads, [&](std::uint64_t i) {
      thread_local std::unique_ptr<Bench> bench;
      if (!bench) bench = std::make_unique<Bench>(model, joint_model);
      out[i] = make(*bench, i);
    });
    return out;
  };
  const std::vector<Row> training =
      rows("training subjects", options.training_subjects,
           [&](Bench& bench, std::uint64_t i) { return training_row(bench, model, options.seed, i); });
  const std::vector<Row> people =
      rows("people", options.people, [&](Bench& bench, std::uint64_t i) { return held_out_row(bench, model, i); });
  DescriptorStudy study;
  for (const Row& row : training) study.samples += row.valid ? 1 : 0;
  for (std::size_t way = 0; way < kDescriptorWays.size(); ++way) {
    auto errors = errors_of(way, training, people);
    if (!errors) return errors.error();
    study.errors[way] = std::move(*errors);
  }
  return study;
}

}  // namespace im2fit::apps
