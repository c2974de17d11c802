// SPDX-License-Identifier: Apache-2.0
// Judged frames side by side: depth, the mask's outline, the true and the found skeleton, a caption.
#pragma once

#include <string>
#include <vector>

#include "evaluation/tracker/guidance_trials.h"
#include "evaluation/tracker/room_trials.h"
#include "evaluation/tracker/scene_trials.h"
#include "report/canvas.h"

namespace im2fit::lab {

struct SheetCell {
  Canvas picture;
  std::vector<std::string> captions;  // two lines at most are shown
};

// Depth in grey (near is light), the mask's outline in yellow, true bones green; found bones orange (person's left),
// blue (right) and white. True joints of no confidence belong to no person shown.
Canvas draw_judged(const JudgedPicture& picture);

// The frame, its error and its classes; or what was raised.
SheetCell trial_cell(const JudgedPicture& picture, const TrialOutcome& outcome);
SheetCell guidance_cell(const JudgedPicture& picture, const GuidanceOutcome& outcome);

SheetCell room_cell(const JudgedPicture& picture, const RoomOutcome& outcome);

// Five cells a row.
Canvas contact_sheet(const std::vector<SheetCell>& cells);

}  // namespace im2fit::lab
