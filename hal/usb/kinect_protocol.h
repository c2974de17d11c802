// SPDX-License-Identifier: Apache-2.0
// The Kinect for Xbox 360 on the wire: facts found and published by the OpenKinect project (its wiki's "Protocol
// Documentation" and libfreenect's sources). All numbers are little-endian unless noted.
#pragma once

#include <cstddef>
#include <cstdint>

namespace im2fit::hal::kinect {

inline constexpr std::uint16_t kVendor = 0x045E;
inline constexpr std::uint16_t kCamera = 0x02AE;
inline constexpr std::uint16_t kCameraForWindows = 0x02BF;  // has no motor device of its own
inline constexpr std::uint16_t kMotor = 0x02B0;

// ---- Commands to the camera: a vendor request out carries header and words, one in fetches the answer (no bytes:
// not ready). Header: two magic bytes, length in words without the header, opcode, tag; 16 bits each. The answer
// repeats opcode and tag, and its first word is 0 when the command was obeyed.
inline constexpr std::uint8_t kRequestOut = 0x40;
inline constexpr std::uint8_t kRequestIn = 0xC0;
inline constexpr std::uint8_t kCommandMagic[2] = {'G', 'M'};
inline constexpr std::uint8_t kReplyMagic[2] = {'R', 'B'};
inline constexpr std::size_t kCommandHeaderBytes = 8;
inline constexpr std::size_t kReplyBytesMax = 512;

enum class Opcode : std::uint16_t {
  read_register = 0x02,
  write_register = 0x03,
  fixed_parameters = 0x04,      // five words of 0; the answer has the zero plane at kZeroPlaneOffset
  algorithm_parameters = 0x16,  // words: parameter, format, resolution, frames a second, offset
};

// Four 32-bit floats: emitter to depth camera (cm), depth to colour camera (cm), reference distance (cm), size of a
// pixel on the reference plane (cm; of the sensor's 1280 columns).
inline constexpr std::size_t kZeroPlaneOffset = 94;
inline constexpr std::uint16_t kConstantShiftParameter = 0x00;  // answer: status, shift

enum class Register : std::uint16_t {
  depth_stream = 0x06,      // 0 off, 2 on
  depth_format = 0x12,      // 3: 11 bits a pixel, packed
  depth_size = 0x13,        // 1: 640 x 480
  depth_fps = 0x14,         // 30
  depth_flip = 0x17,        // 1: mirrored
  projector_cycle = 0x105,  // 1: the projector goes off and on by itself
};

// ---- Depth packets: endpoint 0x82, isochronous. Header: 'R' 'B', 0, flag, ?, number (8 bits, over all packets of
// the stream), ?, ?, time (32 bits, 60 MHz); 1748 bytes of the picture's 422,400 follow, fewer in the last packet.
inline constexpr std::uint8_t kDepthEndpoint = 0x82;
inline constexpr std::size_t kPacketHeaderBytes = 12;
inline constexpr std::size_t kPacketPayloadBytes = 1748;
inline constexpr std::size_t kPacketBytesMax = kPacketHeaderBytes + kPacketPayloadBytes;
enum PacketFlag : std::uint8_t { kStart = 0x71, kMiddle = 0x72, kEnd = 0x75 };
inline constexpr int kWidth = 640;
inline constexpr int kHeight = 480;
inline constexpr int kFps = 30;
inline constexpr std::size_t kFrameBytes = std::size_t{kWidth} * kHeight * 11 / 8;
inline constexpr int kPacketsPerFrame =
    static_cast<int>((kFrameBytes + kPacketPayloadBytes - 1) / kPacketPayloadBytes);
inline constexpr std::size_t kLastPayloadBytes = kFrameBytes - (kPacketsPerFrame - 1) * kPacketPayloadBytes;
inline constexpr std::uint32_t kTicksPerUs = 60;

// ---- Motor and accelerometer: a device of their own, with vendor requests.
inline constexpr std::uint8_t kMotorState = 0x32;  // in, 10 bytes: ?, ?, x, y, z (16 bits, big-endian), tilt, status
inline constexpr std::uint8_t kMotorSetTilt = 0x31;  // out, value: twice the degrees from the horizon, up positive
inline constexpr std::size_t kMotorStateBytes = 10;
inline constexpr int kCountsPerG = 819;  // Kionix KXSD9
inline constexpr int kTiltMax_deg = 31;
enum MotorStatus : std::uint8_t { kStopped = 0x00, kAtLimit = 0x01, kMoving = 0x04 };
inline constexpr std::int8_t kTiltUnknown = -128;  // while it moves

}  // namespace im2fit::hal::kinect
