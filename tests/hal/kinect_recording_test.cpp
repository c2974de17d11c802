// SPDX-License-Identifier: Apache-2.0
// Recordings of an Azure Kinect, written by ffmpeg and mkvmerge. mkvmerge's library is the one that k4arecorder uses,
// and its track is of the same kind.
#include "hal/recording/kinect_recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string_view>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"
#include "made_folder.h"
#include "other_programs.h"
#include "tests/fuzz/recording_seeds.h"

namespace im2fit::hal {
namespace {

constexpr int kWidth = 320, kHeight = 288;  // NFOV, binned

// The factory calibration of a real camera, with its lens.
constexpr const char* kCalibration =
    R"({"CalibrationInformation": {"Cameras": [
{"Intrinsics": {"ModelParameterCount": 14, "ModelParameters": [0.5122697949409485, 0.49451231956481934,
 0.4921168386936188, 0.4921667277812958, 3.1305770874023438, 2.324939012527466, 0.1304156482219696, 3.458651542663574,
 3.350114583969116, 0.6629416346549988, 0, 0, -0.0000511557373101823, 0.00008132171933539212],
 "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"}, "Location": "CALIBRATION_CameraLocationD0",
 "Purpose": "CALIBRATION_CameraPurposeDepth", "SensorHeight": 1024, "SensorWidth": 1024}]}})";

class KinectRecording : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }

  // frames/ is a depth folder of four frames, raw the same as ffmpeg takes it.
  void SetUp() override {
    if (!have_program("ffmpeg") || !have_program("mkvmerge"))
      GTEST_SKIP() << "no ffmpeg or mkvmerge: scripts/deps test";
    put(path("calibration.json"), kCalibration);
    auto writer = FolderWriter::create(path("frames"), camera_of(kWidth, kHeight), {});
    ASSERT_TRUE(writer) << writer.error().message;
    std::ofstream raw(path("raw"), std::ios::binary);
    for (std::uint64_t i = 0; i < 4; ++i) {
      const Picture picture = random_picture(kWidth, kHeight, i);
      ASSERT_TRUE((*writer)->write(picture.view(), FrameInfo{i}));
      append_big_endian(raw, picture.view());
    }
    ASSERT_TRUE((*writer)->finish());
  }

  bool ffmpeg_writes(const std::string& name, const std::string& more) const {
    return run_in(folder_.path(),
                  "ffmpeg -nostdin -y -f rawvideo -pix_fmt gray16be -s 320x288 -r 30 -i raw "
                  "-c:v rawvideo -tag:v b16g -strict -2 -metadata:s:v title=DEPTH " +
                      more + " " + name);
  }
  static std::string attached() { return "-attach calibration.json -metadata:s:t mimetype=application/octet-stream"; }
  // An .avi on the way gives the track Microsoft's header. Its pixels are those of raw, whatever they are called.
  bool mkvmerge_writes(const std::string& name, const std::string& more) const {
    return run_in(
        folder_.path(),
        "ffmpeg -nostdin -y -f rawvideo -pix_fmt yuyv422 -s 320x288 -r 30 -i raw -c:v rawvideo -vtag b16g -strict -2 "
        "raw.avi && mkvmerge -o " +
            name + " " + more + " raw.avi");
  }

  // Frame by frame the bits of the depth folder with the same calibration.
  void expect_frames(const std::string& name, std::size_t count, const OpenOptions& options = {}) const {
    OpenOptions with_camera = options;
    with_camera.camera_yaml_path = path("calibration.json");
    auto folder = open_source(path("frames"), with_camera);
    ASSERT_TRUE(folder) << folder.error().message;
    auto source = open_source(path(name), options);
    ASSERT_TRUE(source) << source.error().message;
    const Intrinsics k = (*source)->info().intrinsics, expected_k = (*folder)->info().intrinsics;
    EXPECT_EQ(k.fx, expected_k.fx);
    EXPECT_EQ(k.cx, expected_k.cx);
    EXPECT_EQ(k.width, expected_k.width);
    EXPECT_EQ((*source)->info().frame_count, static_cast<std::int64_t>(count));
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE((*source)->start());
      ASSERT_TRUE((*folder)->start());
      Picture out(k.width, k.height), expected(k.width, k.height);
      for (std::size_t i = 0; i < count; ++i) {
        const auto frame = (*source)->next(out.image(), 0);
        ASSERT_TRUE(frame) << frame.error().message;
        ASSERT_TRUE((*folder)->next(expected.image(), 0));
        EXPECT_EQ(out.pixels, expected.pixels) << i;
        EXPECT_EQ(frame->sequence, i);
        EXPECT_NEAR(static_cast<double>(frame->host_ns), static_cast<double>(i) / 30 * 1e9, 1e6);
      }
      EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
      EXPECT_EQ((*source)->stats().delivered, count);
    }
  }

  std::string refused(const std::string& name, const OpenOptions& options = {}) const {
    const auto source = open_source(path(name), options);
    EXPECT_FALSE(source);
    if (source) return "";
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, name)) << source.error().message;
    return source.error().message;
  }

  std::string bytes_of(const std::string& name) const {
    const auto bytes = read_file(path(name));
    EXPECT_TRUE(bytes);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "";
  }

  TestFolder folder_;
};

TEST_F(KinectRecording, FfmpegsFileHasTheFoldersBitsAndTheFactoryLens) {
  ASSERT_TRUE(ffmpeg_writes("a.mkv", attached() + " -metadata K4A_START_OFFSET_NS=5000000"));
  expect_frames("a.mkv", 4);
  OpenOptions turned;
  turned.rotate_deg = 90;
  expect_frames("a.mkv", 4, turned);
  const auto source = open_source(path("a.mkv"));
  ASSERT_TRUE(source) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_NEAR(info.intrinsics.fx, 503.927643 / 2, 1e-3);
  EXPECT_EQ(info.intrinsics_origin, IntrinsicsOrigin::recording);
  EXPECT_EQ(info.sensor, SensorKind::time_of_flight);
  EXPECT_FALSE(info.live);
  Picture out(kWidth, kHeight);
  const auto frame = (*source)->next(out.image(), 0);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->device_us, 5000) << "the device's clock began before the recording";
  EXPECT_NE(out.pixels, random_picture(kWidth, kHeight, 0).pixels) << "the lens is undone";
}

TEST_F(KinectRecording, TheRecordersOwnKindOfTrackIsFoundAmongOthers) {
  ASSERT_TRUE(mkvmerge_writes("plain.mkv", "--attachment-name calibration.json --attach-file calibration.json"));
  expect_frames("plain.mkv", 4);
  // Infrared has the same kind of pictures; neither order nor size tells them apart.
  ASSERT_TRUE(run_in(folder_.path(),
                     "head -c 737280 /dev/zero >dark && ffmpeg -nostdin -y -f rawvideo -pix_fmt yuyv422 "
                     "-s 320x288 -r 30 -i dark -c:v rawvideo -vtag b16g -strict -2 dark.avi"));
  const std::string infrared =
      "--track-name 0:IR dark.avi --track-name 0:DEPTH --attachment-name calibration.json --attach-file "
      "calibration.json";
  ASSERT_TRUE(mkvmerge_writes("two.mkv", infrared));
  expect_frames("two.mkv", 4);
  ASSERT_TRUE(mkvmerge_writes("unnamed.mkv", "dark.avi --attach-file calibration.json"));
  EXPECT_TRUE(contains(refused("unnamed.mkv"), "no track of depth")) << "two tracks, and no name";
}

TEST_F(KinectRecording, ACalibrationCanBeGivenAndMustFit) {
  ASSERT_TRUE(ffmpeg_writes("a.mkv", ""));
  EXPECT_TRUE(contains(refused("a.mkv"), "no calibration.json; give the camera's calibration by --camera"));
  OpenOptions options;
  options.camera_yaml_path = path("calibration.json");
  expect_frames("a.mkv", 4, options);
  put(path("other.yaml"), yaml_of(camera_of(640, 480), "other", 0));
  options.camera_yaml_path = path("other.yaml");
  EXPECT_TRUE(contains(refused("a.mkv", options), "is for 640x480"));
  options = {};
  options.unit_mm = 10;
  EXPECT_TRUE(contains(refused("a.mkv", options), "a unit can be given"));
}

TEST_F(KinectRecording, AFileCutOffGivesItsWholeFramesAndOneLine) {
  ASSERT_TRUE(ffmpeg_writes("whole.mkv", attached()));
  const std::string whole = bytes_of("whole.mkv");
  const std::size_t frame_bytes = kWidth * kHeight * 2;
  ASSERT_GT(whole.size(), 4 * frame_bytes);
  put(path("cut.mkv"), whole.substr(0, whole.size() - frame_bytes));
  auto source = open_source(path("cut.mkv"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  EXPECT_EQ((*source)->info().frame_count, 3);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE((*source)->next(out.image(), 0)) << i;
  const auto damage = (*source)->next(out.image(), 0);
  ASSERT_FALSE(damage);
  EXPECT_EQ(damage.error().code, ErrorCode::corrupt);
  EXPECT_TRUE(contains(damage.error().message, "cut off")) << damage.error().message;
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
  EXPECT_EQ((*source)->stats().damaged, 1U);
  // Wherever it ends: frames or one line, and never more than there are.
  for (std::size_t size = 0; size < whole.size(); size += size < 2500 ? 7 : 20011) {
    put(path("any.mkv"), whole.substr(0, size));
    auto any = open_source(path("any.mkv"));
    if (!any) {
      EXPECT_FALSE(contains(any.error().message, "\n"));
      EXPECT_TRUE(contains(any.error().message, "any.mkv")) << any.error().message;
      continue;
    }
    std::size_t frames = 0;
    while ((*any)->next(out.image(), 0)) ++frames;
    EXPECT_LE(frames * frame_bytes, size);
    EXPECT_GT((frames + 1) * frame_bytes + 2500, size);
  }
}

TEST_F(KinectRecording, OtherFilesAreRefusedByWhatTheyAre) {
  put(path("empty.mkv"), "");
  EXPECT_TRUE(contains(refused("empty.mkv"), "is not a Matroska file"));
  put(path("text.mkv"), "hello, I am no film");
  EXPECT_TRUE(contains(refused("text.mkv"), "is not a Matroska file"));
  std::filesystem::create_directory(path("folder.mkv"));
  EXPECT_FALSE(open_source(path("folder.mkv")));
  ASSERT_TRUE(run_in(folder_.path(),
                     "ffmpeg -nostdin -y -f rawvideo -pix_fmt gray16be -s 320x288 -r 30 -i raw -c:v "
                     "ffv1 -metadata:s:v title=VIDEO film.mkv"));
  EXPECT_TRUE(contains(refused("film.mkv"), "no track of depth (its tracks: VIDEO V_MS/VFW/FOURCC)"))
      << refused("film.mkv");
  ASSERT_TRUE(run_in(folder_.path(), "mkvmerge -o named.mkv --track-name 0:DEPTH film.mkv"));
  EXPECT_TRUE(contains(refused("named.mkv"), "the track of depth is V_MS/VFW/FOURCC")) << refused("named.mkv");
  ASSERT_TRUE(mkvmerge_writes("small.mkv", "--compression 0:zlib --attach-file calibration.json"));
  EXPECT_TRUE(contains(refused("small.mkv"), "compressed; write it plain")) << refused("small.mkv");
  put(path("calibration.json"), "{\"CalibrationInformation\": {\"Cameras\": []}}");
  ASSERT_TRUE(ffmpeg_writes("blind.mkv", attached()));
  EXPECT_TRUE(contains(refused("blind.mkv"), "(calibration.json): CalibrationInformation.Cameras"));
  put(path("calibration.json"), "\"" + std::string(2 << 20, 'x') + "\"");
  ASSERT_TRUE(ffmpeg_writes("long.mkv", attached()));
  EXPECT_TRUE(contains(refused("long.mkv"), "expected at most 1048576")) << refused("long.mkv");
}

TEST_F(KinectRecording, AWrongTimeCostsOneFrame) {
  ASSERT_TRUE(ffmpeg_writes("a.mkv", attached()));
  std::string bytes = bytes_of("a.mkv");
  const std::string_view block("\xA3\x22\xD0\x04\x81\0\0",
                               7);  // a frame's size, its track, and no time in its cluster
  std::size_t at = 0;
  for (int i = 0; i < 3; ++i) at = bytes.find(block, at + 1);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 5] = '\x7F';
  auto source = open_kinect_recording(FileCursor(std::as_bytes(std::span(bytes)), "a.mkv"), {});
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kWidth, kHeight);
  for (int i = 0; i < 4; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    ASSERT_EQ(static_cast<bool>(frame), i != 2) << i;
    if (!frame) {
      EXPECT_EQ(frame.error().code, ErrorCode::corrupt);
    }
  }
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
}

// Bytes of the table of contents and of blocks' heads, one at a time.
TEST_F(KinectRecording, AChangedByteGivesFramesOrOneLine) {
  ASSERT_TRUE(ffmpeg_writes("whole.mkv", attached()));
  const std::string whole = bytes_of("whole.mkv");
  Picture out(kWidth, kHeight);
  const std::size_t head = std::min(whole.find(std::string("\x1F\x43\xB6\x75", 4)) + 30, whole.size());
  for (std::size_t at = 0; at < head; ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (at % 2 == 0 ? 0xFF : 0x81));
    auto file = FileCursor(std::as_bytes(std::span(bytes)), "changed.mkv");
    auto source = open_kinect_recording(std::move(file), {});
    if (!source) {
      EXPECT_FALSE(contains(source.error().message, "\n")) << at;
      continue;
    }
    const Intrinsics k = (*source)->info().intrinsics;
    Picture picture(k.width, k.height);
    int calls = 0;
    for (; calls < 10; ++calls) {
      const auto frame = (*source)->next(picture.image(), 0);
      if (!frame && frame.error().code == ErrorCode::end_of_stream) break;
    }
    EXPECT_LT(calls, 10) << at;
  }
}

// The accelerometer of fuzz::kKinectCalibration has its x axis behind the camera, y at its left and z below it.
Vec3f down_of_samples(const std::vector<std::string>& samples) {
  const std::string bytes = [&] {
    std::string out = fuzz::matroska_recording(true);
    const std::string first = fuzz::imu_sample(0, 0, -9.8F), second = fuzz::imu_sample(0, 1, -9.8F);
    out.replace(out.find(first), first.size(), samples[0]);
    out.replace(out.find(second), second.size(), samples[1]);
    return out;
  }();
  auto source = open_kinect_recording(FileCursor(std::as_bytes(std::span(bytes)), "a.mkv"), {});
  EXPECT_TRUE(source) << source.error().message;
  Picture out(8, 6);
  Vec3f down;
  for (int i = 0; i < 2; ++i) {
    const auto frame = (*source)->next(out.image(), 0);
    EXPECT_TRUE(frame) << frame.error().message;
    down = frame->down.value_or(Vec3f{0, 0, 0});
  }
  EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
  return down;
}

TEST(KinectGravity, ManySamplesInOneBlockGiveOneDirection) {
  // Two that differ: their mean.
  const Vec3f mean = down_of_samples({fuzz::imu_sample(0, 1, -9.8F), fuzz::imu_sample(0, -1, -9.8F)});
  EXPECT_NEAR(mean.x, 0, 1e-5);
  EXPECT_NEAR(mean.y, 1, 1e-5);
  EXPECT_NEAR(mean.z, 0, 1e-5);
  // A camera that looks at the floor by 30 degrees: what holds it points up and, with a part, behind it.
  const std::string tilted = fuzz::imu_sample(4.9F, 0, -8.487F);
  const Vec3f down = down_of_samples({tilted, tilted});
  EXPECT_NEAR(down.y, 0.866, 1e-3);
  EXPECT_NEAR(down.z, 0.5, 1e-3);
  // A camera that is moved, and one that falls, tell nothing.
  for (const float force : {-6.0F, -13.0F, 0.0F}) {
    const std::string moved = fuzz::imu_sample(0, 0, force);
    EXPECT_EQ(norm(down_of_samples({moved, moved})), 0) << force;
  }
}

// mkvmerge writes subtitles in the kind of blocks in which the recorder writes its samples. Their texts, of 40
// letters each, are replaced.
TEST_F(KinectRecording, GravityIsThatOfTheAccelerometersTrack) {
  std::string text = kCalibration;
  const std::string end = "]}}";
  text.replace(text.rfind(end), end.size(),
               R"(], "InertialSensors": [{"Rt": {"Rotation": [0.0003031194501090795, 0.1085868701338768,
 -0.9940869212150574, -0.9999820590019226, -0.005916988011449575, -0.000951246009208262, -0.005985293071717024,
 0.9940693378448486, 0.10858312249183655]}, "SensorType": "CALIBRATION_InertialSensorType_Accelerometer"}]}})");
  put(path("calibration.json"), text);
  const std::string letters[] = {std::string(40, 'a'), std::string(40, 'b')};
  put(path("imu.srt"), "1\n00:00:00,000 --> 00:00:00,020\n" + letters[0] + "\n\n2\n00:00:00,050 --> 00:00:00,070\n" +
                           letters[1] + "\n\n");
  ASSERT_TRUE(mkvmerge_writes("a.mkv", "--compression 0:none imu.srt --attach-file calibration.json"));
  std::string bytes = bytes_of("a.mkv");
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = bytes.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    bytes.replace(at, from.size(), to);
  };
  replace("S_TEXT/UTF8", std::string("S_K4A/IMU\0\0", 11));
  // Level: the depth camera of this device looks 6.2 degrees below its casing. Then rolled by 20 degrees.
  replace(letters[0], fuzz::imu_sample(0, 0, -9.81F));
  replace(letters[1], fuzz::imu_sample(0, -3.355F, -9.218F));
  put(path("a.mkv"), bytes);
  for (const int rotate : {0, 90}) {
    OpenOptions options;
    options.rotate_deg = rotate;
    auto source = open_source(path("a.mkv"), options);
    ASSERT_TRUE(source) << source.error().message;
    Picture out((*source)->info().intrinsics.width, (*source)->info().intrinsics.height);
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE((*source)->start());
      for (int i = 0; i < 4; ++i) {
        const auto frame = (*source)->next(out.image(), 0);
        ASSERT_TRUE(frame) << frame.error().message;
        ASSERT_TRUE(frame->down) << i;
        const Vec3f level = rotate_upright(Vec3f{-0.006F, 0.994F, 0.1086F}, rotate);
        const bool turned = i >= 2;  // after 50 ms the mean of both is half as much rolled
        EXPECT_NEAR(dot(*frame->down, level), turned ? 0.9848 : 1, 1e-3) << i;
        EXPECT_NEAR(norm(*frame->down), 1, 1e-5);
      }
    }
  }
}

}  // namespace
}  // namespace im2fit::hal
