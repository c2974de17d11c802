// SPDX-License-Identifier: Apache-2.0
// Fifteen joints of the masked person: jump forest (start) and regression cascade (refinement), integer arithmetic.
// Method: random tree walk (Jung 2015) with learned jumps, then explicit shape regression (Kazemi 2014).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/camera.h"
#include "core/joints.h"
#include "core/status.h"
#include "perception/segment/segment.h"

namespace im2fit {

namespace joints {
struct JointEstimate;
struct View;
}  // namespace joints

class JointModel {  // the contents of a .i2t file; immutable, shareable
 public:
  // Views into `bytes`, which must outlive the model. `what` names the file in errors.
  static Result<JointModel> parse(std::span<const std::byte> bytes, const std::string& what);
  JointModel(JointModel&&) noexcept;
  JointModel& operator=(JointModel&&) noexcept;
  ~JointModel();
  struct Data;
  const Data& data() const { return *data_; }
  std::string_view provenance() const;  // how it was trained; as long as the bytes live
  std::uint32_t key() const;            // identifies the model: CRC-32C of the bytes

 private:
  JointModel();
  std::unique_ptr<Data> data_;
};

class JointTracker {
 public:
  explicit JointTracker(const JointModel& model);  // the model must outlive the tracker
  ~JointTracker();
  JointTracker(JointTracker&&) noexcept;
  JointTracker& operator=(JointTracker&&) noexcept;
  // Each frame is answered for itself: starting from the last frame's joints was worse (28.6 mm for 27.1 over six
  // frames of one pose), because their error is not independent. `same_person`: as in the last call; only front or
  // back is kept over frames. All zero when the mask is empty. No allocation.
  JointSet track(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person,
                 bool same_person);
  // After track(): the chance that the person's back is towards the camera, over the last frames (their scores'
  // mean, the newest counting a quarter) since a cold start. Left and right of the joints follow it.
  float back_chance() const;
  // After track(): the joints' mean confidence by that of the people the model was trained for, about 1; only joints
  // inside the picture count, beside the mask or not. Furniture has 0.5 to 0.7, since the model's runs disagree on
  // it; an empty mask 0.
  float person_score() const;
  // After track(): log-odds that it is a person and not an object, -8 of an empty mask. `shape_odds`:
  // PersonTracker::shape_odds. No allocation.
  float person_odds(float shape_odds) const;
  // After track(): the view the joints were read from, and the runs' estimate, as if facing the camera; for training.
  const joints::View& view() const;
  const joints::JointEstimate& estimate() const;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

}  // namespace im2fit
