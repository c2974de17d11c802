// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/pose_rows.h"

#include <algorithm>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <locale>

#include "core/file.h"
#include "formats/csv.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kRowsMax = 1'000'000;          // the frames a folder may have
constexpr std::size_t kTableBytesMax = 192 << 20;    // of kRowsMax rows
constexpr std::uint64_t kSequenceMax = 999'999'999;  // at 30 Hz a year
constexpr double kMmPerMetre = 1000;
constexpr double kPlaceMaxM = 1000;  // as the C interface's
constexpr double kUnitTolerance = 0.01;
constexpr double kRounding = 1e-5;  // of the squared length of a quaternion of floats
constexpr double kTimeMaxS = 4e9;   // the year 2096
constexpr double kFocalMaxPx = 1e5;

constexpr std::size_t kPoseValues = 7;
struct Names {
  const char* sequence;
  std::array<const char*, kPoseValues> values;
};
constexpr Names kPosesNames = {"sequence", {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"}};
constexpr Names kOdometryNames = {"frame", {"x", "y", "z", "qx", "qy", "qz", "qw"}};
constexpr std::array<const char*, 4> kLensNames = {"fx", "fy", "cx", "cy"};

// Columns by the names in the first line, or in the order of the app's first versions, which had no header.
struct PoseColumns {
  std::size_t sequence = SIZE_MAX, time = SIZE_MAX;
  std::array<std::size_t, kPoseValues> values{};
  std::array<std::size_t, 4> lens{};
  bool header = true, has_lens = true;

  static std::size_t find(const std::vector<std::string>& cells, const char* name) {
    const auto it = std::find(cells.begin(), cells.end(), name);
    return it == cells.end() ? SIZE_MAX : static_cast<std::size_t>(it - cells.begin());
  }
};

// The first name that is missing; null: all are there.
const char* find_columns(const std::vector<std::string>& cells, PoseTable table, PoseColumns& columns) {
  const bool odometry = table == PoseTable::odometry_csv;
  const Names& names = odometry ? kOdometryNames : kPosesNames;
  if (double ignored = 0; odometry && cells.size() == kPoseValues && NumberReader().read(cells[0], ignored)) {
    for (std::size_t i = 0; i < kPoseValues; ++i) columns.values[i] = i;
    columns.header = columns.has_lens = false;
    return nullptr;
  }
  columns.sequence = PoseColumns::find(cells, names.sequence);
  if (columns.sequence == SIZE_MAX && !odometry) return names.sequence;
  for (std::size_t i = 0; i < kPoseValues; ++i) {
    columns.values[i] = PoseColumns::find(cells, names.values[i]);
    if (columns.values[i] == SIZE_MAX) return names.values[i];
  }
  columns.has_lens = odometry;
  if (!odometry) return nullptr;
  columns.time = PoseColumns::find(cells, "timestamp");
  for (std::size_t i = 0; i < kLensNames.size(); ++i) {
    columns.lens[i] = PoseColumns::find(cells, kLensNames[i]);
    columns.has_lens = columns.has_lens && columns.lens[i] != SIZE_MAX;
  }
  return nullptr;
}

class RowReader {
 public:
  RowReader(const PoseColumns& columns, const Names& names) : columns_(columns), names_(names) {}

  // What is wrong with the row, or "".
  std::string read(const std::vector<std::string>& cells, PoseRow& row) {
    if (columns_.sequence != SIZE_MAX) {
      const std::string text = cell(cells, columns_.sequence);
      const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), row.sequence);
      if (code != std::errc() || end != text.data() + text.size() || row.sequence > kSequenceMax)
        return std::string(names_.sequence) + " is missing or not a whole number up to " +
               std::to_string(kSequenceMax);
    }
    std::array<double, kPoseValues> v{};
    for (std::size_t i = 0; i < kPoseValues; ++i)
      if (!numbers_.read(cell(cells, columns_.values[i]), v[i]) || !std::isfinite(v[i]))
        return std::string(names_.values[i]) + " is missing or not a number";
    for (std::size_t i = 0; i < 3; ++i)
      if (!(std::abs(v[i]) <= kPlaceMaxM))
        return std::string(names_.values[i]) + " is over a kilometre away; expected metres";
    const double square = v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6];
    double length = std::sqrt(square);
    if (!(std::abs(length - 1) <= kUnitTolerance))
      return "qx, qy, qz, qw have the length " + std::to_string(length) + ", expected a unit quaternion";
    if (std::abs(square - 1) < kRounding) length = 1;
    const auto turn = [&](std::size_t i) { return static_cast<float>(v[i] / length); };
    const auto place_mm = [&](std::size_t i) { return static_cast<float>(v[i] * kMmPerMetre); };
    row.pose = {turn(3), turn(4), turn(5), turn(6), {place_mm(0), place_mm(1), place_mm(2)}};
    if (columns_.time != SIZE_MAX) {
      row.time_s = 0;
      if (!numbers_.read(cell(cells, columns_.time), *row.time_s) || !(*row.time_s >= 0 && *row.time_s <= kTimeMaxS))
        return "timestamp is missing or not a time in seconds";
    }
    return columns_.has_lens ? read_lens(cells, row) : "";
  }

 private:
  static std::string cell(const std::vector<std::string>& cells, std::size_t column) {
    return column < cells.size() ? cells[column] : "";
  }
  std::string read_lens(const std::vector<std::string>& cells, PoseRow& row) {
    row.lens.emplace();
    for (std::size_t i = 0; i < kLensNames.size(); ++i) {
      double value = 0;
      if (!numbers_.read(cell(cells, columns_.lens[i]), value) || !(value > 0 && value < kFocalMaxPx))
        return std::string(kLensNames[i]) + " is missing or not a number of pixels";
      (*row.lens)[i] = static_cast<float>(value);
    }
    return "";
  }

  const PoseColumns& columns_;
  const Names& names_;
  NumberReader numbers_;
};

}  // namespace

NumberReader::NumberReader() {
  stream_.imbue(std::locale::classic());
}

bool NumberReader::read(const std::string& text, double& value) {
  stream_.clear();
  stream_.str(text);
  return (stream_ >> value) && stream_.peek() == std::istringstream::traits_type::eof();
}

Result<std::vector<PoseRow>> read_pose_rows(const std::string& path, PoseTable table) {
  const auto bytes = read_file(path, kTableBytesMax);
  if (!bytes) return bytes.error();
  CsvReader csv({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorCode::corrupt,
                 path + " line " + std::to_string(csv.line()) + ": " + what + "; correct or delete the file"};
  };
  const auto unread = [](Error error) {
    error.message += "; correct or delete the file";
    return error;
  };
  const Names& names = table == PoseTable::odometry_csv ? kOdometryNames : kPosesNames;
  std::vector<std::string> cells;
  Result<bool> more = csv.next(cells);
  if (!more) return unread(more.error());
  PoseColumns columns;
  if (const char* missing = *more ? find_columns(cells, table, columns) : names.sequence)
    return Error{ErrorCode::corrupt, path + " line 1: there is no column " + missing +
                                         "; give the columns these names, or delete the file"};
  if (columns.header) more = csv.next(cells);
  RowReader reader(columns, names);
  std::vector<PoseRow> rows;
  for (; more && *more; more = csv.next(cells)) {
    PoseRow row;
    row.sequence = rows.size();
    row.line = csv.line();
    const std::string fault = reader.read(cells, row);
    // A recorder that was stopped short may have left a piece of a row at the end; its frame was not yet written.
    if (!fault.empty() && csv.cut_off()) return rows;
    if (!fault.empty()) return wrong(fault);
    if (!rows.empty() && row.sequence <= rows.back().sequence)
      return wrong(std::string(names.sequence) + " is " + std::to_string(row.sequence) + ", not after " +
                   std::to_string(rows.back().sequence) + " of the row before");
    if (row.time_s && !rows.empty() && !(*row.time_s > *rows.back().time_s))
      return wrong("timestamp is not after that of the row before");
    if (rows.size() >= kRowsMax)
      return Error{ErrorCode::unsupported, path + " line " + std::to_string(csv.line()) + ": there are more than " +
                                               std::to_string(kRowsMax) + " rows; divide the recording"};
    rows.push_back(row);
  }
  if (!more) return unread(more.error());
  return rows;
}

std::string poses_line(std::uint64_t sequence, const CameraPose& pose) {
  const auto metres = [](float mm) { return static_cast<double>(mm) / kMmPerMetre; };
  char line[160];
  std::snprintf(line, sizeof line, "%06" PRIu64 ",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", sequence,
                metres(pose.position_mm.x), metres(pose.position_mm.y), metres(pose.position_mm.z),
                static_cast<double>(pose.x), static_cast<double>(pose.y), static_cast<double>(pose.z),
                static_cast<double>(pose.w));
  return line;
}

}  // namespace im2fit::hal
