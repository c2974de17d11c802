// SPDX-License-Identifier: Apache-2.0
// The references of the kernels: in double or whole numbers, written to be read; they may allocate and use libm. The
// product does not contain them. A kernel's `...WithRef` table is its own table with the reference before it: tests
// and benchmarks walk that one.
#pragma once

#include <array>
#include <cstddef>

#include "kernels/anchors/anchors.h"
#include "kernels/average/average.h"
#include "kernels/blend/blend.h"
#include "kernels/blocks/blocks.h"
#include "kernels/code_bounds/code_bounds.h"
#include "kernels/code_distance/code_distance.h"
#include "kernels/components/links.h"
#include "kernels/contour/contour.h"
#include "kernels/downsample/downsample_box.h"
#include "kernels/floor_sums/floor_sums.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/mean/mean.h"
#include "kernels/membership/membership.h"
#include "kernels/normals/normals.h"
#include "kernels/sample/sample.h"
#include "kernels/section/section.h"
#include "kernels/silhouette/silhouette.h"
#include "kernels/skin/skin.h"
#include "kernels/trees/trees.h"
#include "kernels/unpack11/unpack11.h"
#include "kernels/unproject/unproject.h"

namespace im2fit {

template <class Function, std::size_t kCount>
constexpr std::array<KernelVariant<Function>, kCount + 1> with_ref(
    Function* ref, const KernelVariant<Function> (&variants)[kCount]) {
  std::array<KernelVariant<Function>, kCount + 1> all{{{"ref", ref, Tier::ref}}};
  for (std::size_t i = 0; i < kCount; ++i) all[i + 1] = variants[i];
  return all;
}

AverageFunction average_ref;
inline constexpr auto kAverageWithRef = with_ref(average_ref, kAverageKernels);
BlendFunction blend_ref;
inline constexpr auto kBlendWithRef = with_ref(blend_ref, kBlendKernels);
BlocksFunction blocks_ref;
inline constexpr auto kBlocksWithRef = with_ref(blocks_ref, kBlocksKernels);
CodeBoundsFunction code_bounds_ref;
inline constexpr auto kCodeBoundsWithRef = with_ref(code_bounds_ref, kCodeBoundsKernels);
CodeDistanceFunction code_distance_ref;
inline constexpr auto kCodeDistanceWithRef = with_ref(code_distance_ref, kCodeDistanceKernels);
ContourFunction contour_ref;
inline constexpr auto kContourWithRef = with_ref(contour_ref, kContourKernels);
FloorSumsFunction floor_sums_ref;
inline constexpr auto kFloorSumsWithRef = with_ref(floor_sums_ref, kFloorSumsKernels);
FpfhFunction fpfh_ref;
inline constexpr auto kFpfhWithRef = with_ref(fpfh_ref, kFpfhKernels);
LinksFunction links_ref;
inline constexpr auto kLinksWithRef = with_ref(links_ref, kLinksKernels);
MeanFunction mean_ref;
inline constexpr auto kMeanWithRef = with_ref(mean_ref, kMeanKernels);
MembershipFunction membership_ref;
inline constexpr auto kMembershipWithRef = with_ref(membership_ref, kMembershipKernels);
NormalsFunction normals_ref;
inline constexpr auto kNormalsWithRef = with_ref(normals_ref, kNormalsKernels);
SampleFunction sample_ref;
inline constexpr auto kSampleWithRef = with_ref(sample_ref, kSampleKernels);
SectionFunction section_ref;
inline constexpr auto kSectionWithRef = with_ref(section_ref, kSectionKernels);
SilhouetteFunction silhouette_ref;
inline constexpr auto kSilhouetteWithRef = with_ref(silhouette_ref, kSilhouetteKernels);
SkinFunction skin_ref;
inline constexpr auto kSkinWithRef = with_ref(skin_ref, kSkinKernels);
Unpack11Function unpack11_ref;
inline constexpr auto kUnpack11WithRef = with_ref(unpack11_ref, kUnpack11Kernels);
UnprojectFunction unproject_ref;
inline constexpr auto kUnprojectWithRef = with_ref(unproject_ref, kUnprojectKernels);

namespace joints {

AnchorDepthsFunction anchor_depths_ref;
inline constexpr auto kAnchorDepthsWithRef = with_ref(anchor_depths_ref, kAnchorDepthsKernels);
DownsampleBoxFunction downsample_box_ref;
inline constexpr auto kDownsampleBoxWithRef = with_ref(downsample_box_ref, kDownsampleBoxKernels);
SumLeavesFunction sum_leaves_ref;
inline constexpr auto kSumLeavesWithRef = with_ref(sum_leaves_ref, kSumLeavesKernels);

}  // namespace joints
}  // namespace im2fit
