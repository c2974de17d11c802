// SPDX-License-Identifier: Apache-2.0
// The shipped tape, compiled in without its text: the device library reads no YAML.
//
// The definitions are those of data/tape/*.yaml; builtin_tape.inc is made of them by im2fit-lab make tape-table, and
// a test compares the two.
#pragma once

#include "body/tape.h"

namespace im2fit {

const body::Tape& builtin_tape();

// A row of the table keeps at most so many terms of a sum.
inline constexpr std::size_t kBuiltinTapeTermsMax = 4;

}  // namespace im2fit
