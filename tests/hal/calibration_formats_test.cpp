// SPDX-License-Identifier: Apache-2.0
// Calibrations in the words of other programs. The texts are as those programs write them; none is of our own writer.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "hal/folder/camera_yaml.h"
#include "made_folder.h"

namespace im2fit::hal {
namespace {

Result<CameraFile> parsed(const std::string& text, PictureSize pictures = {}) {
  return parse_camera_yaml(text, "camera", pictures);
}

void expect_lens(const Result<CameraFile>& file, const Intrinsics& k) {
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->intrinsics.width, k.width);
  EXPECT_EQ(file->intrinsics.height, k.height);
  EXPECT_NEAR(file->intrinsics.fx, k.fx, 1e-3);
  EXPECT_NEAR(file->intrinsics.fy, k.fy, 1e-3);
  EXPECT_NEAR(file->intrinsics.cx, k.cx, 1e-3);
  EXPECT_NEAR(file->intrinsics.cy, k.cy, 1e-3);
}

void expect_refused(const Result<CameraFile>& file, const std::vector<std::string>& words) {
  ASSERT_FALSE(file) << words[0];
  for (const std::string& word : words) EXPECT_TRUE(contains(file.error().message, word)) << file.error().message;
  EXPECT_FALSE(contains(file.error().message, "\n"));
}

constexpr Intrinsics kLens{640, 480, 570, 571, 321, 243};

TEST(CalibrationFormats, OpenCvXmlIsReadWhateverItsMatrixIsCalled) {
  const std::string matrix =
      " type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n"
      "    5.7e+02 0. 321. 0. 571.\n    243. 0. 0. 1.</data></";
  const auto file = [&](const std::string& name, const std::string& more) {
    return "<?xml version=\"1.0\"?>\n<opencv_storage>\n<calibration_time>\"today\"</calibration_time>\n<!-- <a> "
           "-->\n<" +
           name + matrix + name + ">\n" + more + "</opencv_storage>\n";
  };
  const std::string size = "<image_Width>640</image_Width>\n<image_Height>480</image_Height>\n";
  for (const char* name : {"camera_matrix", "Camera_Matrix", "intrinsic", "K", "M1", "mtx"})
    expect_lens(parsed(file(name, size)), kLens);
  expect_lens(parsed(file("intrinsic", ""), {640, 480}), kLens);
  expect_refused(parsed(file("intrinsic", "")), {"image_width and image_height are missing"});
  const auto bent = parsed(
      file("M1", size + "<Distortion_Coefficients type_id=\"opencv-matrix\"><rows>5</rows><cols>1</cols><dt>d</dt>"
                        "<data>0.1 -0.2 0.001 0.002 0.05</data></Distortion_Coefficients>"));
  ASSERT_TRUE(bent) << bent.error().message;
  EXPECT_EQ(bent->distortion.coefficients, (std::array<double, 8>{0.1, -0.2, 0.001, 0.002, 0.05}));
  expect_refused(parsed(file("M1", size + "<D1><data>0.1 0 0 0</data></D1>")), {"D1", "part of the lens"});
  expect_refused(parsed(file("M1", size + "<M2" + matrix + "M2>")), {"more than one camera matrix", "M1", "M2"});
  expect_refused(parsed("<?xml version=\"1.0\"?><opencv_storage><a>1</b></opencv_storage>"), {"line 1", "</b>"});
  expect_refused(parsed("<opencv_storage><camera_matrix>"), {"ends within"});
}

// The lens of an Azure Kinect in Orbbec's own words: nested, flat, in camel case, with another camera beside it.
TEST(CalibrationFormats, CoefficientsByNameAreRead) {
  const std::string size = R"("fx": 504.5, "fy": 504.25, "cx": 287.5, "cy": 319.5, "width": 576, "height": 640)";
  const std::string lens =
      R"("k1": 16.5, "k2": 8.5, "k3": 0.3125, "k4": 16.25, "k5": 13.5, "k6": 1.5, "p1": 0.0625, "p2": -0.03125)";
  const std::string colour =
      R"("fx": 900, "fy": 900, "cx": 960, "cy": 540, "width": 1920, "height": 1080, "k1": 0.5)";
  for (const std::string& text :
       {R"({"depth_intrinsic": {)" + size + R"(}, "depth_distortion": {)" + lens + "}}",
        "{" + size + ", " + lens + "}",
        R"({"rgbIntrinsic": {)" + colour + R"(}, "rgbDistortion": {"k1": 3}, "depthIntrinsic": {)" + size +
            R"(}, "depthDistortion": {)" + lens + R"(, "model": "OB_DISTORTION_BROWN_CONRADY_K6"}})",
        "{\n\t\"cameras\": {\"color\": {" + colour + "}, \"depth\": {\"intrinsics\": {" + size +
            "},\n\t\"distortion\": {" + lens + "}}}}",
        "{" + size + R"(, "distortion": [16.5, 8.5, 0.0625, -0.03125, 0.3125, 16.25, 13.5, 1.5]})",
        R"({"serial": "A1", "param": {)" + size + ", " + lens + "}}"}) {
    const auto file = parsed(text);
    expect_lens(file, {576, 640, 504.5F, 504.25F, 287.5F, 319.5F});
    ASSERT_TRUE(file) << text;
    EXPECT_EQ(file->distortion.coefficients,
              (std::array<double, 8>{16.5, 8.5, 0.0625, -0.03125, 0.3125, 16.25, 13.5, 1.5}))
        << text;
  }
}

TEST(CalibrationFormats, AKeyThatLooksLikeALensIsNeverIgnored) {
  const std::string camera = R"("fx": 570, "fy": 571, "cx": 321, "cy": 243, "width": 640, "height": 480)";
  for (const char* key : {"k7", "distortion_params_2", "radial_distortion", "s1", "lens_correction", "skew", "codx",
                          "D2coeffs", "d1"}) {
    expect_refused(parsed("{" + camera + ", \"" + key + "\": 0.25}"), {key, "looks like a part of the lens"});
    expect_refused(parsed("{" + camera + ", \"more\": {\"" + key + "\": [0, 0.25]}}"), {key});
    expect_lens(parsed("{" + camera + ", \"" + key + "\": 0.0}"), kLens);                // says nothing
    expect_lens(parsed("{" + camera + ", \"color\": {\"" + key + "\": 0.25}}"), kLens);  // of another camera
  }
  expect_refused(parsed("{" + camera + R"(, "distortion": {"k1": 0.1, "b1": 0.2}})"), {"b1"});
  expect_refused(parsed("{" + camera + R"(, "coeffs": [0.1, 0, 0, 0], "k1": 0.2})"), {"k1"});
  expect_refused(parsed("{" + camera + R"(, "coeffs": [0.1, 0, 0, 0], "model": "Inverse Brown Conrady"})"),
                 {"Inverse Brown Conrady"});
  expect_refused(parsed("{" + camera + R"(, "coeffs": [0, 0, 0, 0], "model": "Kannala Brandt4"})"), {"Kannala"});
  expect_refused(parsed("{" + camera + R"(, "coeffs": [0.1, 0, 0]})"), {"distortion_coefficients"});
  expect_refused(parsed("{" + camera + R"(, "coeffs": [0.1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]})"), {"thin prism"});
}

// The raw values of a real camera, and those that Microsoft's own SDK printed of them (3DReconstruct, calib.md).
TEST(CalibrationFormats, AnAzureKinectsFractionsAreThoseOfItsMode) {
  const auto file = [](const std::string& parameters) {
    return R"({"CalibrationInformation": {"Cameras": [{"Purpose": "CALIBRATION_CameraPurposePhotoVideo", "Intrinsics":
               {"ModelParameters": [0.5, 0.5, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]}}, {"Intrinsics": {"ModelParameterCount":
               14, "ModelParameters": [)" +
           parameters + R"(], "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"}, "Location":
               "CALIBRATION_CameraLocationD0", "Purpose": "CALIBRATION_CameraPurposeDepth", "SensorHeight": 1024}]}})";
  };
  const std::string real =
      "0.5122697949409485, 0.49451231956481934, 0.4921168386936188, 0.4921667277812958, 3.1305770874023438, "
      "2.324939012527466, 0.1304156482219696, 3.458651542663574, 3.350114583969116, 0.6629416346549988, 0, 0, "
      "-0.0000511557373101823, 0.00008132171933539212";
  const auto narrow = parsed(file(real), {640, 576});
  expect_lens(narrow, {640, 576, 503.927643F, 503.978729F, 332.064270F, 325.880615F});
  ASSERT_TRUE(narrow);
  const double kTruth[] = {3.130577, 2.324939, 0.000081, -0.000051, 0.130416, 3.458652, 3.350115, 0.662942};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(narrow->distortion.coefficients[i], kTruth[i], 1e-6) << i;
  const auto wide = parsed(file(real), {512, 512});
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_NEAR(wide->intrinsics.fx, 503.927643 / 2, 1e-3);
  EXPECT_NEAR(wide->intrinsics.cx, (332.064270 + 192.5) / 2 - 0.5, 1e-3);
  expect_refused(parsed(file(real), {640, 480}), {"Azure Kinect", "640x480"});
  expect_refused(parsed(file(real)), {"every mode"});
  expect_refused(parsed(file("0.5, 0.5")), {"ModelParameters"});
}

TEST(CalibrationFormats, RealSensesListIsReadForTheModeOfThePictures) {
  const auto section = [](const std::string& stream, int width, int height, double f, const std::string& lens) {
    return " Intrinsic of \"" + stream + "\" / " + std::to_string(width) + "x" + std::to_string(height) +
           " / {Z16}\n  Width:      \t" + std::to_string(width) + "\n  Height:     \t" + std::to_string(height) +
           "\n  PPX:        \t" + std::to_string(width / 2.0) + "\n  PPY:        \t" + std::to_string(height / 2.0) +
           "\n  Fx:         \t" + std::to_string(f) + "\n  Fy:         \t" + std::to_string(f) + "\n" + lens +
           "  FOV (deg):  \t60 x 40\n\n";
  };
  const std::string plain = "  Distortion: \tBrown Conrady\n  Coeffs:     \t0  \t0  \t0  \t0  \t0  \n";
  const std::string text = "Device info: \n    Name                          : \tIntel RealSense D435\n\n" +
                           section("Color", 640, 480, 615, plain) + section("Depth", 848, 480, 420, plain) +
                           section("Depth", 640, 480, 380, plain) + section("Infrared 1", 640, 480, 300, plain);
  expect_lens(parsed(text, {640, 480}), {640, 480, 380, 380, 320, 240});
  expect_lens(parsed(text, {848, 480}), {848, 480, 420, 420, 424, 240});
  expect_refused(parsed(text), {"848x480, 640x480", "mode"});
  expect_lens(parsed(section("Depth", 640, 480, 380, plain)), {640, 480, 380, 380, 320, 240});
  expect_refused(parsed(section("Color", 640, 480, 380, plain)), {"Depth"});
  expect_refused(parsed(section("Depth", 640, 480, 380,
                                "  Distortion: \tInverse Brown Conrady\n  Coeffs: \t0.1 \t0  \t0  \t0  \t0  \n")),
                 {"Inverse Brown Conrady"});
}

TEST(CalibrationFormats, KalibrsDepthCameraIsRead) {
  const auto camera = [](const std::string& name, const std::string& f, const std::string& topic) {
    return name + ":\n  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]\n" +
           "  distortion_model: radtan\n  intrinsics: [" + f + ", 571, 321, 243]\n  resolution: [640, 480]\n" +
           "  rostopic: " + topic + "\n";
  };
  const auto one = parsed(camera("cam0", "570", "/camera"));
  expect_lens(one, kLens);
  EXPECT_EQ(one->distortion.coefficients, (std::array<double, 8>{0.1, -0.2, 0.001, 0.002}));
  expect_lens(parsed(camera("cam0", "615", "/colour") + camera("cam1", "570", "/camera/depth/image")), kLens);
  expect_refused(parsed(camera("cam0", "615", "/a") + camera("cam1", "570", "/b")), {"2 cameras", "depth"});
  std::string fisheye = camera("cam0", "570", "/camera");
  fisheye.replace(fisheye.find("radtan"), 6, "equidistant");
  expect_refused(parsed(fisheye), {"equidistant"});
}

// Phones give the lens of their colour picture.
TEST(CalibrationFormats, MatricesOfPhonesAreScaledToTheDepthPicture) {
  const Intrinsics phone{
      256, 192, 192.5F, 192.5F, (955.1F + 0.5F) * 256 / 1920 - 0.5F, (722.9F + 0.5F) * 256 / 1920 - 0.5F};
  const std::string matrix = "1443.75, 0.0, 955.1\n0.0, 1443.75, 722.9\n0.0, 0.0, 1.0\n";
  expect_lens(parsed(matrix, {256, 192}), phone);
  expect_lens(parsed("[[1443.75 0 955.1]\n [0 1443.75 722.9]\n [0 0 1]]", {256, 192}), phone);
  expect_lens(
      parsed(R"({"intrinsics": [1443.75, 0, 955.1, 0, 1443.75, 722.9, 0, 0, 1], "cameraPoseARFrame": [1, 0, 0, 0,
                         0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "time": 5})",
             {256, 192}),
      phone);
  expect_refused(parsed(matrix, {640, 480 + 1}), {"1920x1440", "640x481"});
  expect_lens(parsed("570, 0, 321\n0, 571, 243\n0, 0, 1", {640, 480}), kLens);  // of these pictures already
  const std::string record3d =
      R"("fps": 30, "K": [1443.75, 0, 0, 0, 1443.75, 0, 722.9, 955.1, 1], "poses": [[0, 0, 0, 1,
                                   0, 0, 0]], "perFrameIntrinsicCoeffs": [[1, 2, 3, 4]], "w": 1440, "h": 1920)";
  const Intrinsics upright{192, 256, 192.5F, 192.5F, phone.cy, phone.cx};
  expect_lens(parsed("{" + record3d + R"(, "dw": 192, "dh": 256})"), upright);
  expect_lens(parsed("{" + record3d + "}", {192, 256}), upright);
  expect_refused(parsed("{" + record3d + R"(, "dw": 256, "dh": 192})"), {"another ratio"});
}

TEST(CalibrationFormats, ValuesThatNoDepthCameraHasAreNamed) {
  const auto text = [](const std::string& f, const std::string& cx, const std::string& cy) {
    return "image_width: 480\nimage_height: 640\ncamera_matrix:\n  data: [" + f + ", 0, " + cx + ", 0, " + f + ", " +
           cy + ", 0, 0, 1]\n";
  };
  expect_refused(parsed(text("3224.5", "239.5", "319.5")), {"fy is 3224.5", "field of view of 11.3 degrees"});
  expect_refused(parsed(text("140", "239.5", "319.5")), {"field of view of 13", "130"});
  expect_refused(parsed(text("287.9", "119.75", "159.75")), {"cx, cy are 119.8, 159.8", "another size"});
  expect_refused(parsed(text("575.8", "319.5", "239.5")), {"cx, cy are 319.5, 239.5", "turned by 90 degrees"});
  EXPECT_TRUE(parsed(text("575.8", "239.5", "319.5")));
  expect_refused(
      parsed("image_width: 4096\nimage_height: 3072\ncamera_matrix:\n  data: [3000, 0, 2048, 0, 3000, 1536, "
             "0, 0, 1]\n"),
      {"4096x3072", "2048", "halve"});
}

// A name that stands for what it stands in would be looked through for ever.
TEST(CalibrationFormats, AFileThatContainsItselfIsRefused) {
  EXPECT_FALSE(parsed("depth: &a {depth: *a}"));
  EXPECT_FALSE(parsed("&a {more: *a, fx: 570, fy: 571, cx: 321, cy: 243, width: 640, height: 480, k9: [1]}"));
}

TEST(CalibrationFormats, SharedCalibrationsAreReadRightOrRefusedByName) {
  const char* given = std::getenv("IM2FIT_SHARED");
  const std::string root = std::string(given != nullptr ? given : "/nowhere") + "/cases/";
  if (!std::filesystem::exists(root + "calibrations")) GTEST_SKIP() << "set IM2FIT_SHARED to the shared folder";
  for (const char* name : {"camera.yaml", "camera_matrix.csv", "k4a.json", "kalibr.yaml", "opencv.xml",
                           "record3d_metadata.json", "rs_enumerate.txt"})
    expect_lens(load_camera_yaml(root + "calibrations/" + name, {480, 640}),
                {480, 640, 575.8F, 575.8F, 239.5F, 319.5F});
  for (const char* name : {"half.yaml", "rgb_focal.yaml", "swapped_centre.yaml"})
    EXPECT_FALSE(load_camera_yaml(root + "calibrations/" + name, {480, 640})) << name;
  const auto truth = load_camera_yaml(root + "orbbec-json-distortion/camera.yaml");
  ASSERT_TRUE(truth);
  for (const char* name : {"flat.json", "orbbec.json"}) {
    const auto file = load_camera_yaml(root + "orbbec-json-distortion/" + name);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->distortion.coefficients, truth->distortion.coefficients) << name;
  }
}

}  // namespace
}  // namespace im2fit::hal
