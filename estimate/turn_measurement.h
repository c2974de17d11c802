// SPDX-License-Identifier: Apache-2.0
// A person measured all round: the answer of the front, in which what was seen from all sides replaces what was
// inferred. The front gives the start (body, pose, axes); pictures of the turn follow, of a person who turns or from
// a camera that is carried round; some of them, evenly spread over the turn, are kept and fitted together
// (body/fit/turn_fitter.h).
#pragma once

#include <memory>
#include <optional>

#include "body/fit/shape_fitter.h"
#include "body/model.h"
#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/joints.h"
#include "index/index.h"

namespace im2fit {

// One caller at a time. No allocation after construction.
class TurnMeasurement {
 public:
  // `model` must outlive this and have a shape space. Pictures: upright, of this size.
  TurnMeasurement(const body::BodyModel& model, int width, int height);
  ~TurnMeasurement();

  // The front: the body fitted to it, and the fused picture it was fitted to, which must stand until measure().
  // False: no body could be fitted, or the floor is not known; nothing is followed then.
  struct Front {
    const body::SeenBody& seen;
    const JointSet& joints;
    const FloorPlane& floor;
    ImageView<const std::uint16_t> depth_q4;
    MaskView mask;
    Intrinsics intrinsics;
  };
  bool begin(const Front& front);
  void reset();
  // Where a camera that is carried round stands: how its axes become those of the front's camera, and the floor as it
  // sees it, which levels a told pose.
  struct Camera {
    body::Mat3f turn;
    Vec3f step_mm;
    FloorPlane floor;
  };
  // The next picture, ten a second or more; without `camera` from where the front was taken. False: too little of the
  // person is seen; the next one may be better.
  bool follow(DepthView depth, MaskView mask, const Intrinsics& intrinsics,
              const std::optional<Camera>& camera = std::nullopt);
  // The farthest to either side, as the camera sees it, + to the person's left; 0 before begin().
  float turned_deg() const;

  // Fits the kept pictures and puts the girths, stature and weight of the body found, with their intervals, into
  // `answer`, and its shape and pose into `seen`; both are the front's. False, and nothing changed: the fit failed.
  bool measure(index::Answer& answer, body::SeenBody& seen);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace im2fit
