// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/train_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "core/container.h"
#include "core/rng.h"
#include "perception/joints/estimate.h"
#include "perception/joints/model_data.h"
#include "train/common/parallel.h"
#include "train/tracker/tracker_cascade.h"
#include "train/tracker/tracker_forest.h"
#include "train/tracker/tracker_images.h"
#include "train/tracker/tracker_person_votes.h"
#include "train/tracker/tracker_votes.h"

namespace im2fit::lab {
namespace {

struct SideExample {
  std::int32_t image = 0;
  joints::Shape shape{};  // as the cascade leaves it
};

using joints::Anchor;
using joints::Split;

constexpr std::uint64_t kSideStream = 0x73696465;
constexpr int kTreeCount = 96;
constexpr int kFirstCount = 256;  // of a pair, the one is among so many anchors

std::vector<Anchor> draw_anchors(int count, Rng& rng) {
  std::vector<Anchor> out;
  for (int i = 0; i < count; ++i) {
    Anchor a;
    a.joint = a.towards = static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount)));
    a.dx = static_cast<std::int16_t>(std::clamp(rng.normal(0, 110), -600.0, 600.0));
    a.dy = static_cast<std::int16_t>(std::clamp(rng.normal(0, 110), -600.0, 600.0));
    out.push_back(a);
  }
  return out;
}

// No trees when the images show one side only.
VoteTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options) {
  VoteExamples seen;
  seen.value_count = options.pixel_count;
  seen.yes.resize(examples.size());
  for (std::size_t i = 0; i < examples.size(); ++i)
    seen.yes[i] = images[static_cast<std::size_t>(examples[i].image)].back ? 1 : 0;
  const auto backs = static_cast<std::size_t>(std::count(seen.yes.begin(), seen.yes.end(), 1));
  VoteTrees out;
  if (backs == 0 || backs == seen.size()) return out;
  Rng rng = Rng::for_item(options.seed, kSideStream, 0);
  out.anchors = draw_anchors(options.pixel_count, rng);
  const auto width = static_cast<std::size_t>(options.pixel_count);
  seen.values.resize(examples.size() * width);
  for_each_item(static_cast<int>(examples.size()), options.thread_count, [&](int item) {
    const auto i = static_cast<std::size_t>(item);
    joints::read_anchors(out.anchors, images[static_cast<std::size_t>(examples[i].image)].view, examples[i].shape,
                         seen.values.data() + i * width);
  });
  const DrawPair any_pair = [&](Rng& draws) {
    Split s;
    s.a = static_cast<std::uint16_t>(draws.index(options.pixel_count) % kFirstCount);
    s.b = static_cast<std::uint16_t>(draws.index(options.pixel_count));
    return s;
  };
  train_votes(std::move(seen), kTreeCount, any_pair, rng, out);
  return out;
}

constexpr std::uint64_t kStartStream = 0x73746172;
constexpr double kCalibrationShare = 0.08;  // of the images; learnt on by neither stage
constexpr double kCloseMm = 50;             // a confidence is the chance of an error below this

struct Progress {
  const TrainProgress& report;
  double from;
  double to;
  std::string_view stage;
  void operator()(double share) const {
    if (report) report(from + (to - from) * share, stage);
  }
};

Status check(const TrainOptions& o) {
  const auto bad = [](const std::string& detail) {
    return Error{ErrorCode::invalid_argument, "tracker training: " + detail};
  };
  if (o.image_count < 40) return bad("at least 40 images are needed, " + std::to_string(o.image_count) + " given");
  if (o.images_per_subject < 1 || o.samples_per_image < 1 || o.starts_per_image < 1)
    return bad("images per subject, samples and starts per image must be 1 or more");
  if (o.thread_count < 1 || o.thread_count > 256) return bad("thread count must be 1..256");
  if (o.tree_count < 2 || o.tree_count > 16 || o.tree_count % 2 != 0)
    return bad("trees per joint must be 2, 4 .. 16");
  if (o.jump_count < 1 || o.jump_count > 64 || o.tree_depth_max < 1 || o.tree_depth_max > 30)
    return bad("jumps must be 1..64 and tree depth 1..30");
  if (o.level_count < 1 || o.level_count > 32 || o.level_tree_count < 1 || o.level_tree_count > 4096)
    return bad("cascade levels must be 1..32 with 1..4096 trees each");
  if (o.pixel_count < 2 || o.pixel_count > joints::kPixelCountMax) return bad("anchors per level must be 2..1024");
  return Ok{};
}

// Where the cascade will be started from on the device: the forest (by trees that have not seen the image), and the
// forest blurred.
std::vector<CascadeStart> make_starts(std::span<const TrackerImage> images, const Forest& forest,
                                      const TrainOptions& options) {
  const std::size_t per_image = static_cast<std::size_t>(options.starts_per_image);
  std::vector<CascadeStart> starts(images.size() * per_image);
  for_each_item(static_cast<int>(images.size()), options.thread_count, [&](int i) {
    const TrackerImage& image = images[static_cast<std::size_t>(i)];
    joints::Shape cold{};
    joints::run_forest(forest.view().half(static_cast<std::uint32_t>(1 - i % 2)), image.view, cold);
    Rng rng = Rng::for_item(options.seed, kStartStream, static_cast<std::uint64_t>(i));
    for (std::size_t s = 0; s < per_image; ++s) {
      CascadeStart& start = starts[static_cast<std::size_t>(i) * per_image + s];
      start.image = i;
      start.shape = cold;
      if (s == 0) continue;
      const Vec3f moved = {static_cast<float>(rng.normal(0, 10)), static_cast<float>(rng.normal(0, 10)),
                           static_cast<float>(rng.normal(0, 10))};
      for (int j = 0; j < static_cast<int>(kJointCount); ++j) {
        const Vec3f blur = {static_cast<float>(rng.normal(0, 14)), static_cast<float>(rng.normal(0, 14)),
                            static_cast<float>(rng.normal(0, 14))};
        joints::set_joint(start.shape, j, joints::joint_of(cold, j) + moved + blur);
      }
    }
  });
  return starts;
}

// Twelve bins of equal count in order of ensemble spread, chances made to fall (pool adjacent violators).
void fit_bins(std::vector<std::pair<float, bool>>& seen, joints::ConfidenceBin* bins) {
  std::stable_sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const std::size_t bin_count = static_cast<std::size_t>(joints::kConfidenceBinCount);
  std::array<double, static_cast<std::size_t>(joints::kConfidenceBinCount)> chance{};
  std::array<double, static_cast<std::size_t>(joints::kConfidenceBinCount)> weight{};
  for (std::size_t b = 0; b < bin_count; ++b) {
    const std::size_t first = b * seen.size() / bin_count;
    const std::size_t last = std::max(first + 1, (b + 1) * seen.size() / bin_count);
    double good = 0;
    for (std::size_t i = first; i < last; ++i) good += seen[std::min(i, seen.size() - 1)].second ? 1 : 0;
    weight[b] = static_cast<double>(last - first);
    chance[b] = (good + 1) / (weight[b] + 2);
    bins[b].spread_mm_max = static_cast<std::uint16_t>(
        std::clamp(std::ceil(seen[std::min(last, seen.size()) - 1].first), 0.0F, 65535.0F));
  }
  for (std::size_t b = 1; b < bin_count; ++b) {
    for (std::size_t low = b; low > 0 && chance[low - 1] < chance[low]; --low) {
      const double pooled =
          (chance[low - 1] * weight[low - 1] + chance[low] * weight[low]) / (weight[low - 1] + weight[low]);
      chance[low - 1] = chance[low] = pooled;
    }
  }
  for (std::size_t b = 0; b < bin_count; ++b) {
    if (b > 0) chance[b] = std::min(chance[b], chance[b - 1]);
    bins[b].chance = static_cast<std::uint16_t>(std::lround(std::clamp(chance[b], 0.0, 1.0) * 65535.0));
  }
}

std::vector<joints::ConfidenceBin> calibrate(std::span<const TrackerImage> images, const JointModel::Data& model) {
  std::array<std::vector<std::pair<float, bool>>, kJointCount> seen;
  joints::View mirror_image;
  for (const TrackerImage& image : images) {
    if (image.view.pixel_count == 0) continue;
    joints::mirror(image.view, mirror_image);
    const joints::JointEstimate found = joints::estimate(model, image.view, mirror_image);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vec3f p = joints::joint_of(found.shape, static_cast<int>(j));
      seen[j].emplace_back(found.spread_mm[j], static_cast<double>(norm(p - image.truth[j])) < kCloseMm);
    }
  }
  std::vector<joints::ConfidenceBin> bins(kJointCount * static_cast<std::size_t>(joints::kConfidenceBinCount));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (seen[j].empty()) seen[j].emplace_back(0.0F, false);
    fit_bins(seen[j], bins.data() + j * static_cast<std::size_t>(joints::kConfidenceBinCount));
  }
  return bins;
}

// As the forest and the cascade leave each image.
std::vector<SideExample> side_examples(std::span<const CascadeStart> starts, int starts_per_image) {
  std::vector<SideExample> out;
  for (std::size_t i = 0; i < starts.size(); i += static_cast<std::size_t>(starts_per_image))
    out.push_back({starts[i].image, starts[i].shape});
  return out;
}

std::string describe(const TrainOptions& o) {
  const auto n = [](auto number) { return std::to_string(number); };
  return "im2fit joint model: " + n(o.image_count) + " renders and their mirror images, " + n(o.images_per_subject) +
         " a subject, seed " + n(o.seed) + "; forest " + n(o.tree_count) + " trees of depth " + n(o.tree_depth_max) +
         ", " + n(o.samples_per_image) + " samples a render; cascade " + n(o.level_count) + " levels of " +
         n(o.level_tree_count) + " trees, " + n(o.pixel_count) + " anchors, " + n(o.starts_per_image) +
         " starts a render";
}

std::vector<std::byte> pack(const joints::Meta& meta, const Forest& forest, const Cascade& cascade,
                            const VoteTrees& side, const VoteTrees& person_votes,
                            std::span<const joints::ConfidenceBin> bins, const std::string& provenance) {
  ContainerWriter writer(joints::kTrackerMagic, joints::kTrackerVersion);
  writer.add_array<joints::Meta>("meta", std::span(&meta, 1));
  writer.add_array<std::uint32_t>("tree", forest.tree_start);
  writer.add_array<joints::JumpNode>("node", forest.nodes);
  writer.add_array<std::int16_t>("bone", forest.bone);
  writer.add_array<joints::Anchor>("anchor", cascade.anchors);
  writer.add_array<joints::Split>("split", cascade.splits);
  writer.add_array<std::int8_t>("leaf", cascade.leaves);
  writer.add_array<joints::Basis>("basis", cascade.basis);
  writer.add_array<joints::ConfidenceBin>("confidence", bins);
  writer.add_array<joints::Anchor>("side anchor", side.anchors);
  writer.add_array<joints::Split>("side split", side.splits);
  writer.add_array<std::int16_t>("side leaf", side.leaves);
  writer.add_array<joints::Anchor>("somebody anchor", person_votes.anchors);
  writer.add_array<joints::Split>("somebody split", person_votes.splits);
  writer.add_array<std::int16_t>("somebody leaf", person_votes.leaves);
  writer.add_array<char>("provenance", provenance);
  return writer.finish();
}

}  // namespace

Result<std::vector<std::byte>> train_tracker(const body::BodyModel& model, const TrainOptions& options,
                                             const TrainProgress& progress) {
  if (Status ok = check(options); !ok) return ok.error();
  std::vector<TrackerImage> images =
      render_tracker_images(model, options.image_count, options.images_per_subject, options.seed,
                            options.thread_count, Progress{progress, 0.0, 0.4, "rendering"});
  // Even, so that a picture and its mirror image are in the same half.
  const auto learnt_count =
      static_cast<std::size_t>(static_cast<double>(images.size()) * (1.0 - kCalibrationShare)) / 2 * 2;
  const auto split = images.begin() + static_cast<std::ptrdiff_t>(learnt_count);
  const std::vector<TrackerImage> unseen(split, images.end());
  images.erase(split, images.end());
  images.reserve(2 * learnt_count);
  for (std::size_t i = 0; i < learnt_count; ++i) images.push_back(mirrored(images[i]));
  const std::span<const TrackerImage> learnt(images);
  const Forest forest = train_forest(learnt, options, Progress{progress, 0.4, 0.53, "jump forest"});
  std::vector<CascadeStart> starts = make_starts(learnt, forest, options);
  const Cascade cascade = train_cascade(learnt, starts, options, Progress{progress, 0.53, 0.8, "cascade"});
  const VoteTrees side = train_side(learnt, side_examples(starts, options.starts_per_image), options);

  joints::Meta meta = {static_cast<std::uint32_t>(options.tree_count),
                       static_cast<std::uint32_t>(options.jump_count),
                       static_cast<std::uint32_t>(options.level_count),
                       static_cast<std::uint32_t>(options.level_tree_count),
                       static_cast<std::uint32_t>(options.pixel_count),
                       static_cast<std::uint32_t>(side.tree_count()),
                       0};
  JointModel::Data data;
  data.meta = meta;
  data.forest = forest.view();
  data.anchors = cascade.anchors;
  data.splits = cascade.splits;
  data.leaves = cascade.leaves;
  data.basis = cascade.basis;
  const std::vector<joints::ConfidenceBin> bins = calibrate(unseen, data);
  images.clear();
  images.shrink_to_fit();
  // Person votes are learnt on the answers of the finished joint model.
  const std::vector<std::byte> voteless = pack(meta, forest, cascade, side, {}, bins, {});
  const auto joint_model = JointModel::parse(voteless, "the model so far");
  if (!joint_model) return joint_model.error();
  const VoteTrees person_votes =
      train_person_votes(model, *joint_model, options, Progress{progress, 0.8, 0.99, "person votes"});
  if (person_votes.tree_count() == 0)
    return Error{ErrorCode::invalid_argument, "tracker training: " + std::to_string(options.image_count) +
                                                  " images do not show both people and things like them; give more"};
  meta.person_tree_count = static_cast<std::uint32_t>(person_votes.tree_count());
  if (progress) progress(1.0, "done");
  return pack(meta, forest, cascade, side, person_votes, bins, describe(options));
}

}  // namespace im2fit::lab
