// SPDX-License-Identifier: Apache-2.0
// What a person reports of themselves, as JSON: the page's optional form, and clients of im2fitd. Personal data: no
// error repeats a value.
#pragma once

#include <string_view>

#include "core/status.h"
#include "estimate/known_facts.h"

namespace im2fit::apps {

// {"height_mm": 1700, "weight_kg": 70, "weight_from": "scale", "sex": "woman", "age": 35}; every field is optional.
// weight_from: scale or stated (the default). age: completed years, 1..119. Errors: invalid_argument, naming the
// field and what is expected.
Result<KnownFacts> facts_of_form(std::string_view body);

}  // namespace im2fit::apps
