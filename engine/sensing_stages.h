// SPDX-License-Identifier: Apache-2.0
// Sensor and Fuser as stages of the pipeline: all that is needed but the measurement itself.
#pragma once

#include "engine/frame_stages.h"
#include "kernels/observe/observe.h"

namespace im2fit {

class SensingStages : public FrameStages {
 public:
  // The model must outlive the stages.
  SensingStages(int width, int height, const JointModel& joint_model)
      : sensor_(width, height, joint_model), fuser_(width, height) {}

  void before_sense(float seconds, int user) override {
    seconds_ = seconds;
    sensor_.select(user);
  }
  Sighting sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask) override {
    return sensor_.sense(depth, intrinsics, mask, seconds_);
  }
  void reset_sense() override { sensor_.reset(); }

  GuidanceSet add(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Sighting& sighting) override {
    return fuser_.add(depth, mask, intrinsics, sighting);
  }
  int frame_count() const override { return fuser_.frame_count(); }
  bool measure(MeasuredPerson& /*person*/) override { return false; }
  void reset_fit() override { fuser_.reset(); }
  ImageView<const std::uint16_t> fused_depth_q4() const override { return fuser_.depth_q4(); }
  MaskView fused_mask() const override { return fuser_.mask(); }

 protected:
  Fuser& fuser() { return fuser_; }

 private:
  Sensor sensor_;
  Fuser fuser_;
  float seconds_ = kFramePeriodS;
};

}  // namespace im2fit
