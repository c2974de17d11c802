// SPDX-License-Identifier: Apache-2.0
// Where data made once lives: an environment variable, else ${XDG_CACHE_HOME:-~/.cache}/im2fit.
#pragma once

#include <string>

namespace im2fit {

std::string environment(const char* name);  // "" when it is not set
std::string cache_directory();
std::string default_body_path();     // IM2FIT_BODY, else body.i2b
std::string default_tracker_path();  // IM2FIT_TRACKER, else tracker.i2t
std::string default_index_path();    // IM2FIT_INDEX, else index.i2f

}  // namespace im2fit
