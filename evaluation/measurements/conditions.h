// SPDX-License-Identifier: Apache-2.0
// Conditions of an evaluation by name: each word changes one option of those given.
#pragma once

#include <string>
#include <vector>

#include "evaluation/measurements/evaluation.h"

namespace im2fit::lab {

struct Condition {
  std::string name;  // words joined by +, as "clothed+320"
  std::string what;  // for people
  EvaluationOptions options;
};

// `name`: one word or several joined by +. Error: a word that is not known, with those that are.
Result<Condition> condition_of(const std::string& name, const EvaluationOptions& base);

// Error: what the condition shows is not to be had of the family in its options.
Status shown_by_family(const Condition& condition);

// The words, and what each means, a line each.
std::string condition_help();

// The conditions of --all: every word that differs from the plain condition, one at a time.
std::vector<std::string> all_conditions();

}  // namespace im2fit::lab
