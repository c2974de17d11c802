// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "engine/sensing_stages.h"

namespace im2fit {
namespace {

class ProductionStages final : public SensingStages {
 public:
  ProductionStages(int width, int height, const JointModel& joint_model, const index::Index& index)
      : SensingStages(width, height, joint_model), index_(index), scratch_(index.make_scratch()) {}

  bool measure(MeasuredPerson& person) override {
    const Fuser::Description& description = fuser().describe();
    if (!description.valid) return false;
    index::QueryOptions options;
    options.frame_count = fuser().frame_count();
    person.answer = index_.query(description.feature, options, *scratch_);
    person.paper = to_values(description.paper);
    person.joints = description.joints;
    person.floor = description.floor;
    return true;
  }

 private:
  const index::Index& index_;
  std::unique_ptr<index::Index::Scratch, void (*)(index::Index::Scratch*)> scratch_;
};

}  // namespace

Result<std::unique_ptr<FrameStages>> make_production_stages(int width, int height, const JointModel& joint_model,
                                                            const index::Index& index) {
  if (index.feature_size() != kFeatureSize)
    return Error{ErrorCode::unsupported, "the index was built for features of " +
                                             std::to_string(index.feature_size()) + " values, this program makes " +
                                             std::to_string(kFeatureSize) + ": build the index again"};
  return std::unique_ptr<FrameStages>(std::make_unique<ProductionStages>(width, height, joint_model, index));
}

Result<std::unique_ptr<Engine>> Engine::create(const EngineSettings& settings, const JointModel& joint_model,
                                               const index::Index& index) {
  // Sizes are checked before they size anything; create_engine checks the rest.
  if (settings.width < 1 || settings.height < 1 || settings.width > kImageSideMax || settings.height > kImageSideMax)
    return Error{ErrorCode::invalid_argument, "engine frames of " + std::to_string(settings.width) + "x" +
                                                  std::to_string(settings.height) + ": sides are 1 to " +
                                                  std::to_string(kImageSideMax)};
  auto stages = make_production_stages(settings.width, settings.height, joint_model, index);
  if (!stages) return stages.error();
  return create_engine(settings, std::move(*stages));
}

}  // namespace im2fit
