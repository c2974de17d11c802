// SPDX-License-Identifier: Apache-2.0
// Sound input for the fuzzers of cameras, of texts and of the page to start from: write_camera_seeds DIRECTORY makes
// camera_yaml/, oni_protocol/, kinect_recording/, bag_recording/, zip/, depth_picture/, folder_times/,
// pose_table/, recorder_text/, scan/, shop/, regions/, statistics/, size_chart/ and http/.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/file.h"
#include "hal/intrinsics.h"
#include "hal/openni2/oni_protocol.h"
#include "recording_seeds.h"

namespace {

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A recording of two frames of 4 x 3 pixels.
std::string two_frames(bool complete) {
  namespace oni = im2fit::hal::oni;
  std::string out;
  oni::Hello hello;
  hello.width = 4;
  hello.height = 3;
  hello.fps = 30;
  hello.frame_count = complete ? 2 : -1;
  hello.horizontal_rad = 1.0F;
  hello.vertical_rad = 0.8F;
  append(out, oni::Header{oni::kMagic, oni::Kind::hello, sizeof hello, 0});
  append(out, hello);
  for (std::uint32_t i = 1; i <= 2; ++i) {
    append(out, oni::Header{oni::kMagic, oni::Kind::frame, sizeof(oni::Frame) + 24, 0});
    append(out, oni::Frame{i, i * 33333});
    out.append(24, static_cast<char>(i));
  }
  append(out, oni::Header{oni::kMagic, oni::Kind::end, sizeof(oni::End), 0});
  append(out, oni::End{complete ? 1U : 0U});
  return out;
}

// A figure of two tubes as tall and wide as a person, mm.
std::string figure_obj() {
  std::string out = "\x01";
  for (int row = 0; row < 60; ++row)
    for (int i = 0; i < 12; ++i) {
      char line[64];
      const double angle = i * 0.5236, wide = row < 50 ? 180 : 80;
      std::snprintf(line, sizeof line, "v %.0f %d %.0f\n", wide * std::sin(angle), 29 * row,
                    0.6 * wide * std::cos(angle));
      out += line;
    }
  for (int row = 0; row < 59; ++row)
    for (int i = 0; i < 12; ++i) {
      const int a = 12 * row + i + 1, b = 12 * row + (i + 1) % 12 + 1;
      out += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(b + 12) + " " +
             std::to_string(a + 12) + "\n";
    }
  return out;
}

// A mesh of one triangle.
std::string glb() {
  std::string tree =
      R"({"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],"bufferViews":[{"buffer":0}]})";
  tree.resize((tree.size() + 3) / 4 * 4, ' ');
  const std::string points(36, '\x3F');
  std::string out = "glTF";
  const auto add = [&](std::size_t number) { append(out, static_cast<std::uint32_t>(number)); };
  add(2);
  add(12 + 8 + tree.size() + 8 + points.size());
  add(tree.size());
  out += "JSON" + tree;
  add(points.size());
  out += std::string("BIN\0", 4) + points;
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("write_camera_seeds: expected a directory\n", stderr), 2;
  using namespace im2fit;
  const std::string root = argv[1];
  hal::Calibration plain;
  plain.intrinsics = {32, 24, 30.5F, 30.25F, 15.5F, 11.5F};
  plain.rotate_deg = 90;
  hal::Calibration bent = plain;
  bent.distortion.coefficients = {0.1, -0.05, 0.001, 0.002, 0.01};
  const std::pair<const char*, std::string> kSeeds[] = {
      {"camera_yaml/plain", hal::camera_yaml_text(plain, "camera")},
      {"camera_yaml/bent", hal::camera_yaml_text(bent, "camera") + "im2fit_oni_crc32c: \"0123abcd\"\n"},
      {"camera_yaml/xml",
       "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>32</image_width>\n<image_height>24</image_height>\n"
       "<M1 type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><data>\n30 0. 15. 0. 30 11 0 0 1</data></M1>\n"
       "<distortion_coefficients><data>0.1 0 0 0</data></distortion_coefficients></opencv_storage>\n"},
      {"camera_yaml/realsense",
       " Intrinsic of \"Depth\" / 32x24 / {Z16}\n  Width: \t32\n  Height: \t24\n  PPX: \t15\n  PPY: \t11\n  Fx: "
       "\t30\n"
       "  Fy: \t30\n  Distortion: \tBrown Conrady\n  Coeffs: \t0 \t0 \t0 \t0 \t0\n\n"},
      {"camera_yaml/kinect",
       "{\"CalibrationInformation\": {\"Cameras\": [{\"Intrinsics\": {\"ModelParameters\": [0.5, 0.5, 0.9, 1.2, 3, "
       "2, 0.1, "
       "3, 3, 0.6, 0, 0, 0.001, 0.002], \"ModelType\": \"CALIBRATION_LensDistortionModelBrownConrady\"}, "
       "\"Location\": "
       "\"CALIBRATION_CameraLocationD0\"}]}}"},
      {"camera_yaml/orbbec",
       "{\"depth_intrinsic\": {\"fx\": 30, \"fy\": 30, \"cx\": 15, \"cy\": 11, \"width\": 32, \"height\": 24}, "
       "\"depth_distortion\": {\"k1\": 0.1, \"k2\": 0.2, \"p1\": 0.001, \"model\": \"Brown Conrady\"}, \"k3\": 0.1}"},
      {"camera_yaml/kalibr",
       "cam0:\n  camera_model: pinhole\n  intrinsics: [30, 30, 15, 11]\n  distortion_coeffs: [0.1, 0, 0, 0]\n"
       "  distortion_model: radtan\n  resolution: [32, 24]\n"},
      {"camera_yaml/matrix", "30, 0, 15\n0, 30, 11\n0, 0, 1\n"},
      {"camera_yaml/record3d",
       "{\"w\": 48, \"h\": 36, \"K\": [45, 0, 0, 0, 45, 0, 23, 17, 1], \"dw\": 32, \"dh\": 24, \"poses\": [[0]]}"},
      {"oni_protocol/whole", two_frames(true)},
      {"oni_protocol/unclosed", two_frames(false)},
      {"bag_recording/realsense", fuzz::bag_recording(true)},
      {"bag_recording/ros", fuzz::bag_recording(false)},
      {"kinect_recording/two", fuzz::matroska_recording(false)},
      {"kinect_recording/gravity", fuzz::matroska_recording(true)},
      {"zip/stored", fuzz::zip_archive(false)},
      {"zip/deflated", fuzz::zip_archive(true)},
      {"depth_picture/pgm", std::string("P5 4 2 65535\n") + std::string(16, '\x0B')},
      {"folder_times/both", "frame,host_ns,device_us\n0,1000,1\n1,2000,2\n2,3000,3\n"},
      {"folder_times/spreadsheet", "\xEF\xBB\xBF\"frame\";\"host_ns\";\r\n0;1000;\r\n1;2000;\r\n2;3000;\r\n"},
      {"pose_table/poses", "\x03sequence,x_m,y_m,z_m,qx,qy,qz,qw\n0,1,2,3,0,0.6,0,0.8\n1,1,2,3e-1,1,0,0,0\n"},
      {"pose_table/odometry",
       "\x01timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy, distortion_center_x\n"
       "1.5, 000000, 0, 1, 0, 1, 0, 0, 0, 1440, 1440, 960, 720, \n2.5, 000001, 0, 1, 0, 1, 0, 0, 0, 1450, 1450, 960, "
       "720, \n"},
      {"pose_table/headerless",
       "\x01"
       "0, 1, 0, 1, 0, 0, 0\n0, 1, 0, 1e-3, 0, 0, 1"},
      {"pose_table/matrix",
       "\x02"
       "1440.5, 0, 955.1\n0, 1440.5, 722.9\n0, 0, 1"},
      {"recorder_text/frames",
       std::string(1, '\0') + "# depth maps\n1305031102.160407 depth/1305031102.160407.png\n"},
      {"recorder_text/poses", "\x01# x\n1305031102.1758 1.3405 0.6266 1.6575 0.6574 0.6126 -0.2949 -0.3248\n"},
      {"recorder_text/frame",
       "\x02{\"time\": 5, \"intrinsics\": [1443, 0, 955, 0, 1443, 722, 0, 0, 1], \"cameraPoseARFrame\": [0, 1, 0, "
       "0.5, -1, "
       "0, 0, 1.4, 0, 0, 1, 0, 0, 0, 0, 1]}"},
      {"scan/ply", std::string(1, '\0') +
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
                       "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
                       "0\n3 0 1 2\n"},
      {"scan/ply_binary", std::string(1, '\0') +
                              "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty "
                              "float y\nproperty float z\nend_header\n" +
                              std::string(24, '\x3F')},
      {"scan/obj", "\x01v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2/2 -1//3\n"},
      {"scan/figure", figure_obj()},
      {"scan/glb", "\x02" + glb()},
      {"scan/pcd",
       "\x03VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
       "ascii\n1 2 3\n"},
      {"scan/pcd_packed",
       "\x03VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
       "binary_compressed\n" +
           std::string("\x0D\0\0\0\x0C\0\0\0\x0B", 9) + std::string(12, '\x3F')},
      {"shop/whole",
       R"({"schema": "im2fit.shop/1", "name": "Müller", "colours": {"light": {"accent": "#17566d", "paper": "#ffffff"},
       "dark": {"accent": "#8fd0e6", "paper": "#15181c"}}, "consent": {"version": "2", "operator": "Müller GmbH",
       "purpose": {"en": "to find your size", "de": "um Ihre Größe zu finden"}, "contact": "datenschutz@example.org"}})"},
      {"shop/logo", R"({"schema": "im2fit.shop/1", "name": "Shop", "logo": "logo.png"})"},
      {"regions/two", R"({"schema": "im2fit.regions/1", "cameras": {"Kinect": "-0.6,1.5,0.6,3", "a": "0,1,2,3"}})"},
      {"regions/text", "-0.6,1.5,0.6,3"},
      {"statistics/month",
       "period,what,name,count\n2026-11-30,visits,,14\n2026-11-30,measured,,11\n2026-11,size,M,5\n"
       "2026-11,not_measured,MOVING,2\n"},
      {"size_chart/chart",
       "# name: A\n# sex: any\n# unit: mm\n# source: x\n# date: 2020\nsize;low_mm;high_mm\nS;860,5;940\n"},
      {"size_chart/shop",
       "Size,Chest (cm),Waist (in)\nS,86-94,\"31\"\nM,94\xE2\x80\x93"
       "102,33\n"},
      {"size_chart/trousers",
       "# name: A\n# sex: men\n# unit: in\n# source: x\n# date: 1\nSize,waist,inseam\nW32/L34,32,34\n"},
      {"http/get", "GET /result.json HTTP/1.1\r\nHost: localhost:1\r\nAccept-Encoding: gzip\r\n\r\n"},
      {"http/foreign",
       "GET /events HTTP/1.1\r\nHost: 127.a.example\r\nOrigin: null\r\nSec-Fetch-Site: cross-site\r\n\r\n"},
      {"http/post", "POST / HTTP/1.1\r\nHost: [::1]\r\nTransfer-Encoding: chunked\r\n\r\n2\r\nab\r\n0\r\n\r\n"}};
  for (const auto& [name, text] : kSeeds) {
    std::filesystem::create_directories(std::filesystem::path(root + "/" + name).parent_path());
    if (const auto s = write_file_atomically(root + "/" + name, text); !s)
      return std::fprintf(stderr, "write_camera_seeds: %s\n", s.error().message.c_str()), 1;
  }
  return 0;
}
