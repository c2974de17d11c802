// SPDX-License-Identifier: Apache-2.0
// From a frame the engine saw to the picture people watch.
#pragma once

#include "engine/engine.h"
#include "report/overlay.h"

namespace im2fit::apps {

// Views into the frame: valid as long as that is.
PreviewInput preview_of(const FrameSeen& frame, const Intrinsics& intrinsics);

}  // namespace im2fit::apps
