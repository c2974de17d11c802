// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_person_votes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/rng.h"
#include "perception/joints/person_votes.h"
#include "perception/segment/segment.h"
#include "train/common/parallel.h"
#include "train/tracker/tracker_images.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPeopleStream = 0x736D6231;
constexpr std::uint64_t kRoomStream = 0x736D6232;
constexpr std::uint64_t kSubjectStream = 0x736D6233;
constexpr int kPicturesPerSubject = 7;
constexpr int kRoomsPerStudio = 64;
constexpr int kThingsMax = 4;  // examined in a room

// One worker's: rows of examples in the order found.
class ExampleCollector {
 public:
  ExampleCollector(const body::BodyModel& model, const JointModel& joint_model,
                   std::span<const joints::Anchor> anchors)
      : model_(model), studio_(model), tracker_(joint_model), anchors_(anchors) {}

  // Whose pictures, or whose size of room, come next.
  void change_subject(std::uint64_t seed, std::uint64_t index) {
    subject_ = draw_subject(model_, Family::training, seed, index, rest_);
  }

  void add_person(Rng& rng) {
    const UprightFrame frame = studio_.render(subject_, rest_, draw_tracker_scene(person_mix(), rng));
    Segmenter segmenter(frame.intrinsics.width, frame.intrinsics.height);
    PersonTracker people;
    const Person person = detect(segmenter, people, frame);
    if (person.found && overlap(mask_, frame.truth_mask)) add(frame, person, people.shape_odds(person.id), true);
  }

  void add_room(Rng& rng) {
    const UprightFrame frame = studio_.render(subject_, rest_, draw_empty_room(rng));
    Segmenter segmenter(frame.intrinsics.width, frame.intrinsics.height);
    PersonTracker people;
    std::vector<int> seen;
    while (static_cast<int>(seen.size()) < kThingsMax) {
      const Person person = detect(segmenter, people, frame);
      if (!person.found || std::find(seen.begin(), seen.end(), person.id) != seen.end()) return;
      add(frame, person, people.shape_odds(person.id), false);
      seen.push_back(person.id);
      people.reject(person.id);  // the next one's turn
    }
  }

  // What was found since the last call.
  VoteExamples take() {
    found_.value_count = value_count();
    detection_count_ = 0;
    return std::exchange(found_, {});
  }

 private:
  Person detect(Segmenter& segmenter, PersonTracker& people, const UprightFrame& frame) {
    mask_.resize(frame.depth.size());
    return segmenter.run(depth_of(frame), frame.intrinsics, people,
                         MaskImage(mask_.data(), frame.intrinsics.width, frame.intrinsics.height));
  }
  static DepthView depth_of(const UprightFrame& frame) {
    return {frame.depth.data(), frame.intrinsics.width, frame.intrinsics.height};
  }

  void add(const UprightFrame& frame, const Person& person, float shape_odds, bool yes) {
    const MaskView mask(mask_.data(), frame.intrinsics.width, frame.intrinsics.height);
    tracker_.track(depth_of(frame), mask, frame.intrinsics, person, false);
    if (tracker_.view().pixel_count == 0) return;
    joints::Witness witness = {shape_odds, tracker_.person_score(), person.floor};
    add_row(tracker_.view(), tracker_.estimate(), witness, yes);
    joints::mirror(tracker_.view(), mirror_image_);
    witness.floor.up.x = -witness.floor.up.x;
    if (++detection_count_ % 2 == 0) witness = {0, witness.person_score, {}};
    add_row(mirror_image_, joints::mirrored(tracker_.estimate()), witness, yes);
  }

  void add_row(const joints::View& view, const joints::JointEstimate& estimate, const joints::Witness& witness,
               bool yes) {
    const std::size_t first = found_.values.size();
    found_.values.resize(first + static_cast<std::size_t>(value_count()));
    joints::read_values(anchors_, view, estimate, witness, found_.values.data() + first);
    found_.yes.push_back(yes ? 1 : 0);
  }

  int value_count() const { return static_cast<int>(anchors_.size()) + joints::kClueCount; }

  const body::BodyModel& model_;
  Subject subject_;
  std::vector<Vec3f> rest_;
  Studio studio_;
  JointTracker tracker_;
  std::span<const joints::Anchor> anchors_;
  std::vector<std::uint8_t> mask_;
  joints::View mirror_image_;
  int detection_count_ = 0;
  VoteExamples found_;
};

void append(const VoteExamples& from, VoteExamples& to) {
  to.values.insert(to.values.end(), from.values.begin(), from.values.end());
  to.yes.insert(to.yes.end(), from.yes.begin(), from.yes.end());
}

}  // namespace

VoteExamples collect_detections(const body::BodyModel& model, const JointModel& joint_model,
                                std::span<const joints::Anchor> anchors, const DetectionPlan& plan,
                                const std::function<void(double)>& progress) {
  const int person_items = (plan.people_count + kPicturesPerSubject - 1) / kPicturesPerSubject;
  const int room_items = (plan.room_count + kRoomsPerStudio - 1) / kRoomsPerStudio;
  const std::uint64_t subject_seed = Rng::for_item(plan.seed, kSubjectStream, 0).next();
  std::vector<VoteExamples> parts(static_cast<std::size_t>(person_items + room_items));
  const auto collect = [&](ExampleCollector& collector, int item) {
    collector.change_subject(subject_seed, static_cast<std::uint64_t>(item));
    const bool people = item < person_items;
    const int per_item = people ? kPicturesPerSubject : kRoomsPerStudio;
    const int first = (people ? item : item - person_items) * per_item;
    const int last = std::min(first + per_item, people ? plan.people_count : plan.room_count);
    for (int i = first; i < last; ++i) {
      Rng rng = Rng::for_item(plan.seed, people ? kPeopleStream : kRoomStream, static_cast<std::uint64_t>(i));
      if (people)
        collector.add_person(rng);
      else
        collector.add_room(rng);
    }
    parts[static_cast<std::size_t>(item)] = collector.take();
  };
  const auto make_worker = [&] {
    return [&, collector = ExampleCollector(model, joint_model, anchors)](int item) mutable {
      collect(collector, item);
    };
  };
  for_each_item_by_worker(person_items + room_items, plan.thread_count, make_worker, [&](std::uint64_t done) {
    if (progress) progress(static_cast<double>(done) / (person_items + room_items));
  });
  VoteExamples all;
  all.value_count = static_cast<int>(anchors.size()) + joints::kClueCount;
  for (VoteExamples& part : parts) {
    append(part, all);
    part = {};
  }
  return all;
}

namespace {

using joints::Anchor;
using joints::kClueCount;
using joints::kSpreadClues;
using joints::Split;

constexpr std::uint64_t kPersonVotesStream = 0x736D6264;
constexpr int kTreeCount = 300;
constexpr double kClueShare = 0.2;      // of the pairs compared
constexpr double kWithinGroup = 0.7;    // of the clues of joints: with another joint's
constexpr std::size_t kBlockSize = 64;  // examples; things of one room mostly stay together
constexpr std::size_t kFoldCount = 6;   // one of them is kept to calibrate on
constexpr double kAnchorSpreadMm = 130;
constexpr int kNewtonSteps = 25;
constexpr double kScaleMin = 0.05;

// Every second one between two joints, so that it goes with a limb.
std::vector<Anchor> draw_anchors(int count, Rng& rng) {
  const auto joint = [&] { return static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount))); };
  const auto offset = [&] {
    return static_cast<std::int16_t>(std::clamp(rng.normal(0, kAnchorSpreadMm), -600.0, 600.0));
  };
  std::vector<Anchor> out;
  for (int i = 0; i < count; ++i) {
    Anchor a;
    a.joint = a.towards = joint();
    if (i % 2 == 1) {
      a.towards = joint();
      a.share_q8 = static_cast<std::int16_t>(rng.index(257));
    }
    a.dx = offset();
    a.dy = offset();
    out.push_back(a);
  }
  return out;
}

Split draw_pair(int pixel_count, Rng& rng) {
  const auto any = [&](int first, int count) { return static_cast<std::uint16_t>(first + rng.index(count)); };
  Split s;
  if (rng.uniform() >= kClueShare) {
    s.a = any(0, pixel_count);
    s.b = any(0, pixel_count);
    return s;
  }
  const int clue = 1 + rng.index(kClueCount - 1);
  s.a = static_cast<std::uint16_t>(pixel_count + clue);
  s.b = static_cast<std::uint16_t>(pixel_count);  // zero
  constexpr int kGroup = static_cast<int>(kJointCount);
  if (clue >= kSpreadClues && rng.uniform() < kWithinGroup)
    s.b = any(pixel_count + clue - (clue - kSpreadClues) % kGroup, kGroup);
  return s;
}

bool kept_back(std::size_t example) {
  return example / kBlockSize % kFoldCount == kFoldCount - 1;
}

VoteExamples select(const VoteExamples& all, bool kept) {
  VoteExamples out;
  out.value_count = all.value_count;
  const auto width = static_cast<std::ptrdiff_t>(all.value_count);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kept_back(i) != kept) continue;
    const auto row = all.values.begin() + static_cast<std::ptrdiff_t>(i) * width;
    out.values.insert(out.values.end(), row, row + width);
    out.yes.push_back(all.yes[i]);
  }
  return out;
}

bool both_kinds(const VoteExamples& examples) {
  const auto yes = std::count(examples.yes.begin(), examples.yes.end(), 1);
  return yes > 0 && static_cast<std::size_t>(yes) < examples.size();
}

// What votes are worth on examples they have not learnt from: log-odds = scale x votes, by Newton's method, from a
// weak belief in 1.
double scale_of(const VoteTrees& trees, const VoteExamples& unseen) {
  double scale = 1;
  for (int step = 0; step < kNewtonSteps; ++step) {
    double slope = 1 - scale, bend = 1;
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      const std::int16_t* values = unseen.values.data() + static_cast<std::ptrdiff_t>(i) * unseen.value_count;
      const double votes = static_cast<double>(joints::count_votes(trees.view(), values)) / joints::kVoteUnit;
      const double p = 1 / (1 + std::exp(-scale * votes));
      slope += (unseen.yes[i] - p) * votes;
      bend += p * (1 - p) * votes * votes;
    }
    scale = std::clamp(scale + std::clamp(slope / bend, -0.2, 0.2), kScaleMin, 1.0);
  }
  return scale;
}

}  // namespace

VoteTrees train_person_votes(const body::BodyModel& model, const JointModel& joint_model, const TrainOptions& options,
                             const std::function<void(double)>& progress) {
  Rng rng = Rng::for_item(options.seed, kPersonVotesStream, 0);
  VoteTrees out;
  out.anchors = draw_anchors(options.pixel_count, rng);
  const DetectionPlan plan = {options.image_count / 4, options.image_count, options.seed, options.thread_count};
  const VoteExamples all = collect_detections(model, joint_model, out.anchors, plan, progress);
  VoteExamples learnt = select(all, false);
  const VoteExamples unseen = select(all, true);
  if (!both_kinds(learnt)) return {};
  const DrawPair pair = [&](Rng& draws) { return draw_pair(options.pixel_count, draws); };
  train_votes(std::move(learnt), kTreeCount, pair, rng, out);
  const double scale = scale_of(out, unseen);
  for (std::int16_t& leaf : out.leaves) leaf = static_cast<std::int16_t>(std::lround(scale * leaf));
  return out;
}

}  // namespace im2fit::lab
