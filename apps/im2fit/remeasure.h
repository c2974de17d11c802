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

// As the session was measured, with these models. Errors: of the session, the recording, the models. A recording that
// gives no measurement is no error: `now` then says what was needed.
Result<Remeasured> remeasure(const RemeasureOptions& options);

// Of a measurement of result.json, as the session's form has it: the tape's mean, the height, the weight; none when
// it was not taken.
std::optional<double> taken_by_tape(const sessions::PersonTruth& truth, const std::string& id);

}  // namespace im2fit::apps
