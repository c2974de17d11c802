// SPDX-License-Identifier: Apache-2.0
// Stages that read what they "see" from the first pixels of a frame, so that a test writes the whole story of a
// session as frames. The answer is an exact function of the frames accumulated, worked out again by the tests. With
// both sides it is the front's value plus a hundredth of the back's.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "engine/frame_stages.h"

namespace im2fit::test {

inline constexpr int kWidth = 16;
inline constexpr int kHeight = 12;

// One frame of a story.
struct Shot {
  bool found = true;
  GuidanceSet guidance = 0;
  bool refused = false;  // the fuser answers MOVING
  bool psi = false;
  std::uint16_t value = 1000;
  int user = 1;
  ViewSide view = ViewSide::front;
  int shift_mm = 0;  // of all joints, sideways
  ArmSet arms_close = 0;
};

struct FramePixels {
  explicit FramePixels(const Shot& shot) : pixels(kWidth * kHeight, shot.value) {
    pixels[0] = shot.found;
    pixels[1] = static_cast<std::uint16_t>(shot.guidance);
    pixels[2] = shot.refused;
    pixels[3] = shot.psi;
    pixels[4] = static_cast<std::uint16_t>(shot.user);
    pixels[6] = static_cast<std::uint16_t>(shot.view);
    pixels[7] = static_cast<std::uint16_t>(shot.shift_mm);
    pixels[8] = static_cast<std::uint16_t>(shot.arms_close);
  }
  DepthView view() const { return {pixels.data(), kWidth, kHeight}; }
  std::vector<std::uint16_t> pixels;
};

inline JointSet standing_joints(bool psi) {
  JointSet joints;
  joints.confidence.fill(0.9F);
  const float hand = psi ? -250.0F : 250.0F;  // y is down
  const float elbow = psi ? 0.0F : 250.0F;
  joints[Joint::LS] = {180, -400, 2000};
  joints[Joint::RS] = {-180, -400, 2000};
  joints[Joint::LE] = {460, -400 + elbow, 2000};
  joints[Joint::RE] = {-460, -400 + elbow, 2000};
  joints[Joint::LA] = {470, -400 + elbow + hand, 2000};
  joints[Joint::RA] = {-470, -400 + elbow + hand, 2000};
  joints[Joint::LH] = {90, 100, 2000};
  joints[Joint::RH] = {-90, 100, 2000};
  return joints;
}

class FakeStages : public FrameStages {
 public:
  struct Control {
    std::atomic<int> downs{0};  // how often set_down was called, and the last one
    std::atomic<float> down_y{0};
    std::atomic<int> sense_calls{0};
    std::atomic<int> measure_calls{0};
    std::atomic<int> sense_delay_us{0};
    std::atomic<int> fit_delay_us{0};
    std::atomic<bool> describable{true};
    std::atomic<bool> back_describable{true};
    std::atomic<bool> turns{true};                   // false: the person cannot be measured from more sides
    std::atomic<bool> damaged{false};                // the index, where the person measured would read it
    std::atomic<GuidanceSet> refused{0}, beside{0};  // what the measurement is found to be
    std::atomic<float> front_x{-1};                  // where the camera was of the frame added last; -1: not told
    std::atomic<float> follow_x{-1};                 // the same of the picture followed last
  };
  explicit FakeStages(Control& control) : control_(control) {}

  PersonTracker& people() override { return people_; }
  // The person is found when selected by id, or when any person is wanted.
  Detection sense(DepthView depth, const Intrinsics&, MaskImage mask, float) override {
    ++control_.sense_calls;
    pause(control_.sense_delay_us);
    Detection detection;
    detection.person.found = depth.at(0, 0) != 0 && (people_.selected() == 0 || people_.selected() == depth.at(4, 0));
    detection.person.id = detection.person.found ? depth.at(4, 0) : 0;
    // All people in view: the one selected or not.
    if (depth.at(0, 0) != 0) {
      detection.user_count = 1;
      detection.users[0].id = depth.at(4, 0);
      detection.users[0].u_max = kWidth - 1;
      detection.users[0].centroid_mm = {0, 0, 2000};
    }
    detection.view = static_cast<ViewSide>(depth.at(6, 0));
    detection.person.centroid_mm = {static_cast<float>(depth.at(7, 0)), 0, 2000};
    detection.person.floor = {true, {0, -1, 0}, 900};
    detection.guidance = depth.at(1, 0);
    detection.arms_close = depth.at(8, 0);
    detection.joints = standing_joints(depth.at(3, 0) != 0);
    detection.joints[Joint::HE] = {static_cast<float>(sense_state_++), 0, depth.at(5, 5) * 1.0F};
    for (Vec3f& p : detection.joints.position_mm) p.x += static_cast<float>(depth.at(7, 0));
    for (int v = 0; v < mask.height; ++v)
      for (int u = 0; u < mask.width; ++u) mask.at(u, v) = depth.at(u, v) % 2 == 0 ? 255 : 0;
    return detection;
  }
  void set_down(Vec3f down) override {
    ++control_.downs;
    control_.down_y = down.y;
  }
  void reset_sense() override {
    sense_state_ = 0;
    people_.reset();
  }

  GuidanceSet add(DepthView depth, MaskView mask, const Intrinsics&, const Detection& detection) override {
    pause(control_.fit_delay_us);
    if (depth.at(2, 0) != 0) return static_cast<GuidanceSet>(Guidance::moving);
    Side& side = turned_ ? back_ : front_;
    ++side.frame_count;
    side.sum += depth.at(5, 5) * static_cast<double>(side.frame_count) + mask.at(5, 5);
    if (!turned_) joints_ = detection.joints;
    return 0;
  }
  void set_pose(const std::optional<hal::CameraPose>& pose) override {
    control_.front_x = pose ? pose->position_mm.x : -1;
  }
  // A shot's value is how far the person has turned.
  bool follow(const TurnFrame& frame) override {
    if (!turned_) return false;
    ++back_.frame_count;
    turned_deg_ = frame.depth.at(5, 5);
    control_.follow_x = frame.pose ? frame.pose->position_mm.x : -1;
    return true;
  }
  float turned_deg() const override { return turned_deg_; }
  int frame_count() const override { return turned_ ? back_.frame_count : front_.frame_count; }
  bool measure(MeasuredPerson& person) override {
    ++control_.measure_calls;
    fault_.reset();
    if (control_.damaged) {
      fault_ = Error{ErrorCode::corrupt, "people.i2f: section 'code' damaged"};
      return false;
    }
    if (!control_.describable || (turned_ && !control_.back_describable)) return false;
    const double sum = front_.sum + (turned_ ? back_.sum / 100 : 0);
    for (std::size_t i = 0; i < kMeasurementCount; ++i) {
      const float value = static_cast<float>(sum) + static_cast<float>(i);
      person.answer.measurements[i] = {value, value - 10, value + 10};
      person.paper[i] = value + 0.5F;
    }
    person.plausibility.refused = control_.refused;
    person.plausibility.beside = control_.beside;
    person.around = turned_ && turned_deg_ >= kTurnEnoughDeg;
    person.answer.female = 0.25F;
    person.age = {{40, 20, 70}, {0.125F, 0.5F, 0.25F, 0.125F}};
    person.answer.nearest = 7;
    person.answer.nearest_distance = 1.5F;
    person.joints = joints_;
    person.floor = {true, {0, -1, 0}, 900};
    return true;
  }
  const Error* fault() const override { return fault_ ? &*fault_ : nullptr; }
  bool turn() override {
    turned_ = control_.turns;
    turned_deg_ = 0;
    back_ = {};
    return turned_;
  }
  void drop_back() override { turned_ = false; }
  void reset_fit() override {
    turned_ = false;
    front_ = {};
  }
  ImageView<const std::uint16_t> fused_depth_q4() const override { return {&fused_, 1, 1}; }
  MaskView fused_mask() const override { return {&fused_mask_, 1, 1}; }

 private:
  static void pause(int us) {
    if (us > 0) std::this_thread::sleep_for(std::chrono::microseconds(us));
  }
  Control& control_;
  int sense_state_ = 0;
  PersonTracker people_;
  struct Side {
    int frame_count = 0;
    double sum = 0;
  };
  Side front_, back_;
  bool turned_ = false;
  float turned_deg_ = 0;  // around
  std::optional<Error> fault_;
  JointSet joints_;
  std::uint16_t fused_ = 16;
  std::uint8_t fused_mask_ = 255;
};

inline EngineSettings small_settings() {
  EngineSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.intrinsics = {kWidth, kHeight, 14.0F, 14.0F, 7.5F, 5.5F};
  settings.frames_wanted = 10;
  settings.frames_min = 3;
  return settings;
}

}  // namespace im2fit::test
