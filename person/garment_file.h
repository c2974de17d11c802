// SPDX-License-Identifier: Apache-2.0
// Parses garments, fabrics and the bodies sizes are cut for (YAML, docs/garments.md): users' own files, and the
// shipped ones, from which person/builtin_wardrobe.inc is generated.
#pragma once

#include <string>
#include <vector>

#include "core/status.h"
#include "garment/pattern.h"
#include "person/wardrobe.h"

namespace im2fit {

// `what` names the file in errors, which also name line and field.
Result<body::GarmentPattern> parse_garment(const std::string& text, const std::string& what);
Result<body::GarmentPattern> load_garment(const std::string& path);
Result<std::vector<body::Fabric>> parse_fabrics(const std::string& text, const std::string& what);
Result<body::CutRegression> parse_cut_regression(const std::string& text, const std::string& what);

// The files of data/garments and data/fabrics, by name in the order of their letters. `folder`: that of both.
Result<Wardrobe> read_shipped_wardrobe(const std::string& folder);
// The text of person/builtin_wardrobe.inc.
std::string wardrobe_table(const Wardrobe& wardrobe);

}  // namespace im2fit
