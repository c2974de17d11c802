// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "core/joints.h"
#include "core/rng.h"
#include "train/common/parallel.h"
#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

using joints::JumpNode;

constexpr std::uint64_t kTreeStream = 0x74524545;
constexpr int kCandidateCount = 48;
constexpr int kThresholdCount = 5;
constexpr int kLeafSamplesMin = 8;
constexpr double kProbeSpreadMm = 350;
constexpr int kNodeCountMax = 65000;

struct Sample {
  std::int32_t image = 0;
  Vec3f from;
  Vec3f jump;
};

struct Task {
  int first = 0;
  int last = 0;
  int depth = 0;
  int node = 0;
};

struct Sums {
  double n = 0, x = 0, y = 0, z = 0;
  void add(Vec3f v) {
    n += 1;
    x += static_cast<double>(v.x);
    y += static_cast<double>(v.y);
    z += static_cast<double>(v.z);
  }
};

// A jump's x, y, z in steps of 2^-30 mm, and 1 to count: sums of 2^11 such jumps are exact, whatever their order.
using Jump = std::array<double, 4>;
constexpr double kJumpSteps = 1 << 30;
Jump to_jump(Vec3f v) {
  const auto rounded = [](float mm) { return std::nearbyint(static_cast<double>(mm) * kJumpSteps) / kJumpSteps; };
  return {rounded(v.x), rounded(v.y), rounded(v.z), 1};
}
double gain_of(const Jump& sum) {
  return (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / sum[3];
}

using Thresholds = std::array<int, kThresholdCount>;
// How many of the thresholds each value is above.
IM2FIT_SIMD_CLONES void count_below(std::span<const int> values, const Thresholds& thresholds, std::uint8_t* counts) {
  for (const int v : values) {
    int count = 0;
    for (const int t : thresholds) count += v > t ? 1 : 0;
    *counts++ = static_cast<std::uint8_t>(count);
  }
}

std::int16_t to_int16(double v) {
  return static_cast<std::int16_t>(std::lround(std::clamp(v, -32000.0, 32000.0)));
}

struct Candidate {
  JumpNode node;
  std::array<std::size_t, kThresholdCount> like{};  // thresholds are the values of these samples
};
using Candidates = std::array<Candidate, kCandidateCount>;

// Where jump_feature() of every candidate looks from a point: the first places, then the second.
constexpr std::size_t kPlaceCount = 2 * kCandidateCount;
struct PlaceOffsets {
  std::array<float, kPlaceCount> x{}, y{};  // mm
  explicit PlaceOffsets(const Candidates& candidates) {
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const JumpNode& n = candidates[c].node;
      x[c] = n.a;
      y[c] = n.b;
      x[c + kCandidateCount] = n.c;
      y[c + kCandidateCount] = n.d;
    }
  }
};
// As View::pixel_at_ray(), as places in the view's depth; -1: beside the picture.
IM2FIT_SIMD_CLONES void find_places(const joints::View& __restrict view, float x, float y, float inverse_z,
                                    const PlaceOffsets& __restrict offsets, std::int32_t* __restrict places) {
  const auto width = static_cast<std::uint32_t>(view.width), height = static_cast<std::uint32_t>(view.height);
  for (std::size_t i = 0; i < kPlaceCount; ++i) {
    const auto u = static_cast<std::uint32_t>(view.column_of((x + offsets.x[i]) * inverse_z));
    const auto v = static_cast<std::uint32_t>(view.row_of((y + offsets.y[i]) * inverse_z));
    const bool inside = (u < width) & (v < height);
    places[i] = inside ? static_cast<std::int32_t>(v * width + u) : -1;
  }
}

// What jump_feature() of every candidate reads, on its way from memory.
class Probes {
 public:
  Probes() = default;
  Probes(const joints::View& view, Vec3f p, const PlaceOffsets& offsets)
      : z_(joints::safe_depth(p.z)), depth_(view.depth.data()) {
    find_places(view, p.x, p.y, 1.0F / z_, offsets, places_.data());
    for (const std::int32_t place : places_) __builtin_prefetch(depth_ + std::max(place, 0));
  }
  int feature(std::size_t candidate) const {
    return probe(places_[candidate]) - probe(places_[candidate + kCandidateCount]);
  }

 private:
  int probe(std::int32_t place) const { return joints::probe_of(place >= 0 ? depth_[place] : 0, z_); }
  float z_ = 1;
  const std::uint16_t* depth_ = nullptr;
  std::array<std::int32_t, kPlaceCount> places_{};
};

class TreeTrainer {
 public:
  TreeTrainer(std::span<const TrackerImage> images, std::vector<Sample>& samples, int depth_max, Rng rng)
      : images_(images), samples_(samples), depth_max_(depth_max), rng_(rng) {}

  std::vector<JumpNode> run() {
    nodes_.emplace_back();
    tasks_.push_back({0, static_cast<int>(samples_.size()), 0, 0});
    while (!tasks_.empty()) {
      const Task task = tasks_.back();
      tasks_.pop_back();
      if (!split(task)) make_leaf(task);
    }
    return std::move(nodes_);
  }

 private:
  const joints::View& view_of(const Sample& s) const { return images_[static_cast<std::size_t>(s.image)].view; }
  int feature(const Sample& s, const JumpNode& n) const { return joints::jump_feature(view_of(s), s.from, n); }

  JumpNode draw_candidate() {
    JumpNode n;
    const double spread = kProbeSpreadMm * (rng_.uniform() < 0.5 ? 1.0 : 0.35);
    n.a = to_int16(rng_.normal(0, spread));
    n.b = to_int16(rng_.normal(0, spread));
    if (rng_.uniform() < 0.5) {
      n.c = to_int16(rng_.normal(0, spread));
      n.d = to_int16(rng_.normal(0, spread));
    }
    return n;
  }

  // Best of the drawn probes and thresholds on a subsample: greatest drop of the jumps' variance.
  bool best_split(const Task& task, JumpNode& best) {
    const int count = task.last - task.first;
    const int examined = std::min(count, task.depth < 6 ? 2400 : 1200);
    chosen_.resize(static_cast<std::size_t>(examined));
    for (int i = 0; i < examined; ++i)
      chosen_[static_cast<std::size_t>(i)] =
          samples_[static_cast<std::size_t>(task.first + (examined == count ? i : rng_.index(count)))];
    Candidates candidates;
    for (Candidate& c : candidates) {
      c.node = draw_candidate();
      for (std::size_t& i : c.like) i = static_cast<std::size_t>(rng_.index(examined));
    }
    for (auto& values : values_) values.resize(chosen_.size());
    jumps_.resize(chosen_.size());
    std::transform(chosen_.begin(), chosen_.end(), jumps_.begin(), [](const Sample& s) { return to_jump(s.jump); });
    above_.resize(chosen_.size());
    // Nearly every probe comes from memory, for pictures are many: those of a sample are prefetched at once, before
    // those of the sample before it are read.
    std::array<Probes, 2> probes;
    const PlaceOffsets offsets(candidates);
    probes[0] = Probes(view_of(chosen_[0]), chosen_[0].from, offsets);
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      if (i + 1 < chosen_.size()) probes[(i + 1) % 2] = Probes(view_of(chosen_[i + 1]), chosen_[i + 1].from, offsets);
      for (std::size_t c = 0; c < candidates.size(); ++c) values_[c][i] = probes[i % 2].feature(c);
    }

    const double least = static_cast<double>(kLeafSamplesMin) * examined / count + 3;
    double best_gain = -1;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      Thresholds thresholds;
      for (std::size_t t = 0; t < thresholds.size(); ++t) thresholds[t] = values_[c][candidates[c].like[t]];
      Thresholds rising = thresholds;
      std::sort(rising.begin(), rising.end());
      count_below(values_[c], rising, above_.data());
      std::array<Jump, kThresholdCount + 1> sums{};  // by how many thresholds a value is above
      for (std::size_t i = 0; i < jumps_.size(); ++i)
        for (std::size_t k = 0; k < jumps_[i].size(); ++k) sums[above_[i]][k] += jumps_[i][k];
      for (std::size_t t = 0; t < thresholds.size(); ++t) {
        const auto place = std::find(rising.begin(), rising.end(), thresholds[t]) - rising.begin();
        Jump low{}, high{};  // of values up to it, and above
        for (std::size_t part = 0; part < sums.size(); ++part) {
          Jump& sum = static_cast<std::ptrdiff_t>(part) <= place ? low : high;
          for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += sums[part][k];
        }
        if (low[3] < least || high[3] < least) continue;
        const double gain = gain_of(low) + gain_of(high);
        if (gain <= best_gain) continue;
        best_gain = gain;
        best = candidates[c].node;
        best.threshold = static_cast<std::int16_t>(thresholds[t]);
      }
    }
    return best_gain >= 0;
  }

  bool split(const Task& task) {
    const int count = task.last - task.first;
    if (task.depth >= depth_max_ || count < 2 * kLeafSamplesMin || nodes_.size() + 2 > kNodeCountMax) return false;
    JumpNode best;
    if (!best_split(task, best)) return false;
    const auto middle = std::stable_partition(samples_.begin() + task.first, samples_.begin() + task.last,
                                              [&](const Sample& s) { return feature(s, best) <= best.threshold; });
    const int cut = static_cast<int>(middle - samples_.begin());
    if (cut == task.first || cut == task.last) return false;
    best.left = static_cast<std::uint16_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[static_cast<std::size_t>(task.node)] = best;
    tasks_.push_back({task.first, cut, task.depth + 1, best.left});
    tasks_.push_back({cut, task.last, task.depth + 1, best.left + 1});
    return true;
  }

  void make_leaf(const Task& task) {
    Sums sums;
    for (int i = task.first; i < task.last; ++i) sums.add(samples_[static_cast<std::size_t>(i)].jump);
    JumpNode& leaf = nodes_[static_cast<std::size_t>(task.node)];
    leaf = {};
    leaf.a = to_int16(sums.x / sums.n);
    leaf.b = to_int16(sums.y / sums.n);
    leaf.c = to_int16(sums.z / sums.n);
  }

  std::span<const TrackerImage> images_;
  std::vector<Sample>& samples_;
  int depth_max_;
  Rng rng_;
  std::vector<JumpNode> nodes_;
  std::vector<Task> tasks_;
  std::vector<Sample> chosen_;  // a node's subsample
  std::vector<Jump> jumps_;     // of it
  std::vector<std::uint8_t> above_;
  std::array<std::vector<int>, kCandidateCount> values_{};  // of it, by candidate
};

// Points where a walk may stand: where it starts, far, near and at the joint.
Vec3f draw_stand(const TrackerImage& image, int joint, const joints::ForestView& bones, int k, Rng& rng) {
  const auto j = static_cast<std::size_t>(joint);
  const auto jitter = [&](double x, double y, double z) {
    return Vec3f{static_cast<float>(rng.normal(0, x)), static_cast<float>(rng.normal(0, y)),
                 static_cast<float>(rng.normal(0, z))};
  };
  if (k % 5 == 0) {
    joints::Shape truth{};
    for (std::size_t i = 0; i < kJointCount; ++i) joints::set_joint(truth, static_cast<int>(i), image.truth[i]);
    return joints::jump_start(bones, joint, image.view, truth) + jitter(45, 45, 35);
  }
  const double radius = k % 5 == 1 ? 250 : (k % 5 == 2 ? 100 : (k % 5 == 3 ? 45 : 25));
  return image.truth[j] + jitter(radius, radius, radius * 0.6);
}

std::vector<std::int16_t> mean_bones(std::span<const TrackerImage> images) {
  std::vector<std::int16_t> out;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    Sums sums;
    for (const TrackerImage& image : images) sums.add(image.truth[j] - image.truth[joint_index(kJointParent[j])]);
    out.push_back(to_int16(sums.x / sums.n));
    out.push_back(to_int16(sums.y / sums.n));
    out.push_back(to_int16(sums.z / sums.n));
  }
  return out;
}

}  // namespace

Forest train_forest(std::span<const TrackerImage> images, const TrainOptions& options,
                    const std::function<void(double)>& progress) {
  Forest forest;
  forest.tree_count = static_cast<std::uint32_t>(options.tree_count);
  forest.jump_count = static_cast<std::uint32_t>(options.jump_count);
  forest.bone = mean_bones(images);
  joints::ForestView bones;
  bones.bone = forest.bone;
  const int tree_total = static_cast<int>(kJointCount) * options.tree_count;
  std::vector<std::vector<JumpNode>> trees(static_cast<std::size_t>(tree_total));
  std::mutex report;
  int done = 0;
  for_each_item(tree_total, options.thread_count, [&](int item) {
    const int joint = item / options.tree_count;
    const int fold = item % options.tree_count % 2;
    Rng rng = Rng::for_item(options.seed, kTreeStream, static_cast<std::uint64_t>(item));
    std::vector<Sample> samples;
    for (std::size_t i = static_cast<std::size_t>(fold); i < images.size(); i += 2) {
      if (images[i].view.pixel_count == 0) continue;
      for (int k = 0; k < options.samples_per_image; ++k) {
        Sample s;
        s.image = static_cast<std::int32_t>(i);
        s.from = draw_stand(images[i], joint, bones, k, rng);
        s.jump = images[i].truth[static_cast<std::size_t>(joint)] - s.from;
        samples.push_back(s);
      }
    }
    if (samples.empty()) samples.emplace_back();
    trees[static_cast<std::size_t>(item)] = TreeTrainer(images, samples, options.tree_depth_max, rng).run();
    const std::lock_guard lock(report);
    if (progress) progress(static_cast<double>(++done) / tree_total);
  });
  forest.tree_start.push_back(0);
  for (const auto& tree : trees) {
    forest.nodes.insert(forest.nodes.end(), tree.begin(), tree.end());
    forest.tree_start.push_back(static_cast<std::uint32_t>(forest.nodes.size()));
  }
  return forest;
}

}  // namespace im2fit::lab
