// SPDX-License-Identifier: Apache-2.0
// How answers from frames with restored edges (perception/observe/edge_restorer.h) are corrected: what a driver has
// done to edges does not come back whole.
#pragma once

#include "estimate/site_calibration.h"

namespace im2fit {

// `pixel_mm`: a pixel's width at the person; the correction grows with it.
SiteCorrection restored_edges_correction(float pixel_mm);

}  // namespace im2fit
