// SPDX-License-Identifier: Apache-2.0
// PersonDetector and Fuser as stages of the pipeline: everything except the measurement itself.
#pragma once

#include <optional>

#include "engine/frame_stages.h"
#include "perception/observe/edge_restorer.h"
#include "perception/observe/observe.h"

namespace im2fit {

class SensingStages : public FrameStages {
 public:
  // The model must outlive the stages. `turn`: as the engine's settings; memory for the back only with Turn::back.
  SensingStages(int width, int height, const JointModel& joint_model, Turn turn = Turn::none)
      : edges_(width, height), sensor_(width, height, joint_model), front_(width, height) {
    if (turn == Turn::back) back_.emplace(width, height);
  }

  void restore_edges(DepthImage depth, const Intrinsics& intrinsics) override { edges_.run(depth, intrinsics.fx); }
  Detection sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) override {
    const GuidanceSet frame_guidance = edges_.beyond_repair() ? static_cast<GuidanceSet>(Guidance::too_noisy) : 0;
    Detection detection = sensor_.sense(depth, intrinsics, mask, seconds, frame_guidance);
    detection.edges_restored = edges_.restored();
    return detection;
  }
  void set_down(Vec3f down) override { sensor_.set_down(down); }
  PersonTracker& people() override { return sensor_.people(); }
  void reset_sense() override {
    edges_.reset();
    sensor_.reset();
  }

  GuidanceSet add(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Detection& detection) override {
    edges_restored_ = detection.edges_restored;
    return accumulating().add(depth, mask, intrinsics, detection);
  }
  int frame_count() const override { return turned_ ? back_->frame_count() : front_.frame_count(); }
  bool measure(MeasuredPerson& /*person*/) override { return false; }
  bool turn() override {
    turned_ = back_.has_value();
    if (turned_) back_->reset();
    return turned_;
  }
  void drop_back() override { turned_ = false; }
  void reset_fit() override {
    turned_ = false;
    front_.reset();
  }
  ImageView<const std::uint16_t> fused_depth_q4() const override { return front_.depth_q4(); }
  MaskView fused_mask() const override { return front_.mask(); }

 protected:
  bool edges_restored() const { return edges_restored_; }  // of the frame accumulated last
  Fuser& front() { return front_; }
  Fuser* back() { return turned_ ? &*back_ : nullptr; }  // null: the front alone is accumulated

 private:
  Fuser& accumulating() { return turned_ ? *back_ : front_; }

  EdgeRestorer edges_;
  PersonDetector sensor_;
  Fuser front_;
  std::optional<Fuser> back_;
  bool turned_ = false;
  bool edges_restored_ = false;  // FIT's
};

}  // namespace im2fit
