// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "engine/sensing_stages.h"
#include "estimate/refined_query.h"
#include "estimate/restored_edges.h"
#include "estimate/turn_measurement.h"
#include "hal/steady_view.h"
#include "index/clothing_estimate.h"

namespace im2fit {
namespace {

class ProductionStages final : public SensingStages {
 public:
  ProductionStages(int width, int height, const JointModel& joint_model, const index::Index& index,
                   const StageOptions& options)
      : SensingStages(width, height, joint_model, options.turn),
        sensor_(options.sensor),
        turn_(options.turn),
        clothing_(options.clothing),
        query_(index, options.shape_space, options.clothing) {
    if (is_all_round(options.turn)) around_.emplace(*options.body, width, height);
  }

  // After a turn the front is not asked again: it is the same.
  bool measure(MeasuredPerson& person) override {
    fault_.reset();
    if (following_) {
      person = front_person_;
      person.around =
          std::fabs(around_->turned_deg()) >= kTurnEnoughDeg && around_->measure(person.answer, person.seen);
      correct(person.plausibility, person.answer);
      return true;
    }
    const SurroundingsSigns surroundings = front().surroundings();
    const float ground_mm = ground_of(surroundings);  // of both sides: the person stands on one ground
    const Fuser::Description& described = front().describe(sensor_, ground_mm);
    if (!described.valid) return false;
    std::optional<RefinedQuery::Side> behind;
    if (back() != nullptr) {
      behind.emplace(RefinedQuery::Side{*back(), back()->describe(sensor_, ground_mm)});
      if (!behind->description.valid) return false;
    }
    auto answer = query_.query({front(), described}, behind);
    if (!answer) {
      fault_ = answer.error();
      return false;
    }
    person.answer = answer->answer;
    if (edges_restored())
      restored_edges_correction(static_cast<float>(described.distance_mm) / front().intrinsics().fx)
          .apply(person.answer);
    person.age = answer->age;
    person.seen = answer->seen;
    person.paper = to_values(described.paper);
    person.joints = described.joints;
    person.floor = described.floor;
    // The front is judged once: what the back adds must not take its answer away.
    if (back() == nullptr || !front_judged_)
      person.plausibility = judge(surroundings, described, answer->stance);
    else
      person.plausibility = front_person_.plausibility;
    front_judged_ = true;
    front_person_ = person;
    correct(person.plausibility, person.answer);
    return true;
  }

  bool turn() override {
    if (!around_) return SensingStages::turn();
    followed_ = 0;
    // A person in clothes would be measured in the clothes. What edges restored from a blending driver do to an
    // outline seen from the side is not known.
    const MeasuredPerson& p = front_person_;
    following_ =
        !index::looks_dressed(p.answer, clothing_) && !edges_restored() &&
        around_->begin({p.seen, p.joints, p.floor, front().depth_q4(), front().mask(), front().intrinsics()});
    return following_;
  }
  void set_pose(const std::optional<hal::CameraPose>& pose) override { front_pose_ = pose; }
  // A picture whose place is not told cannot be followed from a camera that moves.
  bool follow(const TurnFrame& frame) override {
    if (!following_ || frame.pose.has_value() != front_pose_.has_value()) return false;
    if (turn_ == Turn::walk && !frame.pose) return false;
    std::optional<TurnMeasurement::Camera> camera;
    if (frame.pose) {
      const hal::CameraMotion motion = hal::motion_between(*frame.pose, *front_pose_);
      FloorPlane floor = frame.floor;  // heights count from the ground that the front stood on
      floor.camera_height_mm -= front_person_.plausibility.ground_mm;
      camera = {{motion.turn}, motion.step_mm, floor};
    }
    if (!around_->follow(frame.depth, frame.mask, frame.intrinsics, camera)) return false;
    ++followed_;
    return true;
  }
  float turned_deg() const override { return around_ ? around_->turned_deg() : 0; }
  int frame_count() const override { return following_ ? followed_ : SensingStages::frame_count(); }
  void drop_back() override {
    SensingStages::drop_back();
    stop_following();
  }
  void reset_fit() override {
    SensingStages::reset_fit();
    stop_following();
    front_judged_ = false;
    front_pose_.reset();
  }

  const Error* fault() const override { return fault_ ? &*fault_ : nullptr; }

 private:
  const SensorKind sensor_;
  const Turn turn_;
  const ClothingGiven clothing_;
  RefinedQuery query_;
  std::optional<Error> fault_;

  void stop_following() {
    following_ = false;
    followed_ = 0;
    if (around_) around_->reset();
  }
  // Of Turn::around and walk: the front as measured, and the pictures followed since.
  std::optional<TurnMeasurement> around_;
  bool front_judged_ = false;  // front_person_ is of this session
  MeasuredPerson front_person_;
  std::optional<hal::CameraPose> front_pose_;
  bool following_ = false;
  int followed_ = 0;
};

}  // namespace

Result<std::unique_ptr<FrameStages>> make_production_stages(int width, int height, const JointModel& joint_model,
                                                            const index::Index& index, const StageOptions& options) {
  if (index.feature_size() != kFeatureSize)
    return Error{ErrorCode::unsupported, "the index was built for features of " +
                                             std::to_string(index.feature_size()) + " values, this program makes " +
                                             std::to_string(kFeatureSize) + ": build the index again"};
  if (options.clothing == ClothingGiven::dressed && !index.knows_clothed())
    return Error{
        ErrorCode::unsupported,
        "the index holds no people in clothes: measure without them, or build it again with im2fit-lab index"};
  if (options.clothing == ClothingGiven::dressed && !RefinedQuery::fits(index, options.shape_space))
    return Error{
        ErrorCode::unsupported,
        "people in clothes are measured by a fitted shape, which needs the body file the index was made with"};
  if (is_all_round(options.turn) && (options.body == nullptr || !RefinedQuery::fits(index, options.shape_space)))
    return Error{ErrorCode::invalid_argument,
                 "a turn all round is measured with the body file the index was made with; none is given, or it is "
                 "another"};
  return std::unique_ptr<FrameStages>(std::make_unique<ProductionStages>(width, height, joint_model, index, options));
}

Result<std::unique_ptr<Engine>> Engine::create(const EngineSettings& settings, const JointModel& joint_model,
                                               const index::Index& index) {
  // Sizes are checked before they size anything; create_engine checks the rest.
  if (settings.width < 1 || settings.height < 1 || settings.width > kImageSideMax || settings.height > kImageSideMax)
    return Error{ErrorCode::invalid_argument, "engine frames of " + std::to_string(settings.width) + "x" +
                                                  std::to_string(settings.height) + ": sides are 1 to " +
                                                  std::to_string(kImageSideMax)};
  // Features rest on the joints: what was learned with another tracker is millimetres off and its intervals do not
  // show it.
  if (index.info().tracker_key != 0 && index.info().tracker_key != joint_model.key())
    return Error{ErrorCode::invalid_argument,
                 "the index was made with another tracker than this one and would measure people wrong; take the two "
                 "that were made together, or make the index again with this tracker (im2fit-lab index --tracker)"};
  auto stages = make_production_stages(
      settings.width, settings.height, joint_model, index,
      {settings.turn, settings.clothing, settings.shape_space, settings.body, settings.sensor});
  if (!stages) return stages.error();
  return create_engine(settings, std::move(*stages));
}

}  // namespace im2fit
