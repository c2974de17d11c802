// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/calibration_words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>

#include "core/text.h"
#include "hal/folder/camera_yaml.h"

namespace im2fit::hal {
namespace {

constexpr int kDepthMax = 8;         // groups within groups; makers' files have 3
constexpr int kNodesMax = 300'000;   // of a file of kTextBytesMax; a name that stands for another may repeat them
constexpr double kCentreOff = 0.1;   // of a side: another picture's matrix
constexpr double kSquareOff = 0.02;  // fx and fy of these cameras differ by less than 0.5 %

using Names = std::span<const std::string_view>;
using NameList = std::initializer_list<std::string_view>;

bool is_one_of(std::string_view name, Names names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_one_of(std::string_view name, NameList names) {
  return is_one_of(name, Names(names.begin(), names.size()));
}

std::string key_of(const YAML::Node& key) {
  return key.IsScalar() ? key.Scalar() : "";
}

// The first entry under one of these plain names; undefined: there is none.
YAML::Node entry_of(const YAML::Node& map, Names names) {
  if (map.IsDefined() && map.IsMap())
    for (const std::string_view name : names)
      for (const auto& entry : map)
        if (plain_name(key_of(entry.first)) == name) return entry.second;
  return YAML::Node(YAML::NodeType::Undefined);
}

YAML::Node entry_of(const YAML::Node& map, NameList names) {
  return entry_of(map, Names(names.begin(), names.size()));
}

// A name that stands for another repeats it: a small file has many more items than characters.
constexpr int kItemsMax = 10'000;

void append_numbers(const YAML::Node& node, int depth, int& items, std::vector<double>& out) {
  if (depth > 2) return;
  for (const auto& item : node) {
    if (out.size() > 16 || ++items > kItemsMax) return;
    if (item.IsSequence())
      append_numbers(item, depth + 1, items, out);
    else
      out.push_back(item.as<double>());
  }
}

// A list, a list of rows, or a map with the list under "data". Empty: none of these.
std::vector<double> numbers_of(const YAML::Node& node) {
  std::vector<double> numbers;
  if (!node.IsDefined()) return numbers;
  const YAML::Node list = node.IsMap() ? entry_of(node, {"data"}) : node;
  int items = 0;
  if (list.IsDefined() && list.IsSequence()) append_numbers(list, 0, items, numbers);
  return numbers;
}

// Too many items count as a value, so that what is not read is refused.
bool has_value(const YAML::Node& node, int depth, int& items) {
  if (node.IsScalar()) {
    double value = 0;
    return YAML::convert<double>::decode(node, value) && value != 0;
  }
  if (depth > 2 || !(node.IsSequence() || node.IsMap())) return false;
  for (const auto& item : node) {
    if (++items > kItemsMax) return true;
    if (has_value(node.IsMap() ? item.second : static_cast<const YAML::Node&>(item), depth + 1, items)) return true;
  }
  return false;
}
bool has_value(const YAML::Node& node) {
  int items = 0;
  return has_value(node, 0, items);
}

bool contains_word(std::string_view name, std::string_view word) {
  return name.find(word) != std::string_view::npos;
}

// A camera other than the depth camera, or what follows from the lens.
bool is_of_another(const std::string& name) {
  for (const char* word : {"color", "colour", "rgb", "left", "right", "infra", "imu", "gyro", "accel", "projection",
                           "rectification", "extrinsic"})
    if (contains_word(name, word)) return true;
  return is_one_of(name,
                   {"ir", "ir1", "ir2", "r", "p", "rotation", "translation", "transform", "perframeintrinsiccoeffs"});
}

bool looks_like_lens(const std::string& name) {
  for (const char* word :
       {"distort", "distcoef", "coeff", "radial", "tangential", "lens", "fisheye", "skew", "undist"})
    if (contains_word(name, word)) return true;
  const bool numbered = name.size() == 2 && name[1] >= '0' && name[1] <= '9';
  if (numbered && is_one_of(name.substr(0, 1), {"k", "p", "s", "d"})) return true;
  return is_one_of(name, {"d", "xi", "codx", "cody", "taux", "tauy"});
}

// Groups that a depth camera's values stand in, the surest first.
constexpr std::string_view kGroups[] = {
    "depth",      "depthintrinsics",  "depthintrinsic", "depthcamera",  "depthcameraintrinsics",
    "intrinsics", "intrinsic",        "cameraparam",    "calibration",  "camera",
    "camerainfo", "cameraintrinsics", "parameters",     "cameramatrix", "k"};

constexpr std::string_view kMatrices[] = {"cameramatrix",   "k",         "intrinsicmatrix",  "cameraintrinsicmatrix",
                                          "intrinsics",     "intrinsic", "intrinsicsmatrix", "depthintrinsics",
                                          "depthintrinsic", kBareMatrix};
constexpr std::string_view kCoefficientNames[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
constexpr std::string_view kModelNames[] = {"distortionmodel", "cameradistortionmodel", "distortiontype",
                                            "model",           "cameramodel",           "type"};

class WordsReader {
 public:
  WordsReader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  Result<LensWords> read(PictureSize pictures) {
    if (auto chain = descend(); !chain) return chain.error();
    if (auto ok = take_size(); !ok) return ok.error();
    if (auto ok = take_lens(); !ok) return ok.error();
    if (auto ok = take_distortion(); !ok) return ok.error();
    if (auto ok = refuse_unknown(root_, "", 0); !ok) return ok.error();
    if (auto ok = fit_to(pictures); !ok) return ok.error();
    return std::move(words_);
  }

 private:
  // From the group with the lens out to the whole file.
  Status descend() {
    for (YAML::Node place = root_; chain_.size() < kDepthMax;) {
      chain_.insert(chain_.begin(), place);
      if (entry_of(place, {"fx", "flx"}).IsDefined() || !numbers_of(entry_of(place, kMatrices)).empty()) return Ok{};
      const YAML::Node inner = find_group(place);
      if (!inner.IsDefined()) return Ok{};
      place.reset(inner);
    }
    return Error{ErrorCode::invalid_argument, path_ + ": groups lie deeper than " + std::to_string(kDepthMax) +
                                                  "; keep the depth camera's values (docs/cameras)"};
  }
  static bool is_group(const YAML::Node& node) {
    return node.IsDefined() && node.IsMap() && !entry_of(node, {"data"}).IsDefined();  // a matrix has data
  }
  // One with a known name, or the only one.
  static YAML::Node find_group(const YAML::Node& place) {
    for (const std::string_view name : kGroups)
      if (const YAML::Node group = entry_of(place, {name}); is_group(group)) return group;
    YAML::Node only(YAML::NodeType::Undefined);
    if (!place.IsMap()) return only;
    for (const auto& entry : place) {
      if (!is_group(entry.second) || is_of_another(plain_name(key_of(entry.first)))) continue;
      if (only.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
      only.reset(entry.second);
    }
    return only;
  }

  // The nearest group of the chain that has it.
  YAML::Node take(NameList names) { return take(Names(names.begin(), names.size())); }
  YAML::Node take(Names names) {
    for (const YAML::Node& place : chain_) {
      const YAML::Node found = entry_of(place, names);
      if (!found.IsDefined()) continue;
      taken_.push_back(found);
      return found;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  Status take_size() {
    const YAML::Node pair = take({"resolution", "imagesize"});
    if (pair.IsDefined() && pair.IsSequence() && pair.size() == 2) {
      words_.size = {pair[0].as<int>(), pair[1].as<int>()};
      return Ok{};
    }
    const YAML::Node width = take({"imagewidth", "width", "w"}), height = take({"imageheight", "height", "h"});
    if (!width.IsDefined() && !height.IsDefined()) return Ok{};
    if (!width.IsDefined() || !width.IsScalar())
      return calibration_lacks(path_, "image_width", "a whole number of pixels");
    if (!height.IsDefined() || !height.IsScalar())
      return calibration_lacks(path_, "image_height", "a whole number of pixels");
    words_.size = {width.as<int>(), height.as<int>()};
    return Ok{};
  }

  Status take_lens() {
    std::vector<double> values;
    for (const YAML::Node& place : chain_)
      for (const std::string_view name : kMatrices) {
        if (!values.empty()) break;
        const YAML::Node node = entry_of(place, {name});
        values = numbers_of(node);
        if (!values.empty()) taken_.push_back(node);
      }
    if (values.size() == 9) return take_matrix(values);
    // kalibr's: fx fy cx cy.
    if (values.size() == 4 && entry_of(chain_.front(), {"cameramodel"}).IsDefined()) {
      std::copy(values.begin(), values.end(), words_.lens.begin());
      return Ok{};
    }
    if (!values.empty()) return calibration_lacks(path_, "camera_matrix", "9 numbers (3 x 3, row by row)");
    if (entry_of(chain_.front(), {"fx", "flx", "fy", "cx", "ppx"}).IsDefined()) return take_numbers();
    return take_only_matrix();
  }

  Status take_numbers() {
    constexpr std::array<std::array<std::string_view, 2>, 4> kNames = {
        {{"fx", "flx"}, {"fy", "fly"}, {"cx", "ppx"}, {"cy", "ppy"}}};
    for (std::size_t i = 0; i < words_.lens.size(); ++i) {
      const YAML::Node value = take(Names(kNames[i]));
      if (!value.IsDefined() || !value.IsScalar())
        return calibration_lacks(path_, "camera_matrix", "a matrix with data: [...], or fx, fy, cx and cy");
      words_.lens[i] = value.as<double>();
    }
    return Ok{};
  }

  // OpenCV's programs name a matrix as they please: any that can only be a camera's.
  Status take_only_matrix() {
    std::vector<std::pair<std::string, PinholeLens>> found;
    find_matrices(root_, 0, found);
    if (found.size() > 1)
      return Error{ErrorCode::invalid_argument, path_ + " has more than one camera matrix (" +
                                                    excerpt(found[0].first) + ", " + excerpt(found[1].first) +
                                                    "); keep the depth camera's, or name it camera_matrix"};
    if (found.empty())
      return calibration_lacks(path_, "camera_matrix", "a matrix with data: [...], or fx, fy, cx and cy");
    words_.lens = found.front().second;
    return Ok{};
  }
  void find_matrices(const YAML::Node& node, int depth, std::vector<std::pair<std::string, PinholeLens>>& found) {
    if (!node.IsMap() || depth > kDepthMax) return;
    for (const auto& entry : node) {
      if (++visited_ > kNodesMax || found.size() > 1) return;
      const std::string name = key_of(entry.first);
      if (is_of_another(plain_name(name))) continue;
      std::array<double, 9> matrix{};
      const YAML::Node list = entry.second.IsMap() ? entry_of(entry.second, {"data"}) : entry.second;
      bool all = list.IsDefined() && list.IsSequence() && list.size() == matrix.size();
      for (std::size_t i = 0; all && i < matrix.size(); ++i)
        all = list[i].IsScalar() && YAML::convert<double>::decode(list[i], matrix[i]);
      const auto lens = all ? pinhole_lens(matrix) : std::nullopt;
      // A rotation has numbers up to 1.
      if (lens && (*lens)[0] > 1 && (*lens)[1] > 1)
        found.emplace_back(name, *lens);
      else
        find_matrices(entry.second, depth + 1, found);
    }
  }

  Status take_matrix(const std::vector<double>& values) {
    std::array<double, 9> matrix{};
    std::copy(values.begin(), values.end(), matrix.begin());
    const auto lens = pinhole_lens(matrix);
    if (!lens)
      return Error{ErrorCode::unsupported,
                   path_ + ": camera_matrix has skew or is not a pinhole matrix; expected [fx,0,cx, 0,fy,cy, 0,0,1]"};
    words_.lens = *lens;
    return Ok{};
  }

  Status take_distortion() {
    for (const YAML::Node& place : chain_) {
      YAML::Node model = entry_of(place, kModelNames);
      if (!model.IsDefined()) model.reset(entry_of(place, {"distortion"}));
      if (!model.IsDefined() || !model.IsScalar() || has_value(model)) continue;
      words_.model = model.Scalar();
      break;
    }
    const YAML::Node list = take({"distortioncoefficients", "distortioncoeffs", "distcoeffs", "distcoefficients",
                                  "distortioncoeff", "distcoeff", "d", "coeffs", "coefficients", "depthdistortion",
                                  "depthdistort", "distortion", "distort", "distortionparams"});
    if (!list.IsDefined()) return take_named(YAML::Node());
    if (is_group(list)) return take_named(list);
    const bool is_list = list.IsMap() ? entry_of(list, {"data"}).IsSequence() : list.IsSequence();
    if (is_list) words_.distortion = numbers_of(list);
    if (!is_list && has_value(list)) return calibration_lacks(path_, "distortion_coefficients", "a list of numbers");
    return is_list ? Status(Ok{}) : take_named(YAML::Node());
  }

  // Coefficients by name, in a group of their own or beside fx and fy.
  Status take_named(const YAML::Node& group) {
    std::vector<double> values;
    bool any = false;
    for (const std::string_view name : kCoefficientNames) {
      YAML::Node value = entry_of(group, {name});
      if (!value.IsDefined()) value.reset(take({name}));
      if (value.IsDefined() && !value.IsScalar()) return calibration_lacks(path_, std::string(name), "a number");
      values.push_back(value.IsDefined() ? value.as<double>() : 0);
      any = any || value.IsDefined();
    }
    if (any) words_.distortion = std::move(values);
    if (!group.IsMap()) return Ok{};
    for (const auto& entry : group) {
      const std::string name = key_of(entry.first), plain = plain_name(name);
      if (is_one_of(plain, kModelNames))
        words_.model = entry.second.IsScalar() ? entry.second.Scalar() : "";
      else if (!is_one_of(plain, kCoefficientNames) && has_value(entry.second))
        return unknown(name);
    }
    return Ok{};
  }

  bool is_taken(const YAML::Node& node) const {
    return std::any_of(taken_.begin(), taken_.end(), [&](const YAML::Node& taken) { return taken.is(node); });
  }
  Error unknown(const std::string& name) const {
    return {
        ErrorCode::unsupported,
        path_ + ": " + excerpt(name) +
            " looks like a part of the lens, and im2fit does not know it; write distortion_coefficients as OpenCV "
            "does (k1 k2 p1 p2 k3 k4 k5 k6), or undistort the pictures and remove it (docs/cameras)"};
  }

  Status refuse_unknown(const YAML::Node& node, const std::string& within, int depth) {
    if (!node.IsMap() || depth > kDepthMax) return Ok{};
    for (const auto& entry : node) {
      if (++visited_ > kNodesMax)
        return Error{ErrorCode::unsupported, path_ + " has too many entries (docs/cameras)"};
      const std::string name = key_of(entry.first), plain = plain_name(name);
      if (is_of_another(plain) || is_taken(entry.second)) continue;
      const std::string full = within.empty() ? name : within + "." + name;
      if (looks_like_lens(plain) && has_value(entry.second)) return unknown(full);
      if (auto ok = refuse_unknown(entry.second, full, depth + 1); !ok) return ok;
    }
    return Ok{};
  }

  Status fit_to(PictureSize pictures);
  Status fit_matrix_alone(PictureSize pictures);

  const YAML::Node& root_;
  const std::string& path_;
  std::vector<YAML::Node> chain_, taken_;
  int visited_ = 0;
  LensWords words_;
};

// A matrix without a size is for the pictures it is used with, or a phone's for its colour picture.
Status WordsReader::fit_matrix_alone(PictureSize pictures) {
  if (!pictures.known())
    return Error{ErrorCode::invalid_argument,
                 path_ + ": image_width and image_height are missing; add the size of the pictures this is for"};
  words_.size = pictures;
  if (is_centred(words_.lens, pictures.width, pictures.height) ||
      !is_centred(words_.lens, kPhoneColourWidth, kPhoneColourHeight))
    return Ok{};
  if (pictures.width * kPhoneColourHeight != pictures.height * kPhoneColourWidth)
    return Error{ErrorCode::invalid_argument,
                 path_ + " is for a phone's colour picture of 1920x1440, and the pictures are " +
                     std::to_string(pictures.width) + "x" + std::to_string(pictures.height) +
                     "; give the calibration of these pictures"};
  words_.lens = scaled_lens(words_.lens, static_cast<double>(pictures.width) / kPhoneColourWidth);
  return Ok{};
}

Status WordsReader::fit_to(PictureSize pictures) {
  if (!words_.size.known() && words_.size.width == 0 && words_.size.height == 0) return fit_matrix_alone(pictures);
  // Record3D: w and h are of the colour picture, dw and dh of the depth picture. Its older versions have no dw, dh.
  const YAML::Node dw = entry_of(root_, {"dw"}), dh = entry_of(root_, {"dh"});
  PictureSize depth;
  if (dw.IsDefined() && dh.IsDefined() && dw.IsScalar() && dh.IsScalar())
    depth = {dw.as<int>(), dh.as<int>()};
  else if (entry_of(root_, {"perframeintrinsiccoeffs", "poses"}).IsDefined() && pictures.known())
    depth = pictures;
  if (!depth.known() || (depth.width == words_.size.width && depth.height == words_.size.height)) return Ok{};
  // Sides are rounded to whole pixels.
  const double scale = static_cast<double>(depth.width) / words_.size.width;
  if (std::abs(scale * words_.size.height - depth.height) > 1)
    return Error{ErrorCode::invalid_argument, path_ + " is for a colour picture of " +
                                                  std::to_string(words_.size.width) + "x" +
                                                  std::to_string(words_.size.height) + " and depth of " +
                                                  std::to_string(depth.width) + "x" + std::to_string(depth.height) +
                                                  ": the sides have another ratio; give the calibration of the depth "
                                                  "pictures"};
  words_.lens = scaled_lens(words_.lens, scale);
  words_.size = depth;
  return Ok{};
}

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// "Depth" sections, one a mode: that of the pictures.
Result<LensWords> realsense_words(const YAML::Node& sections, const std::string& path, PictureSize pictures) {
  std::string sizes;
  std::vector<LensWords> found;
  std::optional<LensWords> fitting;
  for (const auto& section : sections) {
    if (plain_name(section["stream"].Scalar()).rfind("depth", 0) != 0) continue;
    LensWords words;
    for (const auto& [key, value] :
         {std::pair{"Width", &words.size.width}, std::pair{"Height", &words.size.height}}) {
      if (!section[key].IsDefined() || !section[key].IsScalar())
        return calibration_lacks(path, key, "a whole number of pixels");
      *value = section[key].as<int>();
    }
    constexpr const char* kKeys[] = {"Fx", "Fy", "PPX", "PPY"};
    for (std::size_t i = 0; i < words.lens.size(); ++i) {
      if (!section[kKeys[i]].IsDefined() || !section[kKeys[i]].IsScalar())
        return calibration_lacks(path, kKeys[i], "a number");
      words.lens[i] = section[kKeys[i]].as<double>();
    }
    words.distortion = numbers_of(section["Coeffs"]);
    if (section["Distortion"].IsDefined()) words.model = section["Distortion"].Scalar();
    const bool fits = words.size.width == pictures.width && words.size.height == pictures.height;
    if (fits && fitting && fitting->lens != words.lens)
      return Error{ErrorCode::invalid_argument,
                   path + " has two depth cameras with this mode; keep the sections of yours"};
    if (fits) fitting = words;
    sizes += (sizes.empty() ? "" : ", ") + size_text(words.size.width, words.size.height);
    found.push_back(std::move(words));
  }
  if (fitting) return std::move(*fitting);
  if (found.size() == 1) return std::move(found.front());
  if (found.empty()) return calibration_lacks(path, "Intrinsic of \"Depth\"", "a section of rs-enumerate-devices -c");
  return Error{ErrorCode::invalid_argument,
               path + " has the depth camera's modes " + excerpt(sizes) +
                   (pictures.known() ? ", and the pictures are " + size_text(pictures.width, pictures.height) : "") +
                   "; keep the section of the mode in use"};
}

// Azure Kinect's values are for the sensor's picture, as a fraction of its sides and from its corner. A mode bins it
// and cuts its picture out.
struct KinectMode {
  PictureSize binned, offset, size;
};
constexpr KinectMode kKinectModes[] = {{{1024, 1024}, {192, 180}, {640, 576}},
                                       {{512, 512}, {96, 90}, {320, 288}},
                                       {{1024, 1024}, {0, 0}, {1024, 1024}},
                                       {{512, 512}, {0, 0}, {512, 512}}};

std::optional<KinectMode> kinect_mode(const std::vector<double>& p, PictureSize pictures) {
  const double fx = p[2], fy = p[3];
  // Some programs write the fractions of the mode's own picture: its pixels are square then.
  if (std::abs(fx * pictures.width / (fy * pictures.height) - 1) < kSquareOff)
    return KinectMode{pictures, {0, 0}, pictures};
  if (std::abs(fx / fy - 1) < kSquareOff)
    for (const KinectMode& mode : kKinectModes)
      if (mode.size.width == pictures.width && mode.size.height == pictures.height) return mode;
  return std::nullopt;
}

Result<LensWords> kinect_words(const YAML::Node& information, const std::string& path, PictureSize pictures) {
  const YAML::Node cameras = entry_of(information, {"cameras"});
  YAML::Node intrinsics(YAML::NodeType::Undefined);
  if (cameras.IsDefined() && cameras.IsSequence())
    for (const auto& camera : cameras) {
      const YAML::Node purpose = entry_of(camera, {"purpose"}), location = entry_of(camera, {"location"});
      const bool depth = (purpose.IsDefined() && purpose.IsScalar() && contains_word(purpose.Scalar(), "Depth")) ||
                         (location.IsDefined() && location.IsScalar() && location.Scalar().ends_with("LocationD0"));
      if (depth && !intrinsics.IsDefined()) intrinsics.reset(entry_of(camera, {"intrinsics"}));
    }
  if (!intrinsics.IsDefined())
    return calibration_lacks(path, "CalibrationInformation.Cameras", "a list with a depth camera");
  const std::vector<double> p = numbers_of(entry_of(intrinsics, {"modelparameters"}));
  if (p.size() < 14)
    return calibration_lacks(path, "ModelParameters", "14 numbers (cx cy fx fy k1 ... k6 codx cody p2 p1)");
  const YAML::Node type = entry_of(intrinsics, {"modeltype"});
  LensWords words;
  words.model = type.IsDefined() && type.IsScalar() ? type.Scalar() : "";
  if (const std::size_t at = words.model.find("LensDistortionModel"); at != std::string::npos)
    words.model.erase(0, at + std::string_view("LensDistortionModel").size());
  if (p[10] != 0 || p[11] != 0)
    return Error{ErrorCode::unsupported, path +
                                             ": codx and cody of ModelParameters are not 0, a lens im2fit does not "
                                             "know; undistort the pictures"};
  if (!pictures.known())
    return Error{ErrorCode::invalid_argument,
                 path +
                     " is for every mode of an Azure Kinect; write the values of one mode as ROS or OpenCV "
                     "calibration does (docs/cameras), or use it with a folder of pictures"};
  const auto mode = kinect_mode(p, pictures);
  if (!mode)
    return Error{ErrorCode::invalid_argument,
                 path +
                     " is an Azure Kinect's, whose pictures are 640x576, 320x288, 512x512 or 1024x1024, and these "
                     "are " +
                     size_text(pictures.width, pictures.height) + "; give the calibration of these pictures"};
  // Pixel 0 has its centre at 0, and theirs at 0.5.
  words.size = pictures;
  words.lens = {p[2] * mode->binned.width, p[3] * mode->binned.height,
                p[0] * mode->binned.width - mode->offset.width - 0.5,
                p[1] * mode->binned.height - mode->offset.height - 0.5};
  words.distortion = {p[4], p[5], p[13], p[12], p[6], p[7], p[8], p[9]};
  return words;
}

// kalibr's: cam0, cam1 ... each with its rostopic. The depth camera's, where there are several.
Result<YAML::Node> kalibr_camera(const YAML::Node& root, const std::string& path) {
  YAML::Node only(YAML::NodeType::Undefined), depth(YAML::NodeType::Undefined);
  int count = 0;
  for (const auto& entry : root) {
    const std::string name = key_of(entry.first);
    const bool numbered = name.size() == 4 && name.rfind("cam", 0) == 0 && name[3] >= '0' && name[3] <= '9';
    if (!numbered || !entry.second.IsMap()) continue;
    ++count;
    only.reset(entry.second);
    const YAML::Node topic = entry_of(entry.second, {"rostopic"});
    if (topic.IsDefined() && topic.IsScalar() && contains_word(plain_name(topic.Scalar()), "depth"))
      depth.reset(entry.second);
  }
  if (depth.IsDefined()) return depth;
  if (count <= 1) return count == 1 ? only : root;
  return Error{ErrorCode::invalid_argument, path + " has " + std::to_string(count) +
                                                " cameras, and no rostopic with the word depth; keep the depth "
                                                "camera's part alone"};
}

}  // namespace

std::string plain_name(std::string_view name) {
  std::string plain;
  for (const char c : name)
    if (c != '_' && c != '-' && c != ' ') plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return plain;
}

Error calibration_lacks(const std::string& path, const std::string& key, const std::string& expected) {
  return {ErrorCode::invalid_argument, path + ": " + key + " is missing or not " + expected +
                                           "; write it as ROS or OpenCV calibration does (docs/cameras)"};
}

PinholeLens scaled_lens(const PinholeLens& lens, double scale) {
  return {lens[0] * scale, lens[1] * scale, (lens[2] + 0.5) * scale - 0.5, (lens[3] + 0.5) * scale - 0.5};
}

bool is_centred(const PinholeLens& lens, int width, int height) {
  return std::abs(lens[2] - width / 2.0) <= kCentreOff * width &&
         std::abs(lens[3] - height / 2.0) <= kCentreOff * height;
}

Result<LensWords> lens_words(const YAML::Node& root, const std::string& path, PictureSize pictures) {
  if (!root.IsMap()) return calibration_lacks(path, "image_width", "a whole number");
  if (const YAML::Node sections = root[kRealSenseSections]; sections.IsDefined())
    return realsense_words(sections, path, pictures);
  if (const YAML::Node information = entry_of(root, {"calibrationinformation"}); information.IsDefined())
    return kinect_words(information, path, pictures);
  const auto camera = kalibr_camera(root, path);
  if (!camera) return camera.error();
  return WordsReader(*camera, path).read(pictures);
}

std::optional<std::array<float, 9>> accelerometer_rotation(const std::string& text) try {
  constexpr double kRotationOff = 0.02;
  const auto root = calibration_tree(text, "");
  if (!root) return std::nullopt;
  const YAML::Node sensors = entry_of(entry_of(*root, {"calibrationinformation"}), {"inertialsensors"});
  if (!sensors.IsDefined() || !sensors.IsSequence()) return std::nullopt;
  for (const auto& sensor : sensors) {
    const YAML::Node type = entry_of(sensor, {"sensortype"});
    if (!type.IsDefined() || !type.IsScalar() || !contains_word(type.Scalar(), "Accelerometer")) continue;
    const std::vector<double> r = numbers_of(entry_of(entry_of(sensor, {"rt"}), {"rotation"}));
    if (r.size() != 9) return std::nullopt;
    for (std::size_t a = 0; a < 9; a += 3)
      for (std::size_t b = a; b < 9; b += 3) {
        const double product = r[a] * r[b] + r[a + 1] * r[b + 1] + r[a + 2] * r[b + 2];
        if (!(std::abs(product - (a == b ? 1 : 0)) < kRotationOff)) return std::nullopt;
      }
    std::array<float, 9> out{};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(r[i]);
    return out;
  }
  return std::nullopt;
} catch (const YAML::Exception&) {
  return std::nullopt;
}

}  // namespace im2fit::hal
