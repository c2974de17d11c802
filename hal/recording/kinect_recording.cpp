// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/kinect_recording.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
#include "hal/folder/camera_yaml.h"
#include "hal/recording/frame_times.h"
#include "hal/recording/matroska.h"

namespace im2fit::hal {
namespace {

constexpr std::string_view kFourCc = "b16g";
constexpr std::uint64_t kVideo = 1;
constexpr std::int64_t kFramesMax = 1'000'000;

const MatroskaTag* tag_named(const MatroskaHead& head, std::string_view name) {
  for (const MatroskaTag& tag : head.tags)
    if (tag.name == name) return &tag;
  return nullptr;
}

bool names_uid(const MatroskaTag& tag, std::uint64_t tag_uid, std::uint64_t uid) {
  return uid != 0 && (tag_uid == uid || tag.value == std::to_string(uid));
}

// Microsoft's header of a bitmap, with the code at byte 16, or Matroska's own way.
bool is_depth(const MatroskaTrack& track) {
  constexpr std::size_t kCodeAt = 16;
  if (track.type != kVideo) return false;
  if (track.codec == "V_MS/VFW/FOURCC")
    return track.codec_private.size() >= kCodeAt + kFourCc.size() &&
           track.codec_private.compare(kCodeAt, kFourCc.size(), kFourCc) == 0;
  return track.codec == "V_UNCOMPRESSED" && track.colour_space == kFourCc;
}

std::string track_list(const MatroskaHead& head) {
  constexpr std::size_t kListed = 4;
  std::string list;
  for (std::size_t i = 0; i < head.tracks.size() && i < kListed; ++i) {
    const MatroskaTrack& track = head.tracks[i];
    list += (i > 0 ? ", " : "") + (track.name.empty() ? "" : excerpt(track.name) + " ") + excerpt(track.codec);
  }
  if (head.tracks.size() > kListed) list += " ...";
  return list.empty() ? "none" : list;
}

Result<const MatroskaTrack*> depth_track(const MatroskaHead& head, const std::string& path) {
  const MatroskaTrack* chosen = nullptr;
  const MatroskaTag* tag = tag_named(head, "K4A_DEPTH_TRACK");
  for (const MatroskaTrack& track : head.tracks)
    if (tag && !chosen && names_uid(*tag, tag->track_uid, track.uid)) chosen = &track;
  for (const MatroskaTrack& track : head.tracks)
    if (!chosen && track.type == kVideo && track.name == "DEPTH") chosen = &track;
  int count = 0;
  const MatroskaTrack* only = nullptr;
  for (const MatroskaTrack& track : head.tracks) {
    if (!is_depth(track) || track.name == "IR" || track.name == "DEPTH_IR") continue;
    only = &track;
    ++count;
  }
  if (!chosen && count == 1) chosen = only;
  if (!chosen)
    return Error{ErrorCode::not_found, path + " has no track of depth (its tracks: " + track_list(head) +
                                           "); record with a depth mode, or give a recording of an Azure Kinect or "
                                           "Femto"};
  if (!is_depth(*chosen))
    return Error{ErrorCode::unsupported, path + ": the track of depth is " + excerpt(chosen->codec) +
                                             ", expected uncompressed 16-bit pictures (b16g); record it again"};
  if (chosen->encoded)
    return Error{ErrorCode::unsupported,
                 path + ": the track of depth is compressed; write it plain by mkvmerge --compression -1:none"};
  const std::uint64_t side = kImageSideMax;
  if (chosen->width < 1 || chosen->height < 1 || chosen->width > side || chosen->height > side)
    return Error{ErrorCode::unsupported, path + ": its depth pictures are " + std::to_string(chosen->width) + "x" +
                                             std::to_string(chosen->height) + ", expected 1 to " +
                                             std::to_string(side) + " pixels a side"};
  return chosen;
}

const MatroskaAttachment* calibration_of(const MatroskaHead& head) {
  const MatroskaTag* tag = tag_named(head, "K4A_CALIBRATION_FILE");
  for (const MatroskaAttachment& file : head.attachments)
    if (tag && (names_uid(*tag, tag->attachment_uid, file.uid) || (!file.name.empty() && tag->value == file.name)))
      return &file;
  for (const MatroskaAttachment& file : head.attachments)
    if (file.name == "calibration.json") return &file;
  return nullptr;
}

Result<CameraFile> calibration(FileCursor& file, const MatroskaHead& head, const RecordingOptions& options,
                               PictureSize pictures) {
  if (!options.camera_yaml_path.empty()) return load_camera_yaml(options.camera_yaml_path, pictures);
  const MatroskaAttachment* attached = calibration_of(head);
  if (!attached)
    return Error{ErrorCode::not_found, file.path() + " has no calibration.json" +
                                           (head.whole ? "" : ", and was cut off") +
                                           "; give the camera's calibration by --camera FILE"};
  const auto text = read_matroska_attachment(file, *attached);
  if (!text) return text.error();
  auto camera = parse_camera_yaml(*text, file.path() + " (calibration.json)", pictures);
  if (camera) camera->origin = IntrinsicsOrigin::recording;
  return camera;
}

// The device's clock at the file's time 0.
std::int64_t start_offset_ns(const MatroskaHead& head) {
  const MatroskaTag* tag = tag_named(head, "K4A_START_OFFSET_NS");
  std::int64_t value = -1;
  if (tag) {
    const auto [end, code] = std::from_chars(tag->value.data(), tag->value.data() + tag->value.size(), value);
    if (code != std::errc() || end != tag->value.data() + tag->value.size()) value = -1;
  }
  return value >= 0 && value < kRecordedTimeMaxNs / 2 ? value : -1;
}

const MatroskaTrack* accelerometer_track(const MatroskaHead& head) {
  for (const MatroskaTrack& track : head.tracks)
    if (track.codec == "S_K4A/IMU" && !track.encoded) return &track;
  return nullptr;
}

// The direction of gravity while a recording is read. The recorder writes samples of 40 bytes, little-endian: 8 of
// time, three floats of acceleration in m/s2, 8 of time, three floats of the gyroscope.
class RecordedGravity {
 public:
  RecordedGravity(FileCursor& file, const MatroskaHead& head, const std::array<float, 9>& from_depth)
      : file_(file), blocks_(file, accelerometer_track(head)->number), from_depth_(from_depth) {}

  void restart(std::uint64_t at) {
    blocks_.restart(at);
    waiting_.reset();
    count_ = 0;
    mean_ = {};
  }

  // In the depth camera's axes, with the samples of the blocks up to `time`, and of the first block in any case.
  // None: there are no samples, or the camera is moved. Errors: io.
  Result<std::optional<Vec3f>> down_at(std::int64_t time) {
    for (;;) {
      if (!waiting_) {
        auto block = blocks_.next();
        if (!block && block.error().code != ErrorCode::corrupt) return block.error();
        if (!block || !*block) break;
        waiting_ = Waiting{**block, file_.at()};
      }
      if (count_ > 0 && waiting_->block.time > time) break;
      if (auto ok = take(); !ok) return ok.error();
      waiting_.reset();
    }
    constexpr float kGravity = 9.81F, kOffMax = 0.1F * kGravity;
    if (count_ == 0 || !(std::fabs(norm(mean_) - kGravity) < kOffMax)) return std::optional<Vec3f>();
    // A camera that is held still reads the force that holds it, which points up.
    const Vec3f down = -normalized(mean_);
    const auto& r = from_depth_;
    return std::optional(
        normalized(Vec3f{r[0] * down.x + r[3] * down.y + r[6] * down.z, r[1] * down.x + r[4] * down.y + r[7] * down.z,
                         r[2] * down.x + r[5] * down.y + r[8] * down.z}));
  }

 private:
  static constexpr std::size_t kSampleBytes = 40, kAccelerationAt = 8;
  struct Waiting {
    MatroskaBlock block;
    std::uint64_t at = 0;  // of its bytes
  };

  // Frames of one size stand at the end of their block, whatever form their sizes have.
  Status take() {
    const auto& [block, at] = *waiting_;
    file_.seek(at);
    std::uint64_t frames = 1;
    if (block.laced) {
      std::array<std::byte, 1> more{};
      if (block.size < 1) return Ok{};
      if (auto ok = file_.read(more); !ok) return ok;
      frames += std::to_integer<std::uint64_t>(more[0]);
    }
    if (block.size < frames * kSampleBytes) return Ok{};
    file_.seek(at + block.size - frames * kSampleBytes);
    for (std::uint64_t i = 0; i < frames; ++i) {
      std::array<std::byte, kSampleBytes> bytes{};
      if (auto ok = file_.read(bytes); !ok) return ok;
      const auto number = [&](std::size_t place) {
        std::uint32_t bits = 0;
        for (std::size_t b = 4; b-- > 0;)
          bits = bits << 8 | std::to_integer<std::uint32_t>(bytes[kAccelerationAt + 4 * place + b]);
        return std::bit_cast<float>(bits);
      };
      add({number(0), number(1), number(2)});
    }
    return Ok{};
  }

  // The mean of the last half second, of 1,666 samples a second.
  void add(Vec3f sample) {
    constexpr std::int64_t kMeanOf = 800;
    constexpr float kStrongest = 1000;
    if (!(norm(sample) < kStrongest)) return;
    count_ = std::min(count_ + 1, kMeanOf);
    mean_ = mean_ + (sample - mean_) * (1 / static_cast<float>(count_));
  }

  FileCursor& file_;
  MatroskaBlocks blocks_;
  std::array<float, 9> from_depth_;
  std::optional<Waiting> waiting_;
  std::int64_t count_ = 0;
  Vec3f mean_;
};

class KinectReader final : public FrameReader {
 public:
  KinectReader(FileCursor file, const MatroskaHead& head, const MatroskaTrack& track,
               const std::optional<std::array<float, 9>>& accelerometer)
      : file_(std::move(file)),
        blocks_(file_, track.number),
        begin_(head.first_cluster_at),
        scale_ns_(head.timestamp_scale_ns),
        offset_ns_(start_offset_ns(head)) {
    if (accelerometer && accelerometer_track(head)) gravity_.emplace(file_, head, *accelerometer);
  }

  // Up to where the file was cut off.
  Result<std::int64_t> count() {
    blocks_.restart(begin_);
    for (std::int64_t frames = 0;; ++frames) {
      if (frames > kFramesMax)
        return Error{ErrorCode::unsupported,
                     file_.path() + " holds more than " + std::to_string(kFramesMax) + " frames"};
      const auto block = blocks_.next();
      if (!block && block.error().code != ErrorCode::corrupt) return block.error();
      if (block && *block) continue;
      if (frames > 0) return frames;
      return block ? Error{ErrorCode::corrupt, file_.path() + " holds no pictures; copy or record it again"}
                   : block.error();
    }
  }

  Status rewind() override {
    blocks_.restart(begin_);
    if (gravity_) gravity_->restart(begin_);
    sequence_ = 0;
    times_.restart();
    return Ok{};
  }

  Result<FrameInfo> next(DepthImage picture) override {
    const auto block = blocks_.next();
    if (!block) return block.error();
    if (!*block)
      return Error{ErrorCode::end_of_stream,
                   file_.path() + ": all " + std::to_string(sequence_) + " frames were delivered"};
    FrameInfo info;
    info.sequence = sequence_++;
    const std::string where = file_.path() + ": frame " + std::to_string(info.sequence);
    const auto time = (*block)->time;
    if (time < 0 || static_cast<std::uint64_t>(time) > static_cast<std::uint64_t>(kRecordedTimeMaxNs / 2) / scale_ns_)
      return FrameTimes::refused(where);
    const auto time_ns = times_.take(time * static_cast<std::int64_t>(scale_ns_));
    if (!time_ns) return FrameTimes::refused(where);
    info.host_ns = *time_ns;
    if (offset_ns_ >= 0) info.device_us = (info.host_ns + offset_ns_) / 1000;
    const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if ((*block)->laced) return Error{ErrorCode::corrupt, where + " shares its block with others; record it again"};
    if ((*block)->size != pixels * sizeof(std::uint16_t))
      return Error{ErrorCode::corrupt, where + " has " + std::to_string((*block)->size) + " bytes, expected " +
                                           std::to_string(pixels * sizeof(std::uint16_t))};
    if (auto ok = file_.read(std::as_writable_bytes(std::span(picture.pixels, pixels))); !ok) return ok.error();
    for (std::uint16_t& value : std::span(picture.pixels, pixels)) {
      const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
      value = static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
    }
    if (gravity_) {
      const auto down = gravity_->down_at(time);
      if (!down) return down.error();
      info.down = *down;
    }
    return info;
  }

 private:
  FileCursor file_;
  MatroskaBlocks blocks_;
  std::uint64_t begin_, scale_ns_;
  std::int64_t offset_ns_;
  std::uint64_t sequence_ = 0;
  FrameTimes times_;
  std::optional<RecordedGravity> gravity_;  // of file_
};

// Of the camera's own calibration, also where another one is given for the lens.
std::optional<std::array<float, 9>> accelerometer_of(FileCursor& file, const MatroskaHead& head) {
  const MatroskaAttachment* attached = calibration_of(head);
  if (!attached || !accelerometer_track(head)) return std::nullopt;
  const auto text = read_matroska_attachment(file, *attached);
  return text ? accelerometer_rotation(*text) : std::nullopt;
}

}  // namespace

Result<std::unique_ptr<Source>> open_kinect_recording(FileCursor file, const RecordingOptions& options) {
  const auto head = read_matroska_head(file);
  if (!head) return head.error();
  const auto track = depth_track(*head, file.path());
  if (!track) return track.error();
  if (head->timestamp_scale_ns < 1 || head->timestamp_scale_ns > 1'000'000'000)
    return Error{ErrorCode::corrupt, file.path() + " has an impossible unit of time; record it again"};
  if (head->first_cluster_at == 0)
    return Error{ErrorCode::corrupt, file.path() + " holds no pictures; copy or record it again"};
  const PictureSize pictures{static_cast<int>((*track)->width), static_cast<int>((*track)->height)};
  auto camera = calibration(file, *head, options, pictures);
  if (!camera) return camera.error();
  RecordingAbout about;
  about.path = file.path();
  about.calibration_path =
      options.camera_yaml_path.empty() ? about.path + " (calibration.json)" : options.camera_yaml_path;
  if (camera->intrinsics.width != pictures.width || camera->intrinsics.height != pictures.height)
    return Error{ErrorCode::invalid_argument,
                 about.path + " has pictures of " + std::to_string(pictures.width) + "x" +
                     std::to_string(pictures.height) + ", " + about.calibration_path + " is for " +
                     std::to_string(camera->intrinsics.width) + "x" + std::to_string(camera->intrinsics.height) +
                     "; give the calibration of these pictures"};
  about.calibration = *camera;
  about.sensor = SensorKind::time_of_flight;
  const auto accelerometer = accelerometer_of(file, *head);
  auto reader = std::make_unique<KinectReader>(std::move(file), *head, **track, accelerometer);
  const auto count = reader->count();
  if (!count) return count.error();
  about.frame_count = *count;
  if (auto ok = reader->rewind(); !ok) return ok.error();
  return recording_source(about, options, std::move(reader));
}

Result<std::unique_ptr<Source>> open_kinect_recording(const std::string& path, const RecordingOptions& options) {
  auto file = FileCursor::open(path);
  if (!file) return file.error();
  return open_kinect_recording(std::move(*file), options);
}

}  // namespace im2fit::hal
