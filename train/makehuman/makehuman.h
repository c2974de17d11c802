// SPDX-License-Identifier: Apache-2.0
// Workstation only: MakeHuman's data, from the npm package or an upstream checkout, into one compact .i2b.
// Reads data files only; no code of MakeHuman's is used. Facts and traps: docs/makehuman.md.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::body {

// Detects the layout (npm: public/data/targets/targets.bin; upstream: makehuman/data/3dobjs/base.obj or
// data/3dobjs/base.obj) and packs what adults need. `texture_side`: of the skin's texture, pixels. `files_read`: gets
// the paths of all files that were read of a checkout; may be null.
inline constexpr int kTextureSide = 1024;
Result<std::vector<std::byte>> pack_makehuman(const std::string& directory, int texture_side = kTextureSide,
                                              std::vector<std::string>* files_read = nullptr);

// Of eyes, hair and texture as they are drawn now: raised when they look otherwise, so that body files are made
// again.
inline constexpr int kLookVersion = 1;

}  // namespace im2fit::body
