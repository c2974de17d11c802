// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "engine/engine.h"

namespace im2fit {
namespace {

constexpr int kWaitMs = 250;

Status pull(Engine& engine, hal::Source& source, const std::function<bool()>& go_on) {
  const Intrinsics& k = source.info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const DepthImage depth(pixels.data(), k.width, k.height);
  int gap_ms = 0;
  for (;;) {
    auto info = source.next(depth, kWaitMs);
    if (!info) {
      const ErrorCode code = info.error().code;
      if (code == ErrorCode::end_of_stream) return Ok{};
      if (code == ErrorCode::corrupt) continue;
      if (code != ErrorCode::timeout) return info.error();
      gap_ms = source.lost() ? 0 : gap_ms + kWaitMs;
      if (gap_ms >= kFrameGapMsMax)
        return Error{ErrorCode::timeout, source.info().uri + ": no frame for " +
                                             std::to_string(kFrameGapMsMax / 1000) +
                                             " s; is the camera still connected?"};
      continue;
    }
    gap_ms = 0;
    if (auto pushed = engine.push(depth, *info); !pushed) return pushed;
    if (!go_on()) return Ok{};
  }
}

}  // namespace

Status run(Engine& engine, hal::Source& source, bool stop_when_measured) {
  return run(engine, source, [&] { return !(stop_when_measured && engine.result().measured); });
}

Status run(Engine& engine, hal::Source& source, const std::function<bool()>& go_on) {
  if (auto started = source.start(); !started) return started;
  Status status = pull(engine, source, go_on);
  source.stop();
  engine.finish();
  return status ? engine.fault() : status;
}

}  // namespace im2fit
