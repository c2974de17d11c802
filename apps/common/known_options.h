// SPDX-License-Identifier: Apache-2.0
// What the person reports of themselves, on the command line.
#pragma once

#include <string>

#include "apps/common/cli.h"
#include "estimate/known_facts.h"

namespace im2fit::apps {

struct KnownOptions {
  float height_mm = 0, weight_kg = 0, weight_lb = 0, age_years = 0;  // 0: not given
  std::string height_ft;                                             // 5'11"; "": not given
  std::string weight_from = "stated";                                // or scale
  std::string sex;                                                   // woman, man; "": not given
};

void add_known_options(cli::App& sub, KnownOptions& options);

// Feet and inches as people write them: 5'11", 5'11, 5' 11.5", 5ft 11in, 6ft. Millimetres; below 0: cannot
// be read.
float millimetres_of_feet(const std::string& text);

// Of options that passed the checks of add_known_options.
KnownFacts known_facts(const KnownOptions& options);

}  // namespace im2fit::apps
