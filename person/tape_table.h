// SPDX-License-Identifier: Apache-2.0
// A tape as the table that person/builtin_tape.cpp is compiled with.
#pragma once

#include <string>

#include "body/tape.h"
#include "core/status.h"

namespace im2fit {

// The text of builtin_tape.inc. Error: a sum of more terms than a row keeps.
Result<std::string> tape_table(const body::Tape& tape);
// The files of data/tape/ in the order in which they are read. `folder`: that folder.
Result<body::Tape> read_shipped_tape(const std::string& folder);

}  // namespace im2fit
