// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::apps {

// Runs a program found on PATH and waits. Its standard output is returned, its standard error goes to ours.
// Errors: not_found (no such program), io (it ended with another code than 0).
Result<std::string> run_child(const std::vector<std::string>& words);

}  // namespace im2fit::apps
