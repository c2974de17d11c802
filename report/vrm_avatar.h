// SPDX-License-Identifier: Apache-2.0
// The avatar for programs of animators that read VRM 1.0: the .glb with its body in the T-pose at rest, and the names
// of the humanoid bones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "body/export/figure.h"
#include "core/status.h"

namespace im2fit {

bool is_vrm_name(const std::string& path);

// The body without clothes. `figure` is the avatar's. Errors: as make_figure.
Result<std::vector<std::byte>> vrm_of(const body::Avatar& avatar, const body::Figure& figure);

}  // namespace im2fit
