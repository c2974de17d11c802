// SPDX-License-Identifier: Apache-2.0
// Whether an engine can be made of its settings.
#pragma once

#include "core/status.h"
#include "engine/engine.h"

namespace im2fit {

// Error: invalid_argument naming the setting, its value and what is expected.
Status check_settings(const EngineSettings& settings);

}  // namespace im2fit
