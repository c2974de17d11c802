// SPDX-License-Identifier: Apache-2.0
// Garments, fabrics and the bodies sizes are cut for, from their text (YAML, docs/garments.md): those shipped, which
// are compiled in, and people's own files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "body/garment/pattern.h"
#include "core/status.h"

namespace im2fit {

// `what` names the file in errors, which also name line and field.
Result<body::GarmentPattern> parse_garment(const std::string& text, const std::string& what);
Result<body::GarmentPattern> load_garment(const std::string& path);
Result<std::vector<body::Fabric>> parse_fabrics(const std::string& text, const std::string& what);
Result<body::CutLaw> parse_cut_law(const std::string& text, const std::string& what);

struct Wardrobe {
  std::vector<body::GarmentPattern> garments;  // their fabrics are among `fabrics`
  std::vector<body::Fabric> fabrics;
  body::CutLaw law;
  const body::GarmentPattern* garment(std::string_view id) const;  // nullptr: none
  const body::Fabric* fabric(std::string_view id) const;           // nullptr: none
};
// data/garments/*.yaml and data/fabrics/*.yaml, compiled in.
const Wardrobe& builtin_wardrobe();

}  // namespace im2fit
