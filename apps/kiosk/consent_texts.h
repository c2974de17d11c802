// SPDX-License-Identifier: Apache-2.0
// The texts a person agrees to before they are recorded: those of web/lang/*.json, known by their digest.
#pragma once

#include <string_view>

namespace im2fit::apps {

struct ConsentText {
  const char* language;  // "de"
  const char* version;   // "1"
  const char* sha256;    // of its title and points in UTF-8, a line feed between them
};
const ConsentText* consent_text(std::string_view language);  // null: there is none

}  // namespace im2fit::apps
