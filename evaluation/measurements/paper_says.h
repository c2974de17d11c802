// SPDX-License-Identifier: Apache-2.0
// What the paper states of its own results (paper/im2fit.tex, section 4), to stand beside ours. Its people are real
// and 83, ours are synthetic: the figures are not of one experiment.
#pragma once

namespace im2fit::lab {

inline constexpr int kPaperPeople = 83;
inline constexpr double kPaperStatureMaeMm = 18.7;  // "overall mean estimation error 1.87 cm", clothed
inline constexpr double kPaperSexRight = 1.0;       // all 83
inline constexpr double kPaperSizeRight = 0.875;    // of T-shirts
inline constexpr double kPaperIcpMm = 90;           // "below 9 centimeters" after
inline constexpr int kPaperIcpIterations = 6;       // of four people
inline constexpr double kPaperModels = 50'000;      // one query of these takes
inline constexpr double kPaperQueryMs = 800;        // on a Xeon E5507
inline constexpr double kPaperModelsMost = 5e6;     // "less than 0.5 seconds for a single query" of these
inline constexpr double kPaperQueryMostMs = 500;

}  // namespace im2fit::lab
