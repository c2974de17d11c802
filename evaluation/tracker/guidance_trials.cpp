// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/guidance_trials.h"

#include <array>
#include <memory>
#include <mutex>
#include <optional>

#include "engine/sensing_stages.h"
#include "evaluation/tracker/guidance_scenes.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

// Speeds need 16 frames (perception/observe/motion_filter.h); the codes raised in the last eight count.
constexpr int kFramesShown = 26;
constexpr int kFramesCounted = 8;

// `picture`: of the last frame; may be null.
Result<GuidanceSet> raised_by(const body::BodyModel& model, const JointModel& joint_model, const GuidanceScene& drawn,
                              JudgedPicture* picture) {
  UprightScene scene(model, drawn.subject, drawn.shot);
  EngineSettings settings;
  settings.intrinsics = scene.intrinsics();
  settings.width = settings.intrinsics.width;
  settings.height = settings.intrinsics.height;
  settings.frames_wanted = 2 * kFramesShown;  // never enough: the guidance of every frame is wanted
  settings.single_thread = true;
  if (picture != nullptr)
    settings.watch = [&](const FrameSeen& seen) {
      const auto pixels = static_cast<std::ptrdiff_t>(seen.depth.width) * seen.depth.height;
      picture->intrinsics = settings.intrinsics;
      picture->depth.assign(seen.depth.pixels, seen.depth.pixels + pixels);
      picture->mask.assign(seen.mask.pixels, seen.mask.pixels + pixels);
      picture->found = seen.result.has_joints;
      picture->joints = seen.result.joints;
      picture->truth = scene.truth();
    };
  // As on the device, but for the index: nothing is measured.
  auto engine =
      create_engine(settings, std::make_unique<SensingStages>(settings.width, settings.height, joint_model));
  if (!engine) return engine.error();
  const PropAxes axes(scene.floor(), scene.staged().distance_mm());
  std::array<int, kGuidanceCount> counts{};
  for (int i = 0; i < kFramesShown; ++i) {
    scene.show(static_cast<std::uint64_t>(i));
    draw_props(drawn.props, axes, settings.intrinsics, drawn.shot.seed, static_cast<std::uint64_t>(i), scene.depth());
    spoil(scene.depth(), drawn.lost_share, drawn.shot.seed, static_cast<std::uint64_t>(i));
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = i * 33'333'333LL;
    if (const auto pushed = (*engine)->push(scene.depth(), info); !pushed) return pushed.error();
    if (i < kFramesShown - kFramesCounted) continue;
    const GuidanceSet now = (*engine)->result().guidance;
    for (std::size_t code = 0; code < kGuidanceCount; ++code) counts[code] += (now >> code & 1U) != 0 ? 1 : 0;
  }
  GuidanceSet raised = 0;
  for (std::size_t code = 0; code < kGuidanceCount; ++code)
    if (2 * counts[code] >= kFramesCounted) raised |= 1U << code;
  return raised;
}

}  // namespace

Result<std::vector<GuidanceOutcome>> run_guidance(const body::BodyModel& model, const JointModel& joint_model,
                                                  const GuidanceOptions& options) {
  const std::vector<std::string> kinds = options.kinds.empty() ? guidance_kinds() : options.kinds;
  const auto scenes = static_cast<std::uint64_t>(options.scenes);
  std::vector<GuidanceOutcome> outcomes(kinds.size() * static_cast<std::size_t>(scenes));
  std::mutex mutex;
  std::optional<Error> failure;
  for_each_item(
      outcomes.size(), options.threads,
      [&](std::uint64_t i) {
        GuidanceOutcome& outcome = outcomes[static_cast<std::size_t>(i)];
        outcome.kind = kinds[static_cast<std::size_t>(i / scenes)];
        outcome.scene = i % scenes;
        const auto raised = raised_by(model, joint_model,
                                      draw_guidance_scene(model, outcome.kind, options.seed, outcome.scene), nullptr);
        if (!raised) {
          const std::lock_guard lock(mutex);
          failure = raised.error();
          return;
        }
        const GuidanceRule rule = guidance_rule(outcome.kind);
        outcome.raised = *raised;
        outcome.named = rule.named == 0 || (outcome.raised & rule.named) == rule.named;
        outcome.unrelated = outcome.raised & ~(rule.named | rule.companions);
      },
      begin_progress(options.progress, "guidance scenes", outcomes.size()));
  if (failure) return *failure;
  return outcomes;
}

Result<JudgedPicture> picture_of(const body::BodyModel& model, const JointModel& joint_model,
                                 const GuidanceOptions& options, const GuidanceOutcome& outcome) {
  JudgedPicture picture;
  const auto raised =
      raised_by(model, joint_model, draw_guidance_scene(model, outcome.kind, options.seed, outcome.scene), &picture);
  if (!raised) return raised.error();
  return picture;
}

}  // namespace im2fit::lab
