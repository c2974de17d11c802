// SPDX-License-Identifier: Apache-2.0
// Programs that im2fit-lab runs: npm, git, tar, sha256sum.
#pragma once

#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::apps {

enum class ChildErrors { shown, hidden };  // what the program writes to its standard error

// Runs a program found on PATH and waits. Its standard output is returned.
// Errors: not_found (no such program), io (it ended with another code than 0).
Result<std::string> run_child(const std::vector<std::string>& words, ChildErrors errors = ChildErrors::shown);

}  // namespace im2fit::apps
