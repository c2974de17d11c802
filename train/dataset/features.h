// SPDX-License-Identifier: Apache-2.0
// A rendered person through the device's own path: frames -> upright -> PersonDetector -> Fuser -> feature. Never a
// shortcut from the mesh. One difference: the person stands still while a capture is taken, so the PersonDetector
// runs once, on the median of the frames, and not on each.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "body/model.h"
#include "perception/observe/observe.h"
#include "train/camera/virtual_camera.h"
#include "train/index/sample.h"

namespace im2fit::lab {

// One person standing still (SceneOptions::sway is ignored) before one camera for a few frames.
struct CaptureOptions {
  SceneOptions scene;
  SensorOptions sensor;
  Intrinsics intrinsics;  // as the sensor delivers, landscape
  int frame_count = 10;   // accepted frames wanted
  std::uint64_t seed = 0;
};

struct Capture {
  bool valid = false;                         // at least kCaptureFramesMin frames were accepted and described
  int frame_count = 0;                        // accepted
  int frames_seen = 0;                        // of which the median was sensed
  std::array<int, kGuidanceCount> refused{};  // frames, by guidance code
  JointSet joints;
  FloorPlane floor;
  int distance_mm = 0;  // as the device sees it
  PaperMeasurements paper;
  Feature feature{};
};
inline constexpr int kCaptureFramesMin = 3;

// Processor seconds spent, to see which part is slow.
struct CaptureCost {
  double draw = 0;    // subject: shape, exact stature and weight, truth
  double scene = 0;   // pose, skin, rasterise
  double render = 0;  // frames: noise and turning upright
  double sense = 0;   // segmentation and joints
  double fuse = 0;
  double describe = 0;  // FPFH and profile
  double fit = 0;       // shape, of one view and of two
  CaptureCost& operator+=(const CaptureCost& o);
  double sum() const { return draw + scene + render + sense + fuse + describe + fit; }
};

// Not shareable between threads; the models must outlive it.
class CaptureRig {
 public:
  CaptureRig(const body::BodyModel& model, const JointModel& joint_model);
  ~CaptureRig();
  // Depends on the subject and the options only. The result is valid until the next call. `rest`: the subject's rest
  // mesh (morph_subject) where the caller has it.
  const Capture& run(const Subject& subject, const CaptureOptions& options, std::span<const Vec3f> rest = {});
  // What the last run fused, for other descriptors of the same frames; null before the first run.
  const Fuser* fused() const;
  // The last run was valid and of the front: keeps it, to be seen together with a run from behind.
  void keep_front();
  // After keep_front() and a valid run of the back: shapes fitted to the front and to both, as index::Sample has
  // them. Empty when the body file has no shape space or a fit failed.
  struct Fits {
    std::vector<float> front, both;
    FitLayout layout;  // of either
  };
  Fits fit_both();
  CaptureCost cost;

 private:
  struct Station;  // sensor, fuser and buffers of one upright size
  struct Kept;     // a fused view
  void keep(Kept& kept) const;
  Station& station(int width, int height);
  void shoot(Station& at, VirtualScene& scene, const CaptureOptions& options);
  VirtualScene& stage(const Subject& subject, const CaptureOptions& options, std::span<const Vec3f> rest);
  const body::BodyModel& model_;
  const JointModel& joint_model_;
  std::vector<std::unique_ptr<Station>> stations_;
  const Station* last_ = nullptr;
  std::vector<VirtualScene> scenes_;  // one of each picture size, staged anew for every capture
  std::vector<std::uint16_t> delivered_;
  Capture capture_;
  Intrinsics upright_;  // of the last run
  std::unique_ptr<Kept> front_, back_;
  std::unique_ptr<body::ShapeFitter> fitter_;
};

// How people stand before cameras when an index is trained: distances, mountings, rooms, poses, frames, devices.
struct CaptureVariety {
  int frames_min = 3;  // accepted frames: mostly the least, each two more a third as often, up to the most
  int frames_max = 9;
  double wide_share = 0.03;       // of captures at 640x480; the others at 320x240
  double landscape_share = 0.35;  // of mountings; the others portrait
  // Of distances: anywhere the device accepts a person who fits into the picture; the others where a person is best
  // seen (camera_place.h).
  double anywhere_share = 0.2;
  double other_sensor_share = 0.1;  // of sensors: half time of flight, half without noise; the others a Kinect
  bool plain = false;               // no furniture: relaxed pose, empty room
};
CaptureOptions draw_capture(const CaptureVariety& variety, std::uint64_t seed, std::uint64_t subject, int capture);

// Groups of perception/observe's feature for IndexBuilder.
std::vector<index::FeatureGroup> feature_groups();

}  // namespace im2fit::lab
