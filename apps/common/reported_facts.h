// SPDX-License-Identifier: Apache-2.0
// What a page passes to the run behind it.
#pragma once

#include <cstdint>

#include "estimate/known_facts.h"

namespace im2fit::apps {

// Facts of one person; `count` is another each time that they report, and 0 while they have not.
struct ReportedFacts {
  std::uint32_t count = 0;
  KnownFacts facts;
};

}  // namespace im2fit::apps
