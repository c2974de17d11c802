// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/kinect_commands.h"

#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

namespace im2fit::hal {
namespace {

using namespace kinect;
using Clock = std::chrono::steady_clock;

constexpr int kTransfer_ms = 500;
constexpr auto kAnswerLimit = std::chrono::seconds(1);
constexpr std::size_t kWordsMax = 8;

void put16(std::uint8_t* p, std::uint16_t value) {
  p[0] = static_cast<std::uint8_t>(value & 0xFF);
  p[1] = static_cast<std::uint8_t>(value >> 8);
}

std::uint16_t get16(const std::uint8_t* p) {
  return static_cast<std::uint16_t>(p[0] | p[1] << 8);
}

float get_float(const std::uint8_t* p) {
  const std::uint32_t bits = static_cast<std::uint32_t>(get16(p)) | static_cast<std::uint32_t>(get16(p + 2)) << 16;
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

// Centimetres to whole nanometres; an invalid length becomes 0, which is_plausible() refuses.
std::int64_t nanometres(float length_cm) {
  const double length_nm = static_cast<double>(length_cm) * 1e7;
  return length_nm > 0 && length_nm < 1e13 ? static_cast<std::int64_t>(length_nm + 0.5) : 0;
}

std::string hex(unsigned value) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  do text.insert(text.begin(), kDigits[value % 16]);
  while ((value /= 16) > 0);
  return "0x" + text;
}

}  // namespace

Error KinectCommands::error(ErrorCode code, Opcode opcode, const std::string& why) const {
  return {code, what_ + ": command " + hex(static_cast<unsigned>(opcode)) + " " + why};
}

Result<std::vector<std::uint8_t>> KinectCommands::command(Opcode opcode, std::span<const std::uint16_t> words) {
  assert(words.size() <= kWordsMax);
  std::array<std::uint8_t, kCommandHeaderBytes + 2 * kWordsMax> out{};
  const std::uint16_t tag = tag_++;
  out[0] = kCommandMagic[0];
  out[1] = kCommandMagic[1];
  put16(&out[2], static_cast<std::uint16_t>(words.size()));
  put16(&out[4], static_cast<std::uint16_t>(opcode));
  put16(&out[6], tag);
  for (std::size_t i = 0; i < words.size(); ++i) put16(&out[kCommandHeaderBytes + 2 * i], words[i]);
  const auto sent = transport_.control_out(
      {kRequestOut, 0, 0, 0}, std::span(out).first(kCommandHeaderBytes + 2 * words.size()), kTransfer_ms);
  if (!sent) return error(sent.error().code, opcode, "cannot be sent: " + sent.error().message);

  std::vector<std::uint8_t> in(kReplyBytesMax);
  for (const auto deadline = Clock::now() + kAnswerLimit; Clock::now() < deadline;
       std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
    const auto got = transport_.control_in({kRequestIn, 0, 0, 0}, in, kTransfer_ms);
    if (!got) return error(got.error().code, opcode, "gets no reply: " + got.error().message);
    // Not ready: no bytes, or (some cameras) as many as there was room for.
    if (*got == 0 || *got == kReplyBytesMax) continue;
    if (*got < kCommandHeaderBytes || in[0] != kReplyMagic[0] || in[1] != kReplyMagic[1])
      return error(ErrorCode::io, opcode,
                   "got a reply of " + std::to_string(*got) + " bytes without the header of a reply");
    if (get16(&in[6]) != tag) continue;  // late, to a command given up before
    const std::size_t length = *got - kCommandHeaderBytes;
    if (get16(&in[4]) != static_cast<std::uint16_t>(opcode) || get16(&in[2]) * std::size_t{2} != length || length < 2)
      return error(ErrorCode::io, opcode, "got a reply that does not fit it (" + std::to_string(*got) + " bytes)");
    if (const std::uint16_t status = get16(&in[kCommandHeaderBytes]); status != 0)
      return error(ErrorCode::io, opcode, "was refused with code " + std::to_string(status));
    return std::vector<std::uint8_t>(in.begin() + kCommandHeaderBytes + 2,
                                     in.begin() + static_cast<std::ptrdiff_t>(*got));
  }
  return error(ErrorCode::timeout, opcode, "got no reply within a second; unplug the camera and plug it in again");
}

Status KinectCommands::write_register(Register which, std::uint16_t value) {
  const std::uint16_t words[] = {static_cast<std::uint16_t>(which), value};
  if (auto done = command(Opcode::write_register, words); !done)
    return Error{done.error().code, done.error().message + " (register " + hex(static_cast<unsigned>(which)) + ")"};
  return Ok{};
}

Result<std::uint16_t> KinectCommands::read_register(Register which) {
  const std::uint16_t words[] = {static_cast<std::uint16_t>(which)};
  const auto answer = command(Opcode::read_register, words);
  if (!answer) return answer.error();
  if (answer->size() < 2) return error(ErrorCode::io, Opcode::read_register, "got a reply without a value");
  return get16(answer->data());
}

Result<std::optional<ZeroPlane>> KinectCommands::zero_plane() {
  // A camera that does not know a command stalls or refuses it: then it reports none. One that is gone or hangs is
  // an error.
  const auto silent = [](const Error& e) { return e.code == ErrorCode::unsupported || e.code == ErrorCode::io; };
  const std::optional<ZeroPlane> none;
  const std::uint16_t all[5] = {};
  const auto fixed = command(Opcode::fixed_parameters, all);
  if (!fixed) {
    if (silent(fixed.error())) return none;
    return fixed.error();
  }
  constexpr std::size_t kOffset = kZeroPlaneOffset - 2;  // the status word is off already
  if (fixed->size() < kOffset + 16) return none;
  ZeroPlane plane;
  plane.emitter_nm = nanometres(get_float(fixed->data() + kOffset));
  plane.distance_nm = nanometres(get_float(fixed->data() + kOffset + 8));
  plane.pixel_nm = nanometres(get_float(fixed->data() + kOffset + 12));
  const std::uint16_t parameter[5] = {kConstantShiftParameter, 0, 1, kFps, 0};
  const auto shift = command(Opcode::algorithm_parameters, parameter);
  if (!shift && !silent(shift.error())) return shift.error();
  if (shift && shift->size() >= 2) plane.constant_shift = get16(shift->data());
  return is_plausible(plane) ? std::optional(plane) : none;
}

Status KinectCommands::start_depth() {
  static constexpr struct {
    Register which;
    std::uint16_t value;
  } kSteps[] = {{Register::projector_cycle, 0}, {Register::depth_stream, 0}, {Register::depth_format, 3},
                {Register::depth_size, 1},      {Register::depth_fps, kFps}, {Register::depth_stream, 2},
                {Register::depth_flip, 0}};
  for (const auto& step : kSteps)
    if (auto ok = write_register(step.which, step.value); !ok) return ok.error();
  return Ok{};
}

Status KinectCommands::stop_depth() {
  return write_register(Register::depth_stream, 0);
}

}  // namespace im2fit::hal
