// SPDX-License-Identifier: Apache-2.0
// A session's recording, measured again.
#pragma once

#include <string>

#include "apps/common/events.h"
#include "apps/common/measuring.h"
#include "apps/sessions/record.h"

namespace im2fit::apps {

struct RemeasureOptions {
  std::string root;
  std::string id;
  std::string body = default_body_path(), tracker = default_tracker_path(), index = default_index_path();
  std::string out;  // "": no files
};

struct Remeasured {
  sessions::Record record;
  Json before;  // result.json of the session; null when it has none
  Json now;     // result.json of today
};

// As the session was measured, with these models. Errors: of the session, the recording, the models. A recording
// without a measurement is not an error: `now` then holds the guidance.
Result<Remeasured> remeasure(const RemeasureOptions& options);

}  // namespace im2fit::apps
