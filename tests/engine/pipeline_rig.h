// SPDX-License-Identifier: Apache-2.0
// An engine on fake stages, fed shot by shot.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "engine/engine.h"
#include "fake_stages.h"

namespace im2fit::test {

inline constexpr GuidanceSet kTooNear = static_cast<GuidanceSet>(Guidance::too_near);
inline constexpr GuidanceSet kStillMoving = static_cast<GuidanceSet>(Guidance::moving);

struct Rig {
  explicit Rig(const EngineSettings& settings) {
    auto made = create_engine(settings, std::make_unique<FakeStages>(control));
    EXPECT_TRUE(made) << made.error().message;
    engine = std::move(*made);
  }
  void push(const Shot& shot, const std::optional<hal::CameraPose>& pose = std::nullopt) {
    hal::FrameInfo info;
    info.sequence = next;
    info.pose = pose;
    info.host_ns = static_cast<std::int64_t>(++next) * period_ns;
    const Status status = engine->push(FramePixels(shot).view(), info);
    EXPECT_TRUE(status);
  }
  FakeStages::Control control;
  std::unique_ptr<Engine> engine;
  std::uint64_t next = 0;
  std::int64_t period_ns = 33333333;
};

inline EngineSettings with(bool single) {
  EngineSettings settings = small_settings();
  settings.single_thread = single;
  return settings;
}

// Cases that hold with one thread (the parameter is true) and with two.
class Threading : public testing::TestWithParam<bool> {};

}  // namespace im2fit::test
