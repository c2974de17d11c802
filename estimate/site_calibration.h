// SPDX-License-Identifier: Apache-2.0
// The calibration of one site: corrections of its answers, applied before any other use of them. A file .i2c, written
// by `im2fit-lab calibrate` from sessions with tape values (docs/calibration.md, docs/formats.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/measurement.h"
#include "core/status.h"
#include "index/index.h"

namespace im2fit {

// Of one measurement: value * scale + offset; the interval keeps its shape about the value and is also `width` times
// as wide. mm, kg for the weight.
struct SiteCorrectionRow {
  double scale = 1;
  double offset_men = 0, offset_women = 0;  // weighed by how probable each is
  double width = 1;
};

// For one camera. Plain data.
struct SiteCorrection {
  std::array<SiteCorrectionRow, kMeasurementCount> rows;
  // Values and intervals; nothing else of `answer` changes. No allocation. + - * / of doubles in written order, then
  // rounded to float: the same bits on every machine.
  void apply(index::Answer& answer) const;
};

// Ranges of a file's values. They are wider than a working site needs: an index needs a correction of a hundredth,
// not of a fifth.
inline constexpr double kSiteScaleMin = 0.8, kSiteScaleMax = 1.25;
inline constexpr double kSiteOffsetMaxMm = 200, kSiteOffsetMaxKg = 30;
inline constexpr double kSiteWidthMin = 0.25, kSiteWidthMax = 4;
inline constexpr double kSiteCameraScaleMin = 0.9, kSiteCameraScaleMax = 1.1;
inline constexpr std::uint32_t kSitePeopleMax = 1'000'000;
inline constexpr std::size_t kSiteCamerasMax = 16;
inline constexpr std::size_t kSiteNameBytesMax = 63;
inline constexpr std::size_t kSiteFileBytesMax = 64 * 1024;

struct SiteCalibration {
  struct Camera {
    std::string name;  // hal::SourceInfo::name
    double scale = 1;  // of lengths, beyond the site's; of the weight its cube
  };
  std::string name;                // of the site, UTF-8 without control characters; not empty
  std::uint32_t people = 0;        // behind it
  std::uint32_t index_crc32c = 0;  // of the index file whose answers it corrects; 0: not known
  std::array<SiteCorrectionRow, kMeasurementCount> rows;
  std::array<std::uint32_t, kMeasurementCount> row_people{};  // with a tape value; 0: that row changes nothing
  std::vector<Camera> cameras;
  std::uint32_t crc32c = 0;  // of the file, where it was read from one
  // Whether it is used with the index it was learned with; none: one of the two indexes is unknown. Set by
  // load_measuring_data().
  std::optional<bool> of_this_index = {};

  static Result<SiteCalibration> load(const std::string& path);
  // `what` names the file in errors. Errors: corrupt, naming what is out of range; unsupported, of another version.
  static Result<SiteCalibration> parse(std::span<const std::byte> bytes, const std::string& what);
  // Error: invalid_argument, as parse() would refuse it.
  Result<std::vector<std::byte>> file() const;
  // Of a camera that is not named here: the site's own.
  SiteCorrection for_camera(std::string_view camera) const;
  bool knows_camera(std::string_view camera) const;
};

}  // namespace im2fit
