// SPDX-License-Identifier: Apache-2.0
// index inspect, verify and query: inspecting an index that exists.
#pragma once

#include "apps/common/program.h"

namespace im2fit::lab {}

namespace im2fit::apps {

using namespace lab;  // what commands are about

void add_index_inspect(cli::App& index, Command& chosen);

}  // namespace im2fit::apps
