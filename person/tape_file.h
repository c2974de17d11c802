// SPDX-License-Identifier: Apache-2.0
// A tape from its text (YAML, docs/tape.md). The shipped one is compiled in: person/builtin_tape.h.
#pragma once

#include <string>
#include <vector>

#include "body/tape.h"
#include "core/status.h"

namespace im2fit {

// `onto`: the tape that the text may refer to and is added to. `what` names the file in errors, which also name line
// and field. Either all of the text is taken or none.
Result<body::Tape> parse_tape(const std::string& text, const std::string& what, body::Tape onto = {});
Result<body::Tape> load_tape(const std::string& path, body::Tape onto);
// The shipped tape and users' own files; each file may refer to the ones before it.
Result<body::Tape> load_tapes(const std::vector<std::string>& paths);

// A tape as the text of builtin_tape.inc, with which person/builtin_tape.cpp is compiled. Error: a sum of more terms
// than a row keeps.
Result<std::string> tape_table(const body::Tape& tape);
// The files of data/tape/ in the order in which they are read. `folder`: that folder.
Result<body::Tape> read_shipped_tape(const std::string& folder);

}  // namespace im2fit
