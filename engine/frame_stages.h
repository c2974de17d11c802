// SPDX-License-Identifier: Apache-2.0
// The interface between the pipeline (threads, rings, session) and the stages it runs on frames. Production:
// PersonDetector, Fuser and Index (engine/production_stages.cpp); tests have their own.
#pragma once

#include <memory>

#include "core/clothing.h"
#include "core/status.h"
#include "engine/engine.h"
#include "estimate/plausibility.h"

namespace im2fit {

// The result of a session.
struct MeasuredPerson {
  index::Answer answer;
  bool around = false;  // the answer rests on a turn, too
  AgeAnswer age;
  body::SeenBody seen;
  Plausibility plausibility;
  MeasurementValues paper{};
  JointSet joints;
  FloorPlane floor;
};

// Methods of one stage are called from one thread at a time; the two stages run at the same time. No allocation.
class FrameStages {
 public:
  virtual ~FrameStages() = default;

  // Stage SENSE.
  // Before sense() of a frame: moves the frame's edges back in place, where the sensor's driver spoils them.
  virtual void restore_edges(DepthImage /*depth*/, const Intrinsics& /*intrinsics*/) {}
  // The people in view; mask, joints and pose of people().selected(), or of the person chosen when that is 0.
  // `seconds` since the frame before.
  virtual Detection sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) = 0;
  // The direction of gravity, in the frames' axes, from the next frame on.
  virtual void set_down(Vec3f /*down*/) {}
  virtual PersonTracker& people() = 0;
  virtual void reset_sense() = 0;  // and people()

  // Stage FIT. `add` returns guidance of its own instead of adding.
  virtual GuidanceSet add(DepthView depth, MaskView mask, const Intrinsics& intrinsics,
                          const Detection& detection) = 0;
  // Where the camera was that took the frame added last, if it tells; before turn().
  virtual void set_pose(const std::optional<hal::CameraPose>& /*pose*/) {}
  virtual int frame_count() const = 0;  // of the side being accumulated: the front until turn(), then the back
  // The expensive step, once a session; with Turn::back once for the front and once for both sides. False when the
  // accumulated frames cannot be described.
  virtual bool measure(MeasuredPerson& person) = 0;
  // Why the last measure() failed, if the cause is a damaged file and not the accumulated frames. Else null.
  virtual const Error* fault() const { return nullptr; }
  // With Turn::around and walk, from turn() on: the next picture of the person who turns. False: too little is seen.
  struct TurnFrame {
    DepthView depth;
    MaskView mask;
    Intrinsics intrinsics;
    std::optional<hal::CameraPose> pose;  // with Turn::walk
    FloorPlane floor;                     // the mean of some frames up to this one
  };
  virtual bool follow(const TurnFrame& /*frame*/) { return false; }
  // The farthest that the person has turned, + to the own left.
  virtual float turned_deg() const { return 0; }
  // Keeps the accumulated frames as the front and accumulates the back from now on; measure() then measures both.
  // Called only with EngineSettings::turn. False: this person cannot be measured from more sides than the front.
  virtual bool turn() = 0;
  // Forgets the back: measure() and frame_count() mean the front alone again, until turn() begins the back anew.
  virtual void drop_back() = 0;
  virtual void reset_fit() = 0;  // forgets both sides
  // The front's.
  virtual ImageView<const std::uint16_t> fused_depth_q4() const = 0;
  virtual MaskView fused_mask() const = 0;
};

Result<std::unique_ptr<Engine>> create_engine(const EngineSettings& settings, std::unique_ptr<FrameStages> stages);

// The engine's settings that the stages need.
struct StageOptions {
  Turn turn = Turn::none;
  ClothingGiven clothing = ClothingGiven::unknown;
  const body::ShapeSpace* shape_space = nullptr;
  const body::BodyModel* body = nullptr;  // with Turn::around and walk
  SensorKind sensor = SensorKind::unknown;
};
// PersonDetector, Fuser and Index. Model, index and space must outlive the stages.
Result<std::unique_ptr<FrameStages>> make_production_stages(int width, int height, const JointModel& joint_model,
                                                            const index::Index& index,
                                                            const StageOptions& options = {});

}  // namespace im2fit
