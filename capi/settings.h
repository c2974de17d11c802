// SPDX-License-Identifier: Apache-2.0
// What a caller set, held to its ranges before any file is opened.
#pragma once

#include "capi/include/im2fit/im2fit.h"
#include "core/status.h"

namespace im2fit::c {

// Errors: invalid_argument, "settings.FIELD is FOUND, expected ...".
Status check_settings(const im2fit_settings& settings);

}  // namespace im2fit::c
