// SPDX-License-Identifier: Apache-2.0
// Small sound recordings for fuzzers to start from.
#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <utility>

#include "hal/intrinsics.h"

namespace im2fit::fuzz {

// An element of EBML, whose size takes four bytes.
inline std::string ebml(std::uint32_t id, const std::string& payload) {
  std::string out;
  for (int shift = 24; shift >= 0; shift -= 8)
    if (id >> shift != 0) out += static_cast<char>(id >> shift & 0xFFU);
  const auto size = static_cast<std::uint32_t>(payload.size()) | 0x10000000U;
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(size >> shift & 0xFFU);
  return out + payload;
}
inline std::string ebml(std::uint32_t id, std::initializer_list<std::string> children) {
  std::string payload;
  for (const std::string& child : children) payload += child;
  return ebml(id, payload);
}

inline std::string bytes_of(std::uint64_t value, int size) {
  std::string out;
  for (int i = 0; i < size; ++i) out += static_cast<char>(value >> (8 * i) & 0xFFU);
  return out;
}
inline std::string float_bytes(float value) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}

// Of the accelerometer, in m/s2.
inline std::string imu_sample(float x, float y, float z) {
  return bytes_of(1, 8) + float_bytes(x) + float_bytes(y) + float_bytes(z) + std::string(20, '\0');
}

// An Azure Kinect's calibration for pictures of 8 x 6 pixels: the accelerometer has its z axis at the camera's y, its
// x axis behind the camera.
inline constexpr const char* kKinectCalibration =
    R"({"CalibrationInformation": {"Cameras": [{"Intrinsics": {"ModelParameters": [0.5, 0.5, 0.9375, 1.25, 0, 0, 0, 0,
 0, 0, 0, 0, 0, 0], "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"},
 "Purpose": "CALIBRATION_CameraPurposeDepth"}], "InertialSensors": [{"Rt": {"Rotation": [0, 0, -1, -1, 0, 0, 0, 1, 0]},
 "SensorType": "CALIBRATION_InertialSensorType_Accelerometer"}]}})";

// Two frames of 8 x 6 pixels; `imu`: also two samples in one block, with kKinectCalibration.
inline std::string matroska_recording(bool imu) {
  hal::Calibration calibration;
  calibration.intrinsics = {8, 6, 7.5F, 7.5F, 3.5F, 2.5F};
  calibration.distortion.coefficients = {0.1, -0.05, 0.001, 0.002, 0.01};
  const std::string head = ebml(0x1A45DFA3, {ebml(0x4282, "matroska")});
  const std::string track =
      ebml(0x1654AE6B, {ebml(0xAE, {ebml(0xD7, "\x01"), ebml(0x73C5, "\x05"), ebml(0x83, "\x01"),
                                    ebml(0x536E, "DEPTH"), ebml(0x86, "V_UNCOMPRESSED"),
                                    ebml(0xE0, {ebml(0xB0, "\x08"), ebml(0xBA, "\x06"), ebml(0x2EB524, "b16g")})}),
                        imu ? ebml(0xAE, {ebml(0xD7, "\x02"), ebml(0x83, "\x11"), ebml(0x86, "S_K4A/IMU")}) : ""});
  const std::string attached = ebml(
      0x1941A469, {ebml(0x61A7, {ebml(0x466E, "calibration.json"), ebml(0x46AE, "\x07"),
                                 ebml(0x465C, imu ? kKinectCalibration : hal::camera_yaml_text(calibration, "x"))})});
  const std::string tags =
      ebml(0x1254C367, {ebml(0x7373, {ebml(0x63C0, {ebml(0x63C5, "\x05")}),
                                      ebml(0x67C8, {ebml(0x45A3, "K4A_DEPTH_TRACK"), ebml(0x4487, "5")})}),
                        ebml(0x7373, {ebml(0x67C8, {ebml(0x45A3, "K4A_START_OFFSET_NS"), ebml(0x4487, "500")})})});
  const std::string pixels(std::size_t{8} * 6 * 2, '\x0B');
  const std::string clusters =
      ebml(0x1F43B675, {ebml(0xE7, std::string(1, '\0')), ebml(0xA3, std::string("\x81\0\0\x80", 4) + pixels),
                        imu ? ebml(0xA0, {ebml(0xA1, std::string("\x82\0\0\4\1", 5) + imu_sample(0, 0, -9.8F) +
                                                         imu_sample(0, 1, -9.8F))})
                            : ""}) +
      ebml(0x1F43B675, {ebml(0xE7, "\x21"), ebml(0xA0, {ebml(0xA1, std::string("\x81\0\x01\0", 4) + pixels)})});
  return head +
         ebml(0x18538067, {ebml(0x1549A966, {ebml(0x2AD7B1, "\x0F\x42\x40")}), track, attached, tags, clusters});
}

// A record of a rosbag.
inline std::string bag_record(std::initializer_list<std::string> fields, const std::string& data) {
  std::string head;
  for (const std::string& field : fields) head += bytes_of(field.size(), 4) + field;
  return bytes_of(head.size(), 4) + head + bytes_of(data.size(), 4) + data;
}
inline std::string bag_connection(int id, const std::string& topic, const std::string& type) {
  const std::string field = "type=" + type;
  return bag_record({"op=\7", "conn=" + bytes_of(static_cast<std::uint64_t>(id), 4), "topic=" + topic},
                    bytes_of(field.size(), 4) + field);
}

// Two frames of 4 x 3 pixels, with RealSense's topics or ROS's.
inline std::string bag_recording(bool realsense) {
  const std::string head = bytes_of(1, 4) + bytes_of(5, 8) + bytes_of(1, 4) + "d",
                    size = bytes_of(3, 4) + bytes_of(4, 4);
  const std::string encoding = realsense ? "mono16" : "16UC1";
  const std::string image = head + size + bytes_of(encoding.size(), 4) + encoding + std::string(1, '\0') +
                            bytes_of(8, 4) + bytes_of(24, 4) + std::string(24, '\x0B');
  std::string info = head + size + bytes_of(9, 4) + "plumb_bob" + bytes_of(5, 4) + std::string(40, '\0');
  const auto number = [](double value) {
    std::string out(8, '\0');
    std::memcpy(out.data(), &value, 8);
    return out;
  };
  for (const double value : {4.0, 0.0, 1.5, 0.0, 4.0, 1.0, 0.0, 0.0, 1.0}) info += number(value);
  info += std::string(std::size_t{21} * 8 + 25, '\0');
  const std::string depth = realsense ? "/device_0/sensor_0/Depth_0/image/data" : "/camera/depth/image_raw";
  const std::string camera = realsense ? "/device_0/sensor_0/Depth_0/info/camera_info" : "/camera/depth/camera_info";
  const auto message = [](int id, std::uint64_t time, const std::string& data) {
    return bag_record({"op=\2", "conn=" + bytes_of(static_cast<std::uint64_t>(id), 4), "time=" + bytes_of(time, 8)},
                      data);
  };
  const std::string connections =
      bag_connection(0, depth, "sensor_msgs/Image") + bag_connection(1, camera, "sensor_msgs/CameraInfo") +
      bag_connection(2, "/device_0/sensor_0/option/Depth_Units/value", "std_msgs/Float32");
  const std::string chunk = connections + message(2, 1, std::string("\x6F\x12\x83\x3A", 4)) + message(1, 1, info) +
                            message(0, 2, image) + message(0, 3, image);
  const auto index =
      bag_record({"op=\4", "conn=" + bytes_of(0, 4), "count=" + bytes_of(2, 4)}, std::string(24, '\0'));
  return "#ROSBAG V2.0\n" + bag_record({"op=\3", "index_pos=" + bytes_of(500, 8)}, "") +
         bag_record({"op=\5", "compression=none", "size=" + bytes_of(chunk.size(), 4)}, chunk) + index + connections;
}

// As archives have it: reflected, of the polynomial 0x04C11DB7.
inline std::uint32_t zip_checksum(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xEDB88320U : crc >> 1;
  }
  return ~crc;
}

// A depth folder of two frames of 2 x 2 pixels, in one folder. Deflated files hold one stored block.
inline std::string zip_archive(bool deflated) {
  hal::Calibration calibration;
  calibration.intrinsics = {2, 2, 2, 2, 0.5F, 0.5F};
  const std::pair<std::string, std::string> files[] = {{"a/camera.yaml", hal::camera_yaml_text(calibration, "x")},
                                                       {"a/000000.pgm", "P5 2 2 65535\n" + std::string(8, '\x0B')},
                                                       {"a/000001.pgm", "P5 2 2 65535\n" + std::string(8, '\x0C')},
                                                       {"a/timestamps.csv", "frame,host_ns\n0,1000\n1,2000\n"}};
  std::string out, directory;
  for (const auto& [name, text] : files) {
    const std::string size = bytes_of(text.size(), 2);
    const std::string data = deflated ? "\x01" + size + bytes_of(0xFFFFU - text.size(), 2) + text : text;
    const std::string about = bytes_of(20, 2) + bytes_of(0, 2) + bytes_of(deflated ? 8 : 0, 2) + bytes_of(0, 4) +
                              bytes_of(zip_checksum(text), 4) + bytes_of(data.size(), 4) + bytes_of(text.size(), 4) +
                              bytes_of(name.size(), 2) + bytes_of(0, 2);
    directory +=
        "PK\1\2" + bytes_of(20, 2) + about + bytes_of(0, 8) + bytes_of(0, 2) + bytes_of(out.size(), 4) + name;
    out += "PK\3\4" + about + name + data;
  }
  return out + directory + "PK\5\6" + bytes_of(0, 4) + bytes_of(4, 2) + bytes_of(4, 2) +
         bytes_of(directory.size(), 4) + bytes_of(out.size(), 4) + bytes_of(0, 2);
}

}  // namespace im2fit::fuzz
