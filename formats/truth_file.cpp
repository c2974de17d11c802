// SPDX-License-Identifier: Apache-2.0
#include "formats/truth_file.h"

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kTruthBytesMax = std::size_t{64} << 20;  // of 30,000 frames
constexpr const char* kSchema = "im2fit.truth/1";

// Tenths of a millimetre (and of a kilogram's hundredth) are far below what any sensor sees.
double rounded(double value, double step) {
  return std::round(value / step) * step;
}

Json vector_json(Vec3f v) {
  return {rounded(v.x, 1e-2), rounded(v.y, 1e-2), rounded(v.z, 1e-2)};
}
Vec3f vector_of(const Json& json) {
  return {json.at(0).get<float>(), json.at(1).get<float>(), json.at(2).get<float>()};
}

Json joints_json(const JointSet& joints) {
  Json out = Json::object();
  for (std::size_t i = 0; i < kJointCount; ++i) out[std::string(kJointNames[i])] = vector_json(joints.position_mm[i]);
  return out;
}

Truth truth_of(const Json& json) {
  Truth truth;
  truth.seed = json.at("seed").get<std::uint64_t>();
  truth.subject = json.at("subject").get<std::uint64_t>();
  truth.family = json.at("family").get<std::string>();
  truth.woman = json.at("woman").get<bool>();
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    truth.values[i] = json.at("measurements").at(std::string(kMeasurementTable[i].id)).at("value").get<float>();
  if (const auto floor = json.find("floor"); floor != json.end()) {
    truth.floor.known = true;
    truth.floor.up = {floor->at("up").at(0).get<float>(), floor->at("up").at(1).get<float>(),
                      floor->at("up").at(2).get<float>()};
    truth.floor.camera_height_mm = floor->at("camera_height_mm").get<float>();
  }
  for (const Json& frame : json.at("frames")) {
    JointSet joints;
    for (std::size_t i = 0; i < kJointCount; ++i) {
      joints.position_mm[i] = vector_of(frame.at("joints").at(std::string(kJointNames[i])));
      joints.confidence[i] = 1.0F;
    }
    truth.joints.push_back(joints);
  }
  return truth;
}

}  // namespace

Status write_truth(const Truth& truth, const std::string& path) {
  Json json;
  json["schema"] = kSchema;
  json["label"] = "synthetic";
  json["seed"] = truth.seed;
  json["subject"] = truth.subject;
  json["family"] = truth.family;
  json["woman"] = truth.woman;
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    json["measurements"][std::string(kMeasurementTable[i].id)] = {{"value", rounded(truth.values[i], 1e-2)},
                                                                  {"unit", kMeasurementTable[i].unit}};
  if (truth.floor.known)
    json["floor"] = {{"up", {truth.floor.up.x, truth.floor.up.y, truth.floor.up.z}},
                     {"camera_height_mm", rounded(truth.floor.camera_height_mm, 1e-2)}};
  json["frames"] = Json::array();
  for (const JointSet& joints : truth.joints) json["frames"].push_back({{"joints", joints_json(joints)}});
  return write_file_atomically(path, json.dump(1) + "\n", Readable::by_owner);
}

Result<Truth> read_truth(const std::string& path) {
  const auto read = read_json<Json>(path, kTruthBytesMax);
  if (!read && read.error().code == ErrorCode::corrupt)
    return Error{ErrorCode::corrupt, read.error().message + "; render the folder again"};
  if (!read) return read.error();
  const Json& json = *read;
  try {
    const auto schema = json.is_object() ? json.find("schema") : json.end();
    if (!json.is_object() || schema == json.end())
      return Error{ErrorCode::unsupported, path + " is not the truth of a rendered person (it has no \"schema\": \"" +
                                               kSchema + "\"); im2fit-lab render writes one"};
    if (*schema != kSchema)
      return Error{ErrorCode::unsupported, path + ": schema is " + excerpt(json_text(*schema)) + ", expected \"" +
                                               kSchema + "\"; render the folder again"};
    return truth_of(json);
  } catch (const Json::exception& error) {
    return Error{ErrorCode::corrupt, path + ": " + error.what() + "; render the folder again"};
  }
}

}  // namespace im2fit
