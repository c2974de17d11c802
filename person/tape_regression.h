// SPDX-License-Identifier: Apache-2.0
// The uncertainty of a tape measurement, given an answer's intervals of the eleven measurements.
//
// The variance of its logarithm is the sum of two: the eleven's uncertainty, propagated by people's slopes, and the
// part the eleven do not determine, the residual of held-out people's fitted bodies. Both are in tape_regression.inc,
// one row for each measurement and sex, made by im2fit-lab make tape-regression.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "body/tape.h"
#include "index/index.h"

namespace im2fit {

struct TapeInterval {
  bool known = false;  // not: a definition of one's own, of which nothing was measured
  float low = 0, high = 0;
};

// 95 %, a place a definition; the eleven keep the answer's own.
std::vector<TapeInterval> tape_intervals(const body::Tape& tape, std::span<const float> values,
                                         const index::Answer& answer);
// Whether a shipped measurement has its rows, for tests.
bool has_tape_regression(std::string_view id);

}  // namespace im2fit
