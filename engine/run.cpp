// SPDX-License-Identifier: Apache-2.0
#include "engine/engine.h"

namespace im2fit {

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
