// SPDX-License-Identifier: Apache-2.0
// The texts that calibrations come in, each as one tree of names and numbers: YAML and JSON, OpenCV's XML, what
// `rs-enumerate-devices -c` prints, and a bare 3 x 3 matrix.
#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <optional>
#include <string>

#include "core/status.h"

namespace im2fit::hal {

// fx, fy, cx, cy.
using PinholeLens = std::array<double, 4>;

// Of nine numbers [fx 0 cx, 0 fy cy, 0 0 1], row by row or column by column: the zeros show which. None: another
// matrix.
std::optional<PinholeLens> pinhole_lens(const std::array<double, 9>& matrix);
// A text of nine numbers and nothing but separators and brackets between them.
std::optional<std::array<double, 9>> matrix_in(const std::string& text);

// Where the text is what rs-enumerate-devices prints, the tree has one entry of this name: a list of its sections.
inline constexpr const char* kRealSenseSections = "rs-enumerate-devices";
// Where the text is a bare matrix, the tree has this entry.
inline constexpr const char* kBareMatrix = "matrix";

// Throws YAML::Exception for a text that is none of these. Error: corrupt, for damaged XML. `path` names the file.
Result<YAML::Node> calibration_tree(const std::string& text, const std::string& path);

}  // namespace im2fit::hal
