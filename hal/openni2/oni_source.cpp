// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_source.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "hal/intrinsics.h"
#include "hal/openni2/oni_reader.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kSmallPayload = oni::kFailureBytesMax;

// Installed, the reader is beside the program or in libexec; in a build tree it is where CMake makes it. A library's
// folder may have one for the architecture below it.
constexpr const char* kReaderPlaces[] = {"im2fit-oni-reader", "../libexec/im2fit/im2fit-oni-reader",
                                         "../../libexec/im2fit/im2fit-oni-reader", "../hal/openni2/im2fit-oni-reader",
                                         "../../hal/openni2/im2fit-oni-reader"};

std::string reader_near(const std::filesystem::path& file) {
  for (const char* place : kReaderPlaces) {
    const auto candidate = file.parent_path() / place;
    if (::access(candidate.c_str(), X_OK) == 0) return candidate.string();
  }
  return "";
}

// The reader beside the program; for libim2fit-cameras, used by any program, beside the library. "": none.
std::string find_reader(const std::string& given) {
  if (!given.empty()) return given;
  if (const char* variable = std::getenv("IM2FIT_ONI_READER"); variable != nullptr && *variable != '\0')
    return variable;
  std::error_code code;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", code);
  if (!code)
    if (auto found = reader_near(program); !found.empty()) return found;
  Dl_info here{};
  if (::dladdr(reinterpret_cast<const void*>(&reader_near), &here) == 0 || here.dli_fname == nullptr) return "";
  const auto library = std::filesystem::canonical(here.dli_fname, code);
  return code ? "" : reader_near(library);
}

// A child may be corrupted. Its text goes into an error message, so it is reduced to one line of plain text.
std::string one_line(const std::byte* text, std::size_t size) {
  std::string line;
  for (std::size_t i = 0; i < size; ++i) {
    const char c = static_cast<char>(text[i]);
    line += c >= ' ' && c < 0x7F ? c : ' ';
  }
  return line;
}

}  // namespace

Result<std::unique_ptr<OniSource>> OniSource::open(const std::string& path, const OniOptions& options) {
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code))
    return Error{ErrorCode::not_found, path + " is not there or not a file; expected an OpenNI2 recording (.oni)"};
  if (::access(path.c_str(), R_OK) != 0)
    return Error{ErrorCode::io, "cannot read " + path + ": " + std::strerror(errno)};
  std::unique_ptr<OniSource> source(new OniSource);
  source->options_ = options;
  source->path_text_ = path;
  source->info_.uri = path;
  source->info_.name = path;
  source->info_.rotate_deg = options.rotate_deg;
  if (auto ok = source->launch(); !ok) return ok.error();
  return source;
}

Status OniSource::launch() {
  child_.end();
  have_ = 0;
  silent_ms_ = 0;
  frames_ = 0;
  final_.reset();
  book_.reset();
  message_.resize(std::max(message_.size(), sizeof(oni::Header) + kSmallPayload));
  const std::string reader = find_reader(options_.reader_path);
  auto child = options_.reader  ? options_.reader()
               : reader.empty() ? ChildProcess::fork([path = path_text_](int pipe) { return serve_oni(path, pipe); })
                                : ChildProcess::spawn(reader, {path_text_, std::to_string(ChildProcess::kPipeFd)});
  if (!child) return child.error();
  child_ = std::move(*child);
  const auto header = receive(options_.stall_ms + 1);
  if (!header) return Error{ErrorCode::corrupt, header.error().message};
  if (header->kind == oni::Kind::failure) return Error{ErrorCode::corrupt, cannot_be_played(*header).message};
  if (header->kind != oni::Kind::hello || header->payload_bytes != sizeof(oni::Hello))
    return Error{ErrorCode::corrupt, give_up("begins with invalid data").message};
  oni::Hello hello;
  std::memcpy(&hello, message_.data() + sizeof(oni::Header), sizeof hello);
  have_ = 0;
  if (auto ok = describe(hello); !ok) {
    child_.end();
    return ok;
  }
  fresh_ = true;
  return Ok{};
}

Status OniSource::describe(const oni::Hello& hello) {
  if (hello.width < 1 || hello.height < 1 || hello.width > kImageSideMax || hello.height > kImageSideMax)
    return Error{ErrorCode::corrupt, path_text_ + ": its pictures are " + std::to_string(hello.width) + "x" +
                                         std::to_string(hello.height) + " pixels, expected 1 to 2048 a side"};
  if (hello.frame_count == 0) return Error{ErrorCode::corrupt, path_text_ + " holds no frames; record again"};
  Calibration camera;
  if (options_.calibration) {
    camera = *options_.calibration;
    const Intrinsics& k = camera.intrinsics;
    if (k.width != hello.width || k.height != hello.height)
      return Error{ErrorCode::invalid_argument,
                   "the calibration of " + path_text_ + " is of " + std::to_string(k.width) + "x" +
                       std::to_string(k.height) + " pictures, the recording of " + std::to_string(hello.width) + "x" +
                       std::to_string(hello.height) + "; give the one it was recorded with"};
  } else {
    const auto found = intrinsics_from_field_of_view(hello.width, hello.height, hello.horizontal_rad,
                                                     hello.vertical_rad, path_text_);
    if (!found) return Error{ErrorCode::corrupt, found.error().message + " or give --camera FILE"};
    camera.intrinsics = *found;
    camera.origin = IntrinsicsOrigin::field_of_view;
  }
  auto upright = UprightPath::make(camera, options_.rotate_deg, "the calibration of " + path_text_);
  if (!upright) return upright.error();
  path_ = std::move(*upright);
  info_.intrinsics = path_.upright();
  info_.intrinsics_origin = camera.origin;
  info_.frame_count = hello.frame_count > 0 ? hello.frame_count : -1;
  message_.resize(sizeof(oni::Header) +
                  std::max(kSmallPayload, sizeof(oni::Frame) + path_.pixel_count() * sizeof(std::uint16_t)));
  return Ok{};
}

Error OniSource::give_up(const std::string& why) {
  child_.end();
  final_ = Error{ErrorCode::io, path_text_ + " " + why + "; the recording is damaged: record or copy it again"};
  return *final_;
}

Error OniSource::cannot_be_played(const oni::Header& failure) {
  return give_up("cannot be played: " + one_line(message_.data() + sizeof failure, failure.payload_bytes));
}

Result<oni::Header> OniSource::receive(int timeout_ms) {
  oni::Header header;
  int waited_ms = 0;
  for (;;) {
    std::size_t wanted = sizeof header;
    if (have_ >= sizeof header) {
      std::memcpy(&header, message_.data(), sizeof header);
      if (header.magic != oni::kMagic || header.payload_bytes > message_.size() - sizeof header)
        return give_up("has invalid data after frame " + std::to_string(frames_));
      wanted += header.payload_bytes;
      if (have_ == wanted) return header;
    }
    const int slice_ms = std::max(0, std::min(timeout_ms - waited_ms, options_.stall_ms - silent_ms_));
    std::size_t count = 0;
    const std::int64_t before_ns = monotonic_ns();
    const auto read = child_.read(message_.data() + have_, wanted - have_, slice_ms, count);
    const int spent_ms = static_cast<int>((monotonic_ns() - before_ns) / 1'000'000);
    waited_ms += spent_ms;
    silent_ms_ = count > 0 ? 0 : silent_ms_ + spent_ms;
    have_ += count;
    if (read == ChildProcess::Read::closed) {
      const std::string how = child_.reap();
      return give_up("ended the OpenNI2 runtime, which " + how + ", after frame " + std::to_string(frames_));
    }
    if (read == ChildProcess::Read::some) continue;
    if (silent_ms_ >= options_.stall_ms)
      return give_up("delivered no frame for " + std::to_string(options_.stall_ms) + " ms after frame " +
                     std::to_string(frames_) +
                     (info_.frame_count > 0 ? " of " + std::to_string(info_.frame_count) : std::string()));
    if (waited_ms >= timeout_ms)
      return Error{ErrorCode::timeout, path_text_ + ": no frame within " + std::to_string(timeout_ms) + " ms"};
  }
}

Status OniSource::start() {
  if (fresh_) return Ok{};
  return launch();
}

Result<FrameInfo> OniSource::next(DepthImage depth, int timeout_ms) {
  if (auto ok = path_.check(depth, path_text_); !ok) return ok.error();
  if (final_) return *final_;
  fresh_ = false;
  const auto header = receive(timeout_ms);
  if (!header) return header.error();
  have_ = 0;
  const std::byte* payload = message_.data() + sizeof(oni::Header);
  const std::size_t frame_bytes = sizeof(oni::Frame) + path_.pixel_count() * sizeof(std::uint16_t);
  if (header->kind == oni::Kind::frame && header->payload_bytes == frame_bytes) return accept_frame(depth);
  if (header->kind == oni::Kind::failure) return cannot_be_played(*header);
  if (header->kind != oni::Kind::end || header->payload_bytes != sizeof(oni::End))
    return give_up("has invalid data after frame " + std::to_string(frames_));
  oni::End end;
  std::memcpy(&end, payload, sizeof end);
  child_.reap();
  final_ =
      Error{ErrorCode::end_of_stream, path_text_ + ": all " + std::to_string(frames_) + " frames were delivered"};
  if (end.complete != 0) return *final_;
  book_.damaged();
  return Error{ErrorCode::corrupt, path_text_ + " was never closed by its recorder; the " + std::to_string(frames_) +
                                       " frames found were delivered"};
}

Result<FrameInfo> OniSource::accept_frame(DepthImage depth) {
  oni::Frame about;
  const std::byte* payload = message_.data() + sizeof(oni::Header);
  std::memcpy(&about, payload, sizeof about);
  if (about.timestamp_us > static_cast<std::uint64_t>(INT64_MAX / 1000))
    return give_up("has an impossible time after frame " + std::to_string(frames_));
  // The message's pixels begin 32 bytes into a vector: aligned for 16-bit values.
  const DepthView pixels(reinterpret_cast<const std::uint16_t*>(payload + sizeof about), path_.camera().width,
                         path_.camera().height);
  path_.deliver(pixels, depth);
  ++frames_;
  book_.saw(about.index);
  const auto time_us = static_cast<std::int64_t>(about.timestamp_us);
  return FrameInfo{about.index, time_us * 1000, time_us};
}

void OniSource::stop() {
  child_.end();
  fresh_ = false;
  if (!final_) final_ = Error{ErrorCode::end_of_stream, path_text_ + ": playing was stopped"};
}

}  // namespace im2fit::hal
