// SPDX-License-Identifier: Apache-2.0
#include "estimate/site_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/container.h"
#include "core/crc32c.h"
#include "core/file.h"

namespace im2fit {
namespace {

constexpr std::string_view kMagic = "I2CA";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kNameBytes = kSiteNameBytesMax + 1;  // zeros behind the name, one at least

struct HeadRecord {
  std::uint32_t people, index_crc32c;
  std::array<char, kNameBytes> name;
};
struct RowRecord {
  double scale, offset_men, offset_women, width;
  std::uint32_t people, zero;
};
struct CameraRecord {
  double scale;
  std::array<char, kNameBytes> name;
};
static_assert(sizeof(HeadRecord) == 72 && sizeof(RowRecord) == 40 && sizeof(CameraRecord) == 72);

std::array<char, kNameBytes> padded(const std::string& name) {
  std::array<char, kNameBytes> bytes{};
  std::copy_n(name.begin(), std::min(name.size(), kSiteNameBytesMax), bytes.begin());
  return bytes;
}

// None: not zeros to the end behind it.
std::optional<std::string> name_in(const std::array<char, kNameBytes>& bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), '\0');
  if (end == bytes.end() || std::any_of(end, bytes.end(), [](char c) { return c != '\0'; })) return std::nullopt;
  return std::string(bytes.begin(), end);
}

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= kSiteNameBytesMax && std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
  });
}

bool within(double value, double low, double high) {
  return value >= low && value <= high;  // false of not-a-number
}

std::string out_of_range(const std::string& field, double value, double low, double high) {
  return field + " is " + std::to_string(value) + ", expected " + std::to_string(low) + " to " + std::to_string(high);
}

// "" when a program may measure with it.
std::string fault_of(const SiteCorrectionRow& row, std::uint32_t people, std::size_t m) {
  const std::string id(kMeasurementTable[m].id);
  const double reach = kMeasurementTable[m].unit == "kg" ? kSiteOffsetMaxKg : kSiteOffsetMaxMm;
  if (!within(row.scale, kSiteScaleMin, kSiteScaleMax))
    return out_of_range(id + ".scale", row.scale, kSiteScaleMin, kSiteScaleMax);
  if (!within(row.offset_men, -reach, reach)) return out_of_range(id + ".offset_men", row.offset_men, -reach, reach);
  if (!within(row.offset_women, -reach, reach))
    return out_of_range(id + ".offset_women", row.offset_women, -reach, reach);
  if (!within(row.width, kSiteWidthMin, kSiteWidthMax))
    return out_of_range(id + ".width", row.width, kSiteWidthMin, kSiteWidthMax);
  if (people > kSitePeopleMax) return id + " rests on " + std::to_string(people) + " people";
  if (people == 0 && (row.scale != 1 || row.offset_men != 0 || row.offset_women != 0 || row.width != 1))
    return id + " is corrected without any tape value behind it";
  return "";
}

std::string fault_of(const SiteCalibration& site) {
  if (!is_name(site.name))
    return "the name is not a text of 1 to " + std::to_string(kSiteNameBytesMax) +
           " bytes without control characters";
  if (site.people < 1 || site.people > kSitePeopleMax)
    return "it rests on " + std::to_string(site.people) + " people";
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    if (std::string fault = fault_of(site.rows[m], site.row_people[m], m); !fault.empty()) return fault;
  if (site.cameras.size() > kSiteCamerasMax) return std::to_string(site.cameras.size()) + " cameras";
  for (std::size_t i = 0; i < site.cameras.size(); ++i) {
    const SiteCalibration::Camera& camera = site.cameras[i];
    if (!is_name(camera.name)) return "camera " + std::to_string(i) + " has no name";
    if (!within(camera.scale, kSiteCameraScaleMin, kSiteCameraScaleMax))
      return out_of_range("scale of camera " + camera.name, camera.scale, kSiteCameraScaleMin, kSiteCameraScaleMax);
    for (std::size_t j = 0; j < i; ++j)
      if (site.cameras[j].name == camera.name) return "camera " + camera.name + " appears twice";
  }
  return "";
}

}  // namespace

void SiteCorrection::apply(index::Answer& answer) const {
  const auto female = static_cast<double>(answer.female);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const SiteCorrectionRow& row = rows[m];
    index::IntervalEstimate& e = answer.measurements[m];
    const auto value = static_cast<double>(e.value);
    const double offset = row.offset_men + (row.offset_women - row.offset_men) * female;
    const double corrected = value * row.scale + offset;
    const double widened = row.width * row.scale;
    const double below = (value - static_cast<double>(e.low)) * widened;
    const double above = (static_cast<double>(e.high) - value) * widened;
    e.value = static_cast<float>(corrected);
    e.low = static_cast<float>(corrected - below);
    e.high = static_cast<float>(corrected + above);
  }
}

Result<SiteCalibration> SiteCalibration::load(const std::string& path) {
  const auto bytes = read_file(path, kSiteFileBytesMax);
  if (!bytes) return bytes.error();
  return parse(*bytes, path);
}

Result<SiteCalibration> SiteCalibration::parse(std::span<const std::byte> bytes, const std::string& what) {
  const auto corrupt = [&](const std::string& fault) { return Error{ErrorCode::corrupt, what + ": " + fault}; };
  if (bytes.size() > kSiteFileBytesMax) return corrupt("of " + std::to_string(bytes.size()) + " bytes");
  const auto container = ContainerReader::parse(bytes, kMagic, kVersion, what);
  if (!container) return container.error();
  const auto head = container->array<HeadRecord>("site", 1);
  if (!head) return head.error();
  const auto rows = container->array<RowRecord>("rows", kMeasurementCount);
  if (!rows) return rows.error();
  const auto cameras = container->array<CameraRecord>("cameras");
  if (!cameras) return cameras.error();
  if (cameras->size() > kSiteCamerasMax) return corrupt(std::to_string(cameras->size()) + " cameras");

  SiteCalibration site;
  const auto name = name_in((*head)[0].name);
  if (!name) return corrupt("the name does not end");
  site.name = *name;
  site.people = (*head)[0].people;
  site.index_crc32c = (*head)[0].index_crc32c;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const RowRecord& row = (*rows)[m];
    site.rows[m] = {row.scale, row.offset_men, row.offset_women, row.width};
    site.row_people[m] = row.people;
  }
  for (const CameraRecord& camera : *cameras) {
    const auto camera_name = name_in(camera.name);
    if (!camera_name) return corrupt("a camera's name does not end");
    site.cameras.push_back({*camera_name, camera.scale});
  }
  if (const std::string fault = fault_of(site); !fault.empty()) return corrupt(fault);
  site.crc32c = im2fit::crc32c(bytes);
  return site;
}

Result<std::vector<std::byte>> SiteCalibration::file() const {
  if (const std::string fault = fault_of(*this); !fault.empty())
    return Error{ErrorCode::invalid_argument, "site calibration: " + fault};
  const HeadRecord head{people, index_crc32c, padded(name)};
  std::array<RowRecord, kMeasurementCount> row_records{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    row_records[m] = {rows[m].scale, rows[m].offset_men, rows[m].offset_women, rows[m].width, row_people[m], 0};
  std::vector<CameraRecord> camera_records;
  camera_records.reserve(cameras.size());
  for (const Camera& camera : cameras) camera_records.push_back({camera.scale, padded(camera.name)});
  ContainerWriter writer(kMagic, kVersion);
  writer.add_array<HeadRecord>("site", std::span(&head, 1));
  writer.add_array<RowRecord>("rows", row_records);
  writer.add_array<CameraRecord>("cameras", camera_records);
  return writer.finish();
}

bool SiteCalibration::knows_camera(std::string_view camera) const {
  return std::any_of(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == camera; });
}

SiteCorrection SiteCalibration::for_camera(std::string_view camera) const {
  SiteCorrection correction{rows};
  const auto known = std::find_if(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == camera; });
  if (known == cameras.end()) return correction;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    if (row_people[m] == 0) continue;
    const bool volume = kMeasurementTable[m].unit == "kg";
    correction.rows[m].scale *= volume ? known->scale * known->scale * known->scale : known->scale;
  }
  return correction;
}

}  // namespace im2fit
