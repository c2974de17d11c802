// SPDX-License-Identifier: Apache-2.0
// The least that can be called a complete sample: a person's mesh and its truth, one frame from the front and one
// from behind at 320x240, each segmented and with joints, and the feature of each. The dataset's own samples are more
// (docs/dataset.md): 3 to 9 frames a view, of the first people fits and a second outfit.
//
//     one_frame_samples [people 1000] [threads 2]     body and tracker: IM2FIT_BODY, IM2FIT_TRACKER, else the cache's
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <vector>

#include "apps/common/data_files.h"
#include "apps/common/memory.h"
#include "apps/common/paths.h"
#include "hal/source.h"
#include "synth/features.h"
#include "synth/stopwatch.h"
#include "synth/tracker_parallel.h"

namespace im2fit {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::uint64_t kFirst = 20000;  // ordinary people, as in the dataset: none of them is a stranger
constexpr int kFromBehind = 4096;        // number of the capture that noise and room of the back are drawn from

struct Cost {
  double body = 0, render = 0, sense = 0, describe = 0;  // processor seconds
  int complete = 0;                                      // both views described
};

// Everything one thread needs; nothing is shared but the models.
class Maker {
 public:
  Maker(const body::BodyModel& model, const JointModel& tracker) : model_(model), tracker_(tracker) {}

  void make(std::uint64_t number) {
    synth::Stopwatch watch;
    const synth::Subject subject = synth::draw_subject(model_, synth::Family::training, kSeed, number, rest_);
    cost.body += watch.lap();
    const synth::CaptureOptions front = synth::draw_capture({.wide_share = 0}, kSeed, number, 0);
    synth::CaptureOptions back = synth::draw_capture({.wide_share = 0}, kSeed, number, kFromBehind);
    back.scene.rotate_deg = front.scene.rotate_deg;
    back.scene.pose = front.scene.pose;
    back.scene.back_view = true;
    const bool both = see(subject, front) && see(subject, back);
    cost.complete += both ? 1 : 0;
  }

  Cost cost;

 private:
  struct Station {
    Station(const Intrinsics& k, const JointModel& tracker)
        : sensor(k.width, k.height, tracker),
          fuser(k.width, k.height),
          depth(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)),
          mask(depth.size()) {}
    Sensor sensor;
    Fuser fuser;
    std::vector<std::uint16_t> depth;
    std::vector<std::uint8_t> mask;
  };

  bool see(const synth::Subject& subject, const synth::CaptureOptions& options) {
    synth::Stopwatch watch;
    const Intrinsics& k = options.intrinsics;
    const Intrinsics upright = hal::rotate_upright(k, options.scene.rotate_deg);
    std::unique_ptr<Station>& station = stations_[upright.width > upright.height ? 0 : 1];
    if (!station) station = std::make_unique<Station>(upright, tracker_);
    if (scene_)
      scene_->restage(subject, options.scene, options.sensor, options.seed, rest_);
    else
      scene_ = std::make_unique<synth::VirtualScene>(model_, subject, options.scene, options.sensor, k, options.seed);
    delivered_.resize(station->depth.size());
    const DepthImage delivered(delivered_.data(), k.width, k.height);
    const DepthImage depth(station->depth.data(), upright.width, upright.height);
    const MaskImage mask(station->mask.data(), upright.width, upright.height);
    scene_->render(0, delivered);
    hal::rotate_upright(delivered, options.scene.rotate_deg, depth);
    cost.render += watch.lap();
    station->sensor.reset();
    station->fuser.reset();
    const Sighting sighting = station->sensor.sense(depth, upright, mask);
    cost.sense += watch.lap();
    const bool described = sighting.guidance == 0 && station->fuser.add(depth, mask, upright, sighting) == 0 &&
                           station->fuser.describe().valid;
    cost.describe += watch.lap();
    return described;
  }

  const body::BodyModel& model_;
  const JointModel& tracker_;
  std::vector<Vec3f> rest_;  // the person's mesh
  std::unique_ptr<synth::VirtualScene> scene_;
  std::array<std::unique_ptr<Station>, 2> stations_;  // landscape, portrait
  std::vector<std::uint16_t> delivered_;
};

int run(int people, int threads) {
  const auto body = apps::load_body(apps::default_body_path());
  const auto tracker = apps::Tracker::load(apps::default_tracker_path());
  if (!body || !tracker) {
    fmt::print(stderr, "one_frame_samples: {}\n", (!body ? body.error() : tracker.error()).message);
    return 1;
  }
  apps::keep_freed_memory();  // as im2fit-lab dataset
  std::vector<Maker> makers;
  for (int t = 0; t < threads; ++t) makers.emplace_back(*body, tracker->model());
  const auto start = std::chrono::steady_clock::now();
  synth::for_each_item(threads, threads, [&](int t) {
    for (int i = t; i < people; i += threads)
      makers[static_cast<std::size_t>(t)].make(kFirst + static_cast<std::uint64_t>(i));
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Cost sum;
  for (const Maker& maker : makers) {
    const Cost& c = maker.cost;
    sum.body += c.body;
    sum.render += c.render;
    sum.sense += c.sense;
    sum.describe += c.describe;
    sum.complete += c.complete;
  }
  const double each_ms = 1000.0 / std::max(1, sum.complete);
  const double processor_s = sum.body + sum.render + sum.sense + sum.describe;
  fmt::print(
      "{} complete samples of {} people in {:.1f} s: {:.0f} a second by the clock, {:.0f} by processor time of {} "
      "threads\n",
      sum.complete, people, seconds, sum.complete / seconds, threads * sum.complete / processor_s, threads);
  fmt::print(
      "processor ms a sample: {:.2f} = body {:.2f}, two scenes and frames {:.2f}, segmentation and joints {:.2f}, "
      "features {:.2f}\n",
      each_ms * processor_s, each_ms * sum.body, each_ms * sum.render, each_ms * sum.sense, each_ms * sum.describe);
  return sum.complete > 0 ? 0 : 1;
}

}  // namespace
}  // namespace im2fit

int main(int argc, char** argv) {
  const int people = argc > 1 ? std::atoi(argv[1]) : 1000;
  const int threads = argc > 2 ? std::atoi(argv[2]) : 2;
  if (people < 1 || threads < 1) {
    fmt::print(stderr, "one_frame_samples [people 1000] [threads 2]\n");
    return 2;
  }
  return im2fit::run(people, threads);
}
