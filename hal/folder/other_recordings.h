// SPDX-License-Identifier: Apache-2.0
// Recordings that are not read: what was found, and the one command that converts it.
#pragma once

#include <optional>
#include <string>

#include "core/status.h"

namespace im2fit::hal {

// A file by its ending: .db3, .mcap, .r3d, videos, single pictures, archives, meshes of other kinds. None: unknown.
std::optional<Error> other_recording(const std::string& path);
// A folder without frames by the files in it or in its depth/: .npy, .raw, .tiff, .exr, videos, pictures under other
// names. None: nothing of these.
std::optional<Error> other_folder(const std::string& path);

}  // namespace im2fit::hal
