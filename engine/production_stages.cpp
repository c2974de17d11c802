// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "engine/sensing_stages.h"

namespace im2fit {
namespace {

class ProductionStages final : public SensingStages {
 public:
  ProductionStages(int width, int height, const JointModel& joint_model, const index::Index& index, Turn turn)
      : SensingStages(width, height, joint_model, turn), index_(index), scratch_(index.make_scratch()) {}

  bool measure(MeasuredPerson& person) override {
    const View front_view{front().describe(), front().frame_count()};
    if (!front_view.description.valid) return false;
    if (back() == nullptr) {
      person = measure_views(front_view, nullptr);
      return true;
    }
    const View back_view{back()->describe(), back()->frame_count()};
    if (!back_view.description.valid) return false;
    person = measure_views(front_view, &back_view);
    return true;
  }

 private:
  // One side of the person, as fused and described.
  struct View {
    const Fuser::Description& description;
    int frame_count = 0;
  };

  // The answer from the front, and from the back where `back` is not null. The index knows fronts only: it is asked
  // about the front, and the back changes nothing yet.
  MeasuredPerson measure_views(const View& front, [[maybe_unused]] const View* back) {
    const Fuser::Description& described = front.description;
    MeasuredPerson person;
    index::QueryOptions options;
    options.frame_count = front.frame_count;
    person.answer = index_.query(described.feature, options, *scratch_);
    person.paper = to_values(described.paper);
    person.joints = described.joints;
    person.floor = described.floor;
    return person;
  }

  const index::Index& index_;
  std::unique_ptr<index::Index::Scratch, void (*)(index::Index::Scratch*)> scratch_;
};

}  // namespace

Result<std::unique_ptr<FrameStages>> make_production_stages(int width, int height, const JointModel& joint_model,
                                                            const index::Index& index, Turn turn) {
  if (index.feature_size() != kFeatureSize)
    return Error{ErrorCode::unsupported, "the index was built for features of " +
                                             std::to_string(index.feature_size()) + " values, this program makes " +
                                             std::to_string(kFeatureSize) + ": build the index again"};
  return std::unique_ptr<FrameStages>(std::make_unique<ProductionStages>(width, height, joint_model, index, turn));
}

Result<std::unique_ptr<Engine>> Engine::create(const EngineSettings& settings, const JointModel& joint_model,
                                               const index::Index& index) {
  // Sizes are checked before they size anything; create_engine checks the rest.
  if (settings.width < 1 || settings.height < 1 || settings.width > kImageSideMax || settings.height > kImageSideMax)
    return Error{ErrorCode::invalid_argument, "engine frames of " + std::to_string(settings.width) + "x" +
                                                  std::to_string(settings.height) + ": sides are 1 to " +
                                                  std::to_string(kImageSideMax)};
  auto stages = make_production_stages(settings.width, settings.height, joint_model, index, settings.turn);
  if (!stages) return stages.error();
  return create_engine(settings, std::move(*stages));
}

}  // namespace im2fit
