// SPDX-License-Identifier: Apache-2.0
// result.json as the programs write it: result_json.h's, and what the device library has no room for
// (docs/result.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "person/measuring_data.h"
#include "report/result_json.h"

namespace im2fit {

// Measured, with `made_by`, and with `figures` where there is a body. `data`: behind the person.
std::string full_result_json(const PersonMeasurement& person, const MeasuringData& data,
                             const std::optional<ResultTiming>& timing = {});
// Of an index file, or of the one in a pack: the same for the same contents. 0: it cannot be read.
std::uint32_t index_digest(const std::string& path);

}  // namespace im2fit
