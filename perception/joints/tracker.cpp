// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/tracker.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/joints/estimate.h"
#include "perception/joints/model_data.h"
#include "perception/joints/person_votes.h"
#include "perception/joints/side.h"
#include "perception/joints/snap_to_mask.h"

namespace im2fit {
namespace joints {

constexpr float kPlaceMaxMm = 1e6F;

Vec3f jump_start(const ForestView& forest, int joint, const View& view, const Shape& shape) {
  const auto j = static_cast<std::size_t>(joint);
  if (joint == static_cast<int>(Joint::TO)) return view.centroid_mm;
  const Vec3f parent = joint_of(shape, static_cast<int>(kJointParent[j]));
  return parent + Vec3f{static_cast<float>(forest.bone[3 * j]), static_cast<float>(forest.bone[3 * j + 1]),
                        static_cast<float>(forest.bone[3 * j + 2])} *
                      0.5F;
}

void read_anchors(std::span<const Anchor> anchors, const View& view, const Shape& shape, std::int16_t* out,
                  std::ptrdiff_t step) {
  AnchorJoints joints;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = joint_of(shape, static_cast<int>(j));
    joints.x[j] = p.x;
    joints.y[j] = p.y;
    joints.inverse_z[j] = 1.0F / safe_depth(p.z);
  }
  const int reference = static_cast<int>(joint_of(shape, static_cast<int>(Joint::TO)).z);
  const AnchorBox box = {view.depth.data(), view.width, view.height, view.u_first, view.v_first,
                         view.fx,           view.fy,    view.cx,     view.cy,      reference};
  anchor_depths(anchors.data(), static_cast<int>(anchors.size()), joints, box, out, step);
}

void add_sums(const Basis& basis, const std::int32_t* sum, Shape& shape) {
  constexpr auto kSize = static_cast<std::size_t>(kShapeSize);
  for (std::size_t k = 0; k < static_cast<std::size_t>(kLeafSize); ++k) {
    const float amount = static_cast<float>(sum[k]);
    for (std::size_t i = 0; i < kSize; ++i) shape[i] += basis[k * kSize + i] * amount;
  }
  // A file may hold anything: places further away than any camera sees must stay numbers of pixels.
  for (float& mm : shape) mm = std::clamp(mm, -kPlaceMaxMm, kPlaceMaxMm);
}

void run_cascade(const JointModel::Data& model, std::span<CascadeRun> runs) {
  constexpr auto kLanes = static_cast<std::size_t>(kRunLanes);
  alignas(2 * kLanes) std::array<std::int16_t, kPixelCountMax * kLanes> pixels;  // the runs' values side by side
  std::array<std::array<std::int32_t, static_cast<std::size_t>(kLeafSize)>, kCascadeRunsMax> sums;
  const std::size_t pixel_count = model.meta.pixel_count;
  const std::size_t tree_count = model.meta.level_tree_count;
  std::fill_n(pixels.begin(), pixel_count * kLanes, std::int16_t{0});
  for (std::size_t level = 0; level < model.meta.level_count; ++level) {
    const auto anchors = model.anchors.subspan(level * pixel_count, pixel_count);
    for (std::size_t r = 0; r < runs.size(); ++r)
      read_anchors(anchors, *runs[r].view, runs[r].shape, pixels.data() + r, kRunLanes);
    sums = {};
    const std::size_t tree = level * tree_count;
    sum_leaves(model.splits.data() + tree * kSplitCount, model.leaves.data() + tree * kLeafCount * kLeafSize,
               static_cast<int>(tree_count), pixels.data(), static_cast<int>(runs.size()), sums[0].data());
    for (std::size_t r = 0; r < runs.size(); ++r) add_sums(model.basis[level], sums[r].data(), runs[r].shape);
  }
}

}  // namespace joints

namespace {

constexpr int kSideFrames = 4;           // the newest frame's share in the side is one of these
constexpr float kOffMaskShare = 0.7F;    // a joint beside the mask is less sure
constexpr float kOffImageShare = 0.15F;  // one outside the picture is a guess
constexpr float kNothingOdds = -8;       // of an empty mask: less than the trees give any object

float chance_in(const joints::ConfidenceBin& bin) {
  return static_cast<float>(bin.chance) * (1.0F / 65535.0F);
}

bool hand(std::size_t joint) {
  return joint == joint_index(Joint::LA) || joint == joint_index(Joint::RA);
}

// Chance of being within 50 mm, by ensemble spread.
float chance_of(const JointModel::Data& model, int joint, float spread_mm) {
  const auto bins = model.bins.subspan(static_cast<std::size_t>(joint * joints::kConfidenceBinCount),
                                       static_cast<std::size_t>(joints::kConfidenceBinCount));
  for (const joints::ConfidenceBin& bin : bins)
    if (spread_mm <= static_cast<float>(bin.spread_mm_max)) return chance_in(bin);
  return chance_in(bins.back());
}

}  // namespace

struct JointTracker::Workspace {
  explicit Workspace(const JointModel& m) : model(&m.data()) {
    view.depth.resize(joints::kViewPixelCountMax);
    mirror_image.depth.resize(joints::kViewPixelCountMax);
    // A table's bins hold equally many.
    float sum = 0;
    for (const joints::ConfidenceBin& bin : model->bins) sum += chance_in(bin);
    usual_chance = sum / static_cast<float>(model->bins.size());
  }
  const JointModel::Data* model;
  joints::View view;
  joints::View mirror_image;
  float usual_chance = 1;  // mean over the trained for
  float person_score = 0;
  joints::JointEstimate seen;
  FloorPlane floor;
  int side_sum = 0;  // of scores, fading: four times their mean

  bool back() const { return side_sum > 0; }
  void see_side(const joints::Shape& shape, bool cold) {
    const int score = joints::side_score(*model, view, shape);
    side_sum = cold ? kSideFrames * score : side_sum - side_sum / kSideFrames + score;
  }
};

JointTracker::JointTracker(const JointModel& model) : work_(std::make_unique<Workspace>(model)) {}
JointTracker::~JointTracker() = default;
JointTracker::JointTracker(JointTracker&&) noexcept = default;
JointTracker& JointTracker::operator=(JointTracker&&) noexcept = default;

JointSet JointTracker::track(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person,
                             bool same_person) {
  JointSet out;
  const JointModel::Data& model = *work_->model;
  const joints::View& view = work_->view;
  if (!joints::downsample(depth, mask, intrinsics, person, work_->view)) {
    work_->person_score = 0;
    return out;
  }

  joints::mirror(view, work_->mirror_image);
  const joints::JointEstimate& seen = work_->seen = joints::estimate(model, view, work_->mirror_image);
  work_->floor = person.floor;
  work_->see_side(seen.shape, !same_person);

  float sum = 0;
  int inside_count = 0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = joints::joint_of(seen.shape, static_cast<int>(j));
    float chance = chance_of(model, static_cast<int>(j), seen.spread_mm[j]);
    const float inverse_z = 1.0F / joints::safe_depth(p.z);
    const float u = intrinsics.fx * p.x * inverse_z + intrinsics.cx;
    const float v = intrinsics.fy * p.y * inverse_z + intrinsics.cy;
    const bool inside =
        u >= 0 && v >= 0 && u <= static_cast<float>(depth.width - 1) && v <= static_cast<float>(depth.height - 1);
    sum += inside ? chance : 0.0F;
    inside_count += inside ? 1 : 0;
    if (!inside)
      chance *= kOffImageShare;
    else if (view.at_ray(p.x * inverse_z, p.y * inverse_z) == 0)
      chance *= kOffMaskShare;
    out.position_mm[j] = hand(j) ? joints::snap_to_mask(p, view, depth, intrinsics) : p;
    out.confidence[j] = chance;
  }
  work_->person_score = inside_count > 0 ? sum / (static_cast<float>(inside_count) * work_->usual_chance) : 0.0F;
  if (work_->back()) joints::swap_sides(out);
  return out;
}

float JointTracker::person_score() const {
  return work_->person_score;
}

float JointTracker::person_odds(float shape_odds) const {
  if (work_->view.pixel_count == 0) return kNothingOdds;  // `seen` is of an earlier frame
  const joints::Votes& votes = work_->model->person_votes;
  joints::VoteValues values;
  joints::read_values(votes.anchors, work_->view, work_->seen, {shape_odds, work_->person_score, work_->floor},
                      values.data());
  return static_cast<float>(joints::count_votes(votes, values.data())) * (1.0F / joints::kVoteUnit);
}

const joints::View& JointTracker::view() const {
  return work_->view;
}

const joints::JointEstimate& JointTracker::estimate() const {
  return work_->seen;
}

float JointTracker::back_chance() const {
  return joints::chance_of_score(work_->side_sum / kSideFrames);
}

}  // namespace im2fit
