// SPDX-License-Identifier: Apache-2.0
// Bodies from which a fit to measurements begins (body/fit/measurement_fit.h): sections start_* of a body file
// (docs/formats-body.md). `im2fit-lab fetch` chooses them (train/population/start_body_picker.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "body/model.h"
#include "core/container.h"
#include "core/measurement.h"
#include "core/status.h"

namespace im2fit::body {

// A column of body/params_vector.h that not every start body has at 0, and the value of one step of it.
struct StartColumn {
  std::uint32_t column = 0;
  float scale = 0;
};

// Views into the file. Men come first.
struct StartBodies {
  std::size_t man_count = 0;                    // 0: the file has no start bodies
  std::size_t modifier_count = 0;               // of the model
  std::span<const StartColumn> columns;         // rising
  std::span<const std::int16_t> steps;          // size() rows of columns.size()
  std::span<const MeasurementValues> measured;  // size(); what the mesh of each measures

  std::size_t size() const { return measured.size(); }
  // Value = step x scale: one rounding, the same bits on every machine. `start` < size(). Allocates.
  Params params(std::size_t start) const;
};

// The start bodies of a parsed body file, checked; none when the file has no section start_about.
Result<StartBodies> read_start_bodies(const ContainerReader& reader, std::size_t modifier_count,
                                      const std::string& what);

struct StartBody {
  Params params;
  MeasurementValues measured{};
};
// The body file `pack` with these in place of the start bodies it had. Refuses what read_start_bodies refuses.
Result<std::vector<std::byte>> with_start_bodies(std::span<const std::byte> pack, std::span<const StartBody> men,
                                                 std::span<const StartBody> women);

}  // namespace im2fit::body
