// SPDX-License-Identifier: Apache-2.0
// The garments that can be tried on, their fabrics and the bodies they are cut for (docs/garments.md).
#pragma once

#include <string_view>
#include <vector>

#include "garment/pattern.h"

namespace im2fit {

struct Wardrobe {
  std::vector<body::GarmentPattern> garments;  // their fabrics are among `fabrics`
  std::vector<body::Fabric> fabrics;
  body::CutRegression regression;
  const body::GarmentPattern* garment(std::string_view id) const;  // nullptr: none
  const body::Fabric* fabric(std::string_view id) const;           // nullptr: none
};

// data/garments/*.yaml and data/fabrics/*.yaml, compiled in without their text: the device library reads no YAML.
// person/builtin_wardrobe.inc is made of them by im2fit-lab make wardrobe-table, and a test compares the two.
const Wardrobe& builtin_wardrobe();

}  // namespace im2fit
