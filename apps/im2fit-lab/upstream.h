// SPDX-License-Identifier: Apache-2.0
// MakeHuman's assets (CC0-1.0) from its repository, or from a mirror of it, by git.
#pragma once

#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::apps {

inline constexpr const char* kUpstreamUrl = "https://github.com/makehumancommunity/makehuman.git";

struct UpstreamCopy {
  std::string directory;  // the checkout: only what train/makehuman may read
  std::string commit;
};
// A shallow copy of the newest commit into a new directory within `scratch`. `repository`: a URL, or the directory
// of a repository. Gives up when the server does not answer within 10 seconds, or sends less than a kilobyte a
// second for 30 seconds. Errors: not_found (git is missing), io (the repository cannot be reached), unsupported (it
// cannot be copied).
Result<UpstreamCopy> clone_upstream(const std::string& repository, const std::string& scratch);

// Whether `files`, in `directory`, are those that this release was tried with. `scratch`: for a list. Error: corrupt.
Status check_upstream(const UpstreamCopy& copy, std::vector<std::string> files, const std::string& scratch);

}  // namespace im2fit::apps
