// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/bag_recording.h"

#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
#include "hal/folder/camera_yaml.h"
#include "hal/folder/pose_rows.h"
#include "hal/recording/bag_file.h"
#include "hal/recording/bag_messages.h"
#include "hal/recording/frame_times.h"

namespace im2fit::hal {
namespace {

constexpr std::string_view kImageType = "sensor_msgs/Image";
constexpr std::string_view kRealSense = "/image/data";  // .../Depth_0/image/data

bool contains_word(const std::string& text, std::string_view word) {
  std::string low;
  for (const char c : text) low += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return low.find(word) != std::string::npos;
}

// How much a depth topic is wanted, less is more; none: it is no depth topic.
std::optional<int> rank_of(const BagConnection& connection) {
  const std::string& topic = connection.topic;
  if (connection.type != kImageType || !contains_word(topic, "depth")) return std::nullopt;
  constexpr std::string_view kEndings[] = {kRealSense, "/image_raw", "/image_rect_raw", "/image_rect", "/image"};
  int rank = 0;
  while (rank < 5 && !topic.ends_with(kEndings[rank])) ++rank;
  const bool of_colour = contains_word(topic, "aligned") || contains_word(topic, "registered");
  return rank + (of_colour ? 10 : 0);
}

struct Topics {
  std::set<std::uint32_t> depth;  // connections
  std::string depth_name, info_name, unit_name;
  std::int64_t count = 0;
  bool realsense = false;
};

Error no_depth(const BagFile& bag) {
  std::string list;
  int count = 0;
  bool packed = false;
  for (const auto& [id, connection] : bag.connections()) {
    packed = packed || (contains_word(connection.topic, "depth") && connection.type == "sensor_msgs/CompressedImage");
    if (connection.type == kImageType && count++ < 4) list += (list.empty() ? "" : ", ") + excerpt(connection.topic);
  }
  if (packed)
    return {ErrorCode::unsupported, bag.path() +
                                        " has compressed depth pictures alone; record the topic without /compressed"
                                        "Depth"};
  return {ErrorCode::not_found, bag.path() + " has no topic of depth pictures (pictures: " +
                                    (list.empty() ? "none" : list) + "); record the depth stream"};
}

// One topic has a connection for each that wrote to it: a camera's node that was started again, bags that were
// joined.
Result<Topics> find_topics(const BagFile& bag) {
  Topics topics;
  std::optional<int> best;
  bool tied = false;
  std::string other;
  for (const auto& [id, connection] : bag.connections()) {
    const auto rank = rank_of(connection);
    if (!rank || (best && *rank > *best)) continue;
    if (best && *rank == *best && connection.topic != topics.depth_name) {
      tied = true;
      other = connection.topic;
      continue;
    }
    if (!best || *rank < *best) {
      best = rank;
      tied = false;
      topics = Topics();
      topics.depth_name = connection.topic;
    }
    topics.depth.insert(id);
    topics.count += connection.message_count;
  }
  if (!best) return no_depth(bag);
  if (tied)
    return Error{ErrorCode::invalid_argument, bag.path() + " has several topics of depth (" +
                                                  excerpt(topics.depth_name) + ", " + excerpt(other) +
                                                  "); keep one by: rosbag filter"};
  const std::string& name = topics.depth_name;
  topics.realsense = name.ends_with(kRealSense);
  if (topics.realsense) {
    const std::string stream = name.substr(0, name.size() - kRealSense.size());  // .../sensor_0/Depth_0
    topics.info_name = stream + "/info/camera_info";
    topics.unit_name = stream.substr(0, stream.rfind('/')) + "/option/Depth_Units/value";
  } else {
    topics.info_name = name.substr(0, name.rfind('/')) + "/camera_info";
  }
  return topics;
}

// As a YAML file has it, so that models, counts and plausible values are judged in one place.
Result<CameraFile> calibration_of(const BagCameraInfo& info, bool rectified, const std::string& what,
                                  PictureSize pictures) {
  const auto number = [](double value) {
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, value);
    return std::string(text, end.ptr);
  };
  const bool projected = rectified && info.p[0] > 0;
  std::string model, coefficients;
  for (const char c : info.model)
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' || c == '_')
      model += c;
  if (model == "None" || rectified) model.clear();  // a fisheye's lens is undone, too
  for (const double value : info.distortion)
    coefficients += (coefficients.empty() ? "" : ", ") + number(rectified ? 0 : value);
  const auto k = [&](std::size_t in_k, std::size_t in_p) { return number(projected ? info.p[in_p] : info.k[in_k]); };
  const std::string text = "image_width: " + std::to_string(info.width) +
                           "\nimage_height: " + std::to_string(info.height) + "\ndistortion_model: \"" + model +
                           "\"\nD: [" + coefficients + "]\nK: [" + k(0, 0) + ", " + k(1, 1) + ", " + k(2, 2) + ", " +
                           k(3, 4) + ", " + k(4, 5) + ", " + k(5, 6) + ", 0, 0, 1]\n";
  auto camera = parse_camera_yaml(text, what, pictures);
  if (camera) camera->origin = IntrinsicsOrigin::recording;
  return camera;
}

class BagReader final : public FrameReader {
 public:
  BagReader(std::unique_ptr<BagFile> bag, Topics topics)
      : bag_(std::move(bag)),
        topics_(std::move(topics)),
        what_(bag_->path() + " (" + excerpt(topics_.depth_name) + ")") {}

  struct Head {
    std::optional<BagImage> image;
    std::optional<BagCameraInfo> info;
  };
  // Up to the first picture, the calibration and the unit; damage before them is passed over.
  Result<Head> read_head(bool needs_info) {
    Head head;
    bool needs_unit = has(topics_.unit_name);
    needs_info = needs_info && has(topics_.info_name);
    std::optional<Error> damage;
    bag_->rewind();
    while (!head.image || (needs_info && !head.info) || needs_unit) {
      const auto message = bag_->next();
      if (!message && message.error().code != ErrorCode::corrupt) return message.error();
      if (!message && !damage) damage = message.error();
      if (!message) continue;
      if (!*message) break;
      const std::string& topic = bag_->connections().find((*message)->connection) == bag_->connections().end()
                                     ? kNoTopic
                                     : bag_->connections().at((*message)->connection).topic;
      Status status = Ok{};
      if (topics_.depth.count((*message)->connection) != 0 && !head.image)
        status = keep(read_bag_image(**message, what_), head.image);
      else if (topic == topics_.info_name && !head.info)
        status = keep(read_bag_camera_info(**message, bag_->path() + " (" + excerpt(topic) + ")"), head.info);
      else if (needs_unit && topic == topics_.unit_name)
        status = keep_unit(read_bag_float(**message, what_), needs_unit);
      if (!status && status.error().code != ErrorCode::corrupt) return status.error();
      if (!status && !damage) damage = status.error();
    }
    if (!head.image && damage) return *damage;
    return head;
  }

  Status rewind() override {
    bag_->rewind();
    sequence_ = 0;
    times_.restart();
    return Ok{};
  }

  Result<FrameInfo> next(DepthImage picture) override {
    for (;;) {
      const auto message = bag_->next();
      if (!message) return message.error();
      if (!*message)
        return Error{ErrorCode::end_of_stream,
                     bag_->path() + ": all " + std::to_string(sequence_) + " frames were delivered"};
      if (topics_.depth.count((*message)->connection) != 0) return frame(**message, picture);
    }
  }

 private:
  static inline const std::string kNoTopic;

  bool has(const std::string& topic) const {
    if (topic.empty()) return false;
    for (const auto& [id, connection] : bag_->connections())
      if (connection.topic == topic) return true;
    return false;
  }
  template <class Value>
  static Status keep(Result<Value> read, std::optional<Value>& place) {
    if (!read) return read.error();
    place = std::move(*read);
    return Ok{};
  }
  Status keep_unit(const Result<float>& metres, bool& needs_unit) {
    if (!metres) return metres.error();
    // The decimal that was meant: 0.0001, not the float next to it.
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, *metres);
    double unit_mm = 0;
    if (!NumberReader().read(std::string(text, end.ptr), unit_mm)) unit_mm = 0;
    unit_mm *= 1000;
    if (!(unit_mm >= 0.001 && unit_mm <= 1000))
      return Error{ErrorCode::invalid_argument, bag_->path() + ": " + excerpt(topics_.unit_name) +
                                                    " is not a unit of 0.001 to 1000 mm; record it again"};
    unit_mm_ = unit_mm;
    needs_unit = false;
    return Ok{};
  }

  Result<FrameInfo> frame(const BagMessage& message, DepthImage picture) {
    FrameInfo info;
    info.sequence = sequence_++;
    const std::string where = what_ + ": frame " + std::to_string(info.sequence);
    const auto time_ns = times_.take(message.time_ns);
    if (!time_ns) return FrameTimes::refused(where);
    info.host_ns = *time_ns;
    const auto image = read_bag_image(message, where);
    if (!image) return image.error();
    if (image->stamp_ns > 0) info.device_us = image->stamp_ns / 1000;
    if (image->width != static_cast<std::uint32_t>(picture.width) ||
        image->height != static_cast<std::uint32_t>(picture.height))
      return Error{ErrorCode::corrupt, where + " is " + std::to_string(image->width) + "x" +
                                           std::to_string(image->height) + ", expected " +
                                           std::to_string(picture.width) + "x" + std::to_string(picture.height) +
                                           " like the first"};
    if (auto ok = read_bag_pixels(message, *image, unit_mm_, picture, row_, where); !ok) {
      if (ok.error().code != ErrorCode::unsupported) return ok.error();
      return Error{ErrorCode::corrupt, ok.error().message};  // of this picture alone
    }
    return info;
  }

  std::unique_ptr<BagFile> bag_;
  Topics topics_;
  std::string what_;
  double unit_mm_ = 1;
  std::vector<std::byte> row_;
  std::uint64_t sequence_ = 0;
  FrameTimes times_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_bag_recording(FileCursor file, const RecordingOptions& options) {
  auto bag = BagFile::open(std::move(file));
  if (!bag) return bag.error();
  const std::string path = (*bag)->path();
  const auto topics = find_topics(**bag);
  if (!topics) return topics.error();
  auto reader = std::make_unique<BagReader>(std::move(*bag), *topics);
  const bool given = !options.camera_yaml_path.empty();
  const auto head = reader->read_head(!given);
  if (!head) return head.error();
  if (!head->image)
    return Error{ErrorCode::not_found,
                 path + ": " + excerpt(topics->depth_name) + " holds no pictures; record it again"};
  const BagImage& image = *head->image;
  if (!is_depth_encoding(image.encoding))
    return Error{ErrorCode::unsupported, path + ": " + excerpt(topics->depth_name) + " has pictures of " +
                                             excerpt(image.encoding) + ", expected mono16, 16UC1 or 32FC1"};
  if (!given && !head->info)
    return Error{ErrorCode::not_found, path + " has no " + excerpt(topics->info_name) +
                                           "; record it, too, or give the camera's calibration by --camera FILE"};
  RecordingAbout about;
  about.path = path;
  about.calibration_path = given ? options.camera_yaml_path : path + " (" + excerpt(topics->info_name) + ")";
  const PictureSize pictures{static_cast<int>(image.width), static_cast<int>(image.height)};
  const bool rectified = contains_word(topics->depth_name, "/image_rect");
  const auto camera = given ? load_camera_yaml(options.camera_yaml_path, pictures)
                            : calibration_of(*head->info, rectified, about.calibration_path, pictures);
  if (!camera) return camera.error();
  if (camera->intrinsics.width != pictures.width || camera->intrinsics.height != pictures.height)
    return Error{ErrorCode::invalid_argument,
                 path + " has pictures of " + std::to_string(pictures.width) + "x" + std::to_string(pictures.height) +
                     ", " + about.calibration_path + " is for " + std::to_string(camera->intrinsics.width) + "x" +
                     std::to_string(camera->intrinsics.height) + "; give the calibration of these pictures"};
  about.calibration = *camera;
  about.frame_count = topics->count > 0 ? topics->count : -1;
  if (auto ok = reader->rewind(); !ok) return ok.error();
  return recording_source(about, options, std::move(reader));
}

Result<std::unique_ptr<Source>> open_bag_recording(const std::string& path, const RecordingOptions& options) {
  auto file = FileCursor::open(path);
  if (!file) return file.error();
  return open_bag_recording(std::move(*file), options);
}

}  // namespace im2fit::hal
