// SPDX-License-Identifier: Apache-2.0
// Sessions on disk as the people a study and a calibration are of.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/sessions/store.h"
#include "evaluation/study/simulated_site.h"
#include "evaluation/study/site_person.h"

namespace im2fit::apps {

struct SitePeople {
  std::vector<lab::SitePerson> people;  // a visit each, the oldest first
  std::vector<std::string> left_out;    // "ID: why": damaged, not measured
  std::string site;                     // of the sessions; "" when they name none or several
  std::vector<std::string> indexes;     // CRC-32C of the indexes that answered, 8 hexadecimal digits, each once
  bool synthetic = false;               // some people are simulated
};

// Answers are those before any site calibration. Errors: io; not_found where there is no session at all.
Result<SitePeople> site_people(const std::string& root);

// Writes a session, without a recording, for each visit that was measured; returns how many. `versions`: of the
// models and programs that answered.
Result<int> write_sessions(const std::string& root, const std::vector<lab::SimulatedVisit>& visits,
                           const std::string& site, const sessions::Versions& versions);

}  // namespace im2fit::apps
