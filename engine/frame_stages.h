// SPDX-License-Identifier: Apache-2.0
// The seam between the pipeline (threads, rings, session) and what it runs on frames. Production: Sensor, Fuser and
// Index (engine/production_stages.cpp); tests put their own behind it.
#pragma once

#include <memory>

#include "core/clothing.h"
#include "core/status.h"
#include "engine/engine.h"

namespace im2fit {

// What a session ends with.
struct MeasuredPerson {
  index::Answer answer;
  AgeAnswer age;
  body::SeenBody seen;
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
  virtual int frame_count() const = 0;  // of the side being accumulated: the front until turn(), then the back
  // The expensive step, once a session; with Turn::asked once for the front and once for both. False when what is
  // accumulated cannot be described.
  virtual bool measure(MeasuredPerson& person) = 0;
  // Why the last measure() failed, when it is not for what is accumulated: a file is damaged. Else null.
  virtual const Error* fault() const { return nullptr; }
  // What is accumulated is the front: keep it, accumulate the back from now on; measure() means both. Not called
  // unless EngineSettings::turn asks for it.
  virtual void turn() = 0;
  // Forgets the back: measure() and frame_count() mean the front alone again, until turn() begins the back anew.
  virtual void drop_back() = 0;
  virtual void reset_fit() = 0;  // forgets both sides
  // The front's.
  virtual ImageView<const std::uint16_t> fused_depth_q4() const = 0;
  virtual MaskView fused_mask() const = 0;
};

Result<std::unique_ptr<Engine>> create_engine(const EngineSettings& settings, std::unique_ptr<FrameStages> stages);

// What the stages need of the engine's settings.
struct StageOptions {
  Turn turn = Turn::none;
  ClothingGiven clothing = ClothingGiven::unknown;
  const body::ShapeSpace* shape_space = nullptr;
  SensorKind sensor = SensorKind::unknown;
};
// Sensor, Fuser and Index. Model, index and space must outlive the stages.
Result<std::unique_ptr<FrameStages>> make_production_stages(int width, int height, const JointModel& joint_model,
                                                            const index::Index& index,
                                                            const StageOptions& options = {});

}  // namespace im2fit
