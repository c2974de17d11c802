// SPDX-License-Identifier: Apache-2.0
// What an evaluation's people are put under, by name: each word changes one thing of the options given.
#pragma once

#include <string>
#include <vector>

#include "lab/evaluation/evaluation.h"

namespace im2fit::lab {

struct Condition {
  std::string name;  // words joined by +, as "clothed+320"
  std::string what;  // for people
  EvaluationOptions options;
};

// `name`: one word or several joined by +. Error: a word that is not known, with those that are.
Result<Condition> condition_of(const std::string& name, const EvaluationOptions& base);

// The words, and what each means, a line each.
std::string condition_help();

// What --all runs: every word that says something else than the plain condition does, one at a time.
std::vector<std::string> all_conditions();

}  // namespace im2fit::lab
