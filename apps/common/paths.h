// SPDX-License-Identifier: Apache-2.0
// Where body, tracker and index live. Each has an environment variable, and IM2FIT_MODELS names all three at once: a
// model pack, or a directory. Without these, programs that measure look for a directory that holds all three, so that
// files of two makes are never mixed:
//   ${XDG_DATA_HOME:-~/.local/share}/im2fit              installed by this user (im2fit models install)
//   ${XDG_CACHE_HOME:-~/.cache}/im2fit                   made here (im2fit-lab)
//   ${XDG_DATA_DIRS:-/usr/local/share:/usr/share}/im2fit installed for everybody
// and name the cache when there is none. Programs that make such files write and read the cache alone.
#pragma once

#include <string>
#include <vector>

#include "core/status.h"
#include "formats/model_pack.h"

namespace im2fit {

// In a directory they have the names that they have in a pack.
inline constexpr const char* kBodyFile = kPackedBody;
inline constexpr const char* kTrackerFile = kPackedTracker;
inline constexpr const char* kIndexFile = kPackedIndex;

std::string environment(const char* name);  // "" when it is not set
std::string cache_directory();
std::string user_data_directory();                // where a user's models are installed
std::vector<std::string> model_directories();     // all of the above, in order
bool holds_models(const std::string& directory);  // all three files
std::string model_directory();                    // the first that does, else the cache

// The file of that name among models that are a directory or a pack; a pack stands for all its files.
std::string path_among(const std::string& models, const std::string& file);

// To measure with.
std::string default_body_path();     // IM2FIT_BODY, else of IM2FIT_MODELS, else body.i2b
std::string default_tracker_path();  // IM2FIT_TRACKER, else of IM2FIT_MODELS, else tracker.i2t
std::string default_index_path();    // IM2FIT_INDEX, else of IM2FIT_MODELS, else index.i2f
// Error, not_found: IM2FIT_MODELS is why there is nothing at that path; the message names both.
Status check_named_by_variable(const std::string& path);
// To make, and to make others from.
std::string made_body_path();
std::string made_tracker_path();
std::string made_index_path();

}  // namespace im2fit
