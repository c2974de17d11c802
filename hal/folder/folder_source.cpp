// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <locale>
#include <map>
#include <optional>
#include <sstream>

#include "core/file.h"
#include "formats/csv.h"
#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/frame_name.h"
#include "hal/folder/pose_rows.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kFramesMax = 1'000'000;
constexpr std::uint64_t kNumberMax = 999'999'999;               // at 30 Hz a year
constexpr std::size_t kTimesBytesMax = 64 << 20;                // of kFramesMax rows
constexpr std::int64_t kTimeMaxNs = 4'000'000'000'000'000'000;  // by any clock: the year 2096
constexpr std::size_t kFileBytesMax = 64
                                      << 20;  // 2048 x 2048 pixels are 8 MB; a PNG can hardly be eight times larger

std::int64_t frame_time_ns(std::uint64_t sequence) {
  return static_cast<std::int64_t>(sequence) * 1'000'000'000 / 30;
}

void to_millimetres(DepthImage image, double unit_mm) {
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      std::uint16_t& value = image.row(v)[u];
      const double mm = value * unit_mm + 0.5;
      value = static_cast<std::uint16_t>(mm < 65536 ? mm : 0);
    }
}

bool to_number(const std::string& text, std::int64_t& value) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size();
}

struct Times {
  std::int64_t host_ns = -1;
  std::int64_t device_us = -1;
  std::optional<Vec3f> down;
};

// The columns of timestamps.csv by the names in its first line.
struct Columns {
  std::array<std::size_t, 3> at = {SIZE_MAX, SIZE_MAX, SIZE_MAX};
  std::array<std::size_t, 3> down = {SIZE_MAX, SIZE_MAX, SIZE_MAX};
  static constexpr std::array<const char*, 3> kNames = {"frame", "host_ns", "device_us"};
  static constexpr std::array<const char*, 3> kDownNames = {"down_x", "down_y", "down_z"};
  explicit Columns(const std::vector<std::string>& cells) {
    for (std::size_t column = 0; column < kNames.size(); ++column) {
      at[column] = find(cells, kNames[column]);
      down[column] = find(cells, kDownNames[column]);
    }
  }
  bool usable() const { return at[0] != SIZE_MAX && (at[1] != SIZE_MAX || at[2] != SIZE_MAX); }

 private:
  static std::size_t find(const std::vector<std::string>& cells, const char* name) {
    const auto it = std::find(cells.begin(), cells.end(), name);
    return it == cells.end() ? SIZE_MAX : static_cast<std::size_t>(it - cells.begin());
  }
};

// To the nearest float, whatever the locale: from_chars for floats is not in every standard library we build with.
bool read_float(const std::string& text, float& value) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  return (stream >> value) && stream.peek() == std::istringstream::traits_type::eof();
}

// None: the cells are empty. Error: they are not a vector of length 1.
Result<std::optional<Vec3f>> down_in(const std::vector<std::string>& cells, const Columns& columns) {
  std::array<float, 3> values{};
  std::size_t empty = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string text = columns.down[i] < cells.size() ? cells[columns.down[i]] : "";
    if (text.empty())
      ++empty;
    else if (!read_float(text, values[i]))
      return Error{ErrorCode::corrupt, std::string(Columns::kDownNames[i]) + " is not a number"};
  }
  if (empty == values.size()) return std::optional<Vec3f>();
  const float square = values[0] * values[0] + values[1] * values[1] + values[2] * values[2];
  if (empty > 0 || !(square > 0.99F && square < 1.01F))
    return Error{ErrorCode::corrupt, "down_x, down_y, down_z are not a vector of length 1"};
  return std::optional(Vec3f{values[0], values[1], values[2]});
}

// By column: what is still a number and a time.
constexpr std::array<std::int64_t, 3> kValueMax = {static_cast<std::int64_t>(kNumberMax), kTimeMaxNs,
                                                   kTimeMaxNs / 1000};

Result<std::map<std::int64_t, Times>> parse_times(const std::string& path) {
  const auto bytes = read_file(path, kTimesBytesMax);
  if (!bytes) return bytes.error();
  CsvReader csv({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
  const auto advised = [](Error error) {
    error.message += "; correct or delete the file";
    return error;
  };
  std::vector<std::string> cells;
  if (const auto more = csv.next(cells); !more) return advised(more.error());
  const Columns columns(cells);
  if (!columns.usable())
    return Error{ErrorCode::corrupt,
                 path + " line 1: expected column names frame and host_ns or device_us; correct or delete the file"};
  std::map<std::int64_t, Times> times;
  std::array<std::int64_t, 3> last = {-1, -1, -1};
  for (;;) {
    const auto more = csv.next(cells);
    if (!more) return advised(more.error());
    if (!*more) return times;
    std::array<std::int64_t, 3> values = {-1, -1, -1};
    // A recorder that was stopped short may have left a piece of a row at the end; its frame was not yet written.
    if (csv.cut_off() && cells.size() < 2) return times;
    for (std::size_t column = 0; column < values.size(); ++column) {
      if (columns.at[column] == SIZE_MAX) continue;
      const std::string where = path + " line " + std::to_string(csv.line()) + ": " + Columns::kNames[column];
      if (columns.at[column] >= cells.size() || !to_number(cells[columns.at[column]], values[column]))
        return advised({ErrorCode::corrupt, where + " is missing or not a whole number"});
      if (values[column] < 0 || values[column] > kValueMax[column])
        return advised({ErrorCode::corrupt, where + " is " + std::to_string(values[column]) + ", expected 0 to " +
                                                std::to_string(kValueMax[column])});
      if (values[column] <= last[column])
        return Error{ErrorCode::corrupt,
                     where + " is " + std::to_string(values[column]) + ", not after " + std::to_string(last[column]) +
                         " of the row before; put the frames in order of time, or delete the file"};
      last[column] = values[column];
    }
    const auto down = down_in(cells, columns);
    if (!down && csv.cut_off()) return times;
    if (!down)
      return advised(
          {ErrorCode::corrupt, path + " line " + std::to_string(csv.line()) + ": " + down.error().message});
    times[values[0]] = {values[1], values[2], *down};
  }
}

}  // namespace

Result<std::unique_ptr<FolderSource>> FolderSource::open(const std::string& path, const FolderOptions& options) {
  std::unique_ptr<FolderSource> source(new FolderSource);
  if (options.rotate_deg && !is_rotation(*options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(*options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  if (options.unit_mm != 0 && !(options.unit_mm >= 0.001 && options.unit_mm <= 1000))
    return Error{ErrorCode::invalid_argument,
                 "the unit is " + std::to_string(options.unit_mm) + " mm, expected 0.001 to 1000"};
  source->info_.unit_mm = options.unit_mm == 0 ? 1 : options.unit_mm;
  const FolderContents* contents = options.contents;
  if (contents && !contents->listed.empty()) {
    for (const auto& [file, info] : contents->listed) source->frames_.push_back({file, info});
  } else if (auto ok = source->scan(contents ? contents->frames_path : path); !ok) {
    return ok.error();
  }
  const std::string yaml = options.camera_yaml_path.empty() ? path + "/camera.yaml" : options.camera_yaml_path;
  const auto header = source->first_header();
  const PictureSize pictures = header ? PictureSize{header->width, header->height} : PictureSize{};
  auto camera = contents ? Result<CameraFile>(contents->camera) : load_camera_yaml(yaml, pictures);
  if (!camera) {
    Error error = camera.error();
    if (error.code == ErrorCode::not_found)
      error.message = yaml + " is missing; put the camera's calibration there or give --camera FILE (docs/cameras)";
    return error;
  }
  if (!header) return header.error();
  if (header->width != camera->intrinsics.width || header->height != camera->intrinsics.height)
    return Error{ErrorCode::invalid_argument,
                 source->frames_.front().path + " is " + std::to_string(header->width) + "x" +
                     std::to_string(header->height) + " but " + (contents ? contents->camera_path : yaml) +
                     " is for " + std::to_string(camera->intrinsics.width) + "x" +
                     std::to_string(camera->intrinsics.height) + "; give the calibration of these pictures"};
  SourceInfo& info = source->info_;
  info.uri = path;
  info.name = path;
  info.rotate_deg = options.rotate_deg.value_or(camera->rotate_deg.value_or(0));
  if (auto ok = contents ? source->take_contents(*contents) : source->take_tables(path); !ok) return ok.error();
  info.intrinsics_origin = camera->origin;
  info.frame_count = static_cast<std::int64_t>(source->frames_.size());
  auto upright = UprightPath::make(*camera, info.rotate_deg, contents ? contents->camera_path : yaml);
  if (!upright) return upright.error();
  source->path_ = std::move(*upright);
  info.intrinsics = source->path_.upright();
  source->confidence_min_ = camera->confidence_min.value_or(kConfidenceMin);
  if (auto ok = source->check_confidence(); !ok) return ok.error();
  return source;
}

Status FolderSource::scan(const std::string& path) {
  std::error_code code;
  std::filesystem::directory_iterator it(path, code);
  if (code)
    return Error{code == std::errc::no_such_file_or_directory ? ErrorCode::not_found : ErrorCode::io,
                 "cannot read the folder " + path + ": " + code.message()};
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    const auto number = frame_number(it->path().filename().string());
    if (!number) continue;
    if (*number > kNumberMax)
      return Error{ErrorCode::invalid_argument, it->path().string() + " has the number " + std::to_string(*number) +
                                                    ", expected at most " + std::to_string(kNumberMax) +
                                                    "; number the frames from 0"};
    if (std::error_code kind; it->is_directory(kind))
      return Error{ErrorCode::invalid_argument,
                   it->path().string() + " is a folder, expected a picture; move it away"};
    Frame frame{it->path().string(), {*number, frame_time_ns(*number), -1}};
    frames_.push_back(std::move(frame));
    if (frames_.size() > kFramesMax)
      return Error{ErrorCode::unsupported, path + " holds more than " + std::to_string(kFramesMax) + " frames"};
  }
  if (code) return Error{ErrorCode::io, "cannot read the folder " + path + ": " + code.message()};
  if (frames_.empty())
    return Error{ErrorCode::not_found, path +
                                           " holds no depth frames; expected 16-bit files named 000000.png or "
                                           "000000.pgm, 000001.png ..."};
  std::sort(frames_.begin(), frames_.end(),
            [](const Frame& a, const Frame& b) { return a.info.sequence < b.info.sequence; });
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].info.sequence == frames_[i - 1].info.sequence)
      return Error{ErrorCode::invalid_argument, frames_[i - 1].path + " and " + frames_[i].path +
                                                    " have the same frame number; remove one of them"};
  }
  return Ok{};
}

// Up to the first sound one: a recording may have thousands. Damage before it is next()'s to report.
Result<DepthHeader> FolderSource::first_header() const {
  std::vector<std::byte> bytes;
  std::optional<Error> first_damage;
  for (const Frame& frame : frames_) {
    if (auto ok = read_file_into(frame.path, kFileBytesMax, kHeaderBytes, bytes); !ok) return ok.error();
    auto header = parse_depth_header(bytes, frame.path);
    if (header || header.error().code != ErrorCode::corrupt) return header;
    if (!first_damage) first_damage = header.error();
  }
  return *first_damage;
}

// Pictures of another kind or size are another folder's.
std::optional<Error> FolderSource::foreign(const Frame& frame) {
  const auto header = parse_depth_header(file_bytes_, frame.path);
  if (!header) return header.error().code == ErrorCode::corrupt ? std::nullopt : std::optional(header.error());
  const DepthImage expected = path_.camera_image();
  if (header->width == expected.width && header->height == expected.height) return std::nullopt;
  return Error{ErrorCode::invalid_argument,
               frame.path + " is " + std::to_string(header->width) + "x" + std::to_string(header->height) +
                   ", expected " + std::to_string(expected.width) + "x" + std::to_string(expected.height) +
                   " like the frames before it; keep one size to a folder"};
}

Status FolderSource::read_timestamps(const std::string& path) {
  auto times = parse_times(path);
  if (!times) return times.error();
  for (Frame& frame : frames_) {
    const auto it = times->find(static_cast<std::int64_t>(frame.info.sequence));
    if (it == times->end())
      return Error{ErrorCode::corrupt, path + " has no row for " + frame.path + "; complete or delete the file"};
    frame.info.device_us = it->second.device_us;
    frame.info.host_ns = it->second.host_ns >= 0 ? it->second.host_ns : it->second.device_us * 1000;
    if (info_.rotate_deg == 0) frame.info.down = it->second.down;
  }
  return Ok{};
}

Status FolderSource::take_tables(const std::string& path) {
  if (std::error_code code; std::filesystem::exists(path + "/timestamps.csv", code) || code) {
    if (auto ok = read_timestamps(path + "/timestamps.csv"); !ok) return ok.error();
  }
  if (std::error_code code; std::filesystem::exists(path + "/poses.csv", code) || code) {
    if (auto ok = read_poses(path + "/poses.csv"); !ok) return ok.error();
  }
  if (std::error_code code; std::filesystem::exists(path + "/confidence", code) || code) {
    if (!std::filesystem::is_directory(path + "/confidence", code))
      return Error{ErrorCode::invalid_argument,
                   path + "/confidence is not a folder that can be read; expected pictures of confidence in it"};
    confidence_folder_ = path + "/confidence";
  }
  return Ok{};
}

Status FolderSource::take_contents(const FolderContents& contents) {
  info_.sensor = contents.sensor;
  confidence_folder_ = contents.confidence_path;
  confidence_beside_ = contents.confidence_beside;
  for (Frame& frame : frames_)
    if (!contents.listed.empty() && frame.info.pose)
      frame.info.pose = rotate_upright(*frame.info.pose, info_.rotate_deg);
  if (!contents.listed.empty()) return Ok{};
  if (contents.frames.empty()) {
    for (Frame& frame : frames_)
      frame.info.host_ns = static_cast<std::int64_t>(frame.info.sequence) * contents.frame_ns;
    return Ok{};
  }
  for (Frame& frame : frames_) {
    const auto row = contents.frames.find(frame.info.sequence);
    if (row == contents.frames.end())
      return Error{ErrorCode::corrupt,
                   contents.table_path + " has no row for " + frame.path + "; copy the whole recording again"};
    frame.info = row->second;
    if (frame.info.pose) frame.info.pose = rotate_upright(*frame.info.pose, info_.rotate_deg);
    if (frame.info.down) frame.info.down = rotate_upright(*frame.info.down, info_.rotate_deg);
  }
  return Ok{};
}

Status FolderSource::read_poses(const std::string& path) {
  const auto rows = read_pose_rows(path, PoseTable::poses_csv);
  if (!rows) return rows.error();
  auto row = rows->begin();
  for (Frame& frame : frames_) {
    while (row != rows->end() && row->sequence < frame.info.sequence) ++row;
    if (row != rows->end() && row->sequence == frame.info.sequence)
      frame.info.pose = rotate_upright(row->pose, info_.rotate_deg);
  }
  return Ok{};
}

// Of the first frame: the others are next()'s to report.
Status FolderSource::check_confidence() {
  auto ok = drop_unsure(frames_.front());
  if (ok || ok.error().code == ErrorCode::corrupt) return Ok{};
  return ok;
}

std::string FolderSource::confidence_of(const Frame& frame) const {
  if (confidence_min_ == 0) return "";
  if (!confidence_folder_.empty())
    return confidence_folder_ + "/" + frame_name(frame.info.sequence, DepthFormat::png);
  const std::size_t name = frame.path.rfind('/') + 1;
  if (!confidence_beside_ || frame.path.compare(name, 5, "depth") != 0) return "";
  return frame.path.substr(0, name) + "conf" + frame.path.substr(name + 5);
}

Status FolderSource::drop_unsure(const Frame& frame) {
  const std::string path = confidence_of(frame);
  if (path.empty()) return Ok{};
  if (auto ok = read_file_into(path, kFileBytesMax, SIZE_MAX, file_bytes_); !ok) {
    Error error = ok.error();
    if (error.code == ErrorCode::not_found)
      error.message = path + " is missing; copy it again, or remove all confidence pictures to use every pixel";
    return error;
  }
  const DepthImage image = path_.camera_image();
  if (auto ok = decode_confidence(file_bytes_, path, image.width, image.height, confidence_); !ok) return ok;
  const std::uint8_t* sure = confidence_.data();
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u)
      if (*sure++ < confidence_min_) image.at(u, v) = 0;
  return Ok{};
}

Status FolderSource::start() {
  index_ = 0;
  book_.reset();
  return Ok{};
}

Result<FrameInfo> FolderSource::next(DepthImage depth, int /*timeout_ms*/) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  if (index_ >= frames_.size())
    return Error{ErrorCode::end_of_stream,
                 info_.name + ": all " + std::to_string(frames_.size()) + " frames were delivered"};
  const Frame& frame = frames_[index_++];
  Status status = read_file_into(frame.path, kFileBytesMax, SIZE_MAX, file_bytes_);
  if (status) {
    status = decoder_.decode(file_bytes_, frame.path, path_.camera_image());
    if (!status)
      if (auto error = foreign(frame)) {
        index_ = frames_.size();
        return *error;
      }
  }
  if (!status) {
    book_.damaged();
    return Error{ErrorCode::corrupt, status.error().message};
  }
  if (auto ok = drop_unsure(frame); !ok) {
    book_.damaged();
    return Error{ErrorCode::corrupt, ok.error().message};
  }
  if (info_.unit_mm != 1) to_millimetres(path_.camera_image(), info_.unit_mm);
  path_.deliver(depth);
  book_.saw(frame.info.sequence);
  return frame.info;
}

}  // namespace im2fit::hal
