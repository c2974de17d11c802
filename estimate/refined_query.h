// SPDX-License-Identifier: Apache-2.0
// The index queried with all data of a person: features of the sides, and the shapes fitted to them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "body/fit/shape_fitter.h"
#include "estimate/age.h"
#include "estimate/plausibility.h"
#include "index/index.h"
#include "perception/observe/observe.h"

namespace im2fit {

// One caller at a time. No allocation after construction.
class RefinedQuery {
 public:
  // `space`: of the body file; null, or another than the index was made with: the front's feature answers alone.
  // `clothing`: dressed needs an index that knows such people, and its space. Index and space must outlive this.
  RefinedQuery(const index::Index& index, const body::ShapeSpace* space, ClothingGiven clothing);
  // Whether shapes can be fitted for this index.
  static bool fits(const index::Index& index, const body::ShapeSpace* space);

  // A side that was accumulated and described.
  struct Side {
    const Fuser& fuser;
    const Fuser::Description& description;
  };
  struct Queried {
    index::Answer answer;
    AgeAnswer age;
    // Of both sides where they could be fitted, else of the front. Not valid with an unknown floor: then the fit's
    // axes differ from those of a caller that knows the floor.
    body::SeenBody seen;
    FittedStance stance;  // of the front
  };
  // Some tens of milliseconds with a shape space, for each side.
  // Errors: the index is damaged where it was read.
  Result<Queried> query(const Side& front, const std::optional<Side>& back);
  bool refines() const { return fitter_ != nullptr; }

 private:
  using FitValues = std::array<float, body::kFitValueMax>;
  std::span<const float> values_of(const body::ShapeFit& fit, FitValues& out) const;
  std::span<const float> unknown_fit();
  FittedStance stance(const body::ShapeFit& front, const FloorPlane& floor);
  Result<AgeAnswer> age_of(const index::Seen& seen);
  Result<Queried> queried(index::Seen seen, const index::QueryOptions& options);

  const index::Index& index_;
  const body::ShapeSpace* space_;
  const ClothingGiven clothing_;
  std::unique_ptr<index::Index::Scratch, void (*)(index::Index::Scratch*)> scratch_;
  std::unique_ptr<body::ShapeFitter> fitter_;
  std::vector<Vec3f> points_;  // of a fit
  // Of a fit to the front, and to both sides; not a number where the index wants a fit and there is none.
  FitValues front_fit_{}, both_fit_{};
  static constexpr std::size_t kAlikeMax = 256;
  std::array<std::uint32_t, kAlikeMax> alike_{};
  std::array<float, kAlikeMax> ages_{};
};

}  // namespace im2fit
