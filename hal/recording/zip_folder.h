// SPDX-License-Identifier: Apache-2.0
// A folder of depth pictures in a .zip, as phones share recordings: unpacked into a temporary folder for as long as
// its source lives.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/folder/depth_folder.h"
#include "hal/source.h"

namespace im2fit::hal {

inline constexpr std::uint64_t kZipBytesMax = std::uint64_t{4} << 30;  // of what is unpacked

// Opens what `open` finds in the folder. Pictures and tables alone are unpacked (.png, .pgm, .csv, .yaml, .json,
// .txt), without the one folder that they may all be in. The folder, which its owner alone can read, is removed with
// the source, after any error, and, where this process is killed, by a shell that waits for its end (not on Android).
// It stays when both are killed at once, with their container, for example. Errors name the archive: corrupt (damage,
// names that lead out of it), unsupported (encrypted, compressed in another way, more or larger files than a
// recording has, zip64, a build without libzip), io (no room), and those of `open`.
Result<std::unique_ptr<Source>> open_zip(
    const std::string& path, const std::function<Result<std::unique_ptr<Source>>(const std::string& folder)>& open);

// The part of open_zip() that writes files: unpacks into `folder`, which is there and empty.
Status unpack_zip(const std::string& path, const std::string& folder);

// The folder that a source reads, also out of an archive; none: it reads something else.
const FolderSource* folder_of(const Source& source);

}  // namespace im2fit::hal
