// SPDX-License-Identifier: Apache-2.0
#include "engine/pump.h"

#include <string>

#include "engine/engine.h"

namespace im2fit {
namespace {

constexpr int kWaitMs = 250;

}  // namespace

Result<Pumped> pump(hal::Source& source, FrameSink& sink, int timeout_ms) {
  const auto place = sink.acquire();
  if (!place) return place.error();
  const Intrinsics& k = source.info().intrinsics;
  if (place->width != k.width || place->height != k.height)
    return Error{ErrorCode::invalid_argument, source.info().uri + ": frames are " + std::to_string(k.width) + "x" +
                                                  std::to_string(k.height) + ", expected " +
                                                  std::to_string(place->width) + "x" + std::to_string(place->height)};
  auto info = source.next(*place, timeout_ms);
  if (info) {
    info->down = hal::down_of(source, *info);
    if (auto taken = sink.commit(*info); !taken) return taken.error();
    return Pumped::frame;
  }
  switch (info.error().code) {
    case ErrorCode::end_of_stream:
      return Pumped::end;
    case ErrorCode::corrupt:
      return Pumped::damaged;
    case ErrorCode::timeout:
      return Pumped::waiting;
    default:
      return info.error();
  }
}

Status pump_all(hal::Source& source, FrameSink& sink, const std::function<bool()>& go_on) {
  for (int silent_ms = 0;;) {
    const auto pumped = pump(source, sink, kWaitMs);
    if (!pumped) return pumped.error();
    if (*pumped == Pumped::end) return Ok{};
    if (*pumped == Pumped::damaged) continue;
    if (*pumped == Pumped::waiting) {
      silent_ms = source.lost() ? 0 : silent_ms + kWaitMs;
      if (silent_ms >= kFrameGapMsMax)
        return Error{ErrorCode::timeout, source.info().uri + ": no frame for " +
                                             std::to_string(kFrameGapMsMax / 1000) +
                                             " s; is the camera still connected?"};
      continue;
    }
    silent_ms = 0;
    if (!go_on()) return Ok{};
  }
}

Status run(Engine& engine, hal::Source& source, bool stop_when_measured) {
  return run(engine, source, [&] { return !(stop_when_measured && engine.result().measured); });
}

Status run(Engine& engine, hal::Source& source, const std::function<bool()>& go_on) {
  if (auto started = source.start(); !started) return started;
  Status status = pump_all(source, engine, go_on);
  source.stop();
  engine.finish();
  return status ? engine.fault() : status;
}

}  // namespace im2fit
