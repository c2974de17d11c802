// SPDX-License-Identifier: Apache-2.0
// Files that a caller has in memory or inside another file (im2fit_data).
#pragma once

#include <cstddef>
#include <vector>

#include "capi/include/im2fit/im2fit.h"
#include "core/status.h"

namespace im2fit::c {

// `field` of the settings names it in errors: "settings.index_data". Errors: invalid_argument for a kind, address,
// size or offset that cannot be; io when the descriptor cannot be read; corrupt when it ends before.
Result<std::vector<std::byte>> bytes_of(const im2fit_data& data, const char* field);

}  // namespace im2fit::c
