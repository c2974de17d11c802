// SPDX-License-Identifier: Apache-2.0
#include "person/measured_body.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "formats/json_file.h"
#include "person/builtin_tape.h"
#include "person/person_measurement.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  // The number at a path of fields ("body/parameters/gender").
  float number(const Json& root, const std::string& pointer) {
    const Json::json_pointer at("/" + pointer);
    if (root.contains(at) && root[at].is_number()) return root[at].get<float>();
    if (!fault_)
      fault_ = Error{ErrorCode::corrupt,
                     path_ + ": " + pointer + " is not a number; expected the result.json of a measured person"};
    return 0;
  }
  const std::optional<Error>& fault() const { return fault_; }

 private:
  std::string path_;
  std::optional<Error> fault_;
};

void read_tape(const Json& root, MeasuredBody& out) {
  const auto& definitions = builtin_tape().definitions;
  out.tape_values.assign(definitions.size(), std::numeric_limits<float>::quiet_NaN());
  out.tape_intervals.resize(definitions.size());
  if (!root.contains("tape")) return;
  for (std::size_t i = 0; i < definitions.size(); ++i) {
    const auto at = root["tape"].find(definitions[i].id);
    if (at == root["tape"].end() || !at->contains("value") || !(*at)["value"].is_number()) continue;
    out.tape_values[i] = (*at)["value"].get<float>();
    const auto interval = at->find("interval");
    if (interval == at->end() || !interval->is_array() || interval->size() != 2 || !(*interval)[0].is_number() ||
        !(*interval)[1].is_number())
      continue;
    out.tape_intervals[i] = {true, (*interval)[0].get<float>(), (*interval)[1].get<float>()};
  }
}

}  // namespace

Result<MeasuredBody> read_measured_body(const std::string& path, const body::BodyModel& model) {
  const auto json = read_json<Json>(path);
  if (!json) return json.error();
  const Json& root = *json;
  if (!root.is_object() || !root.contains("schema") || root["schema"] != std::string(kResultSchema))
    return Error{ErrorCode::corrupt, path + ": schema is not " + std::string(kResultSchema) +
                                         "; expected the result.json of a measured person"};
  Reader read(path);
  MeasuredBody out;
  body::Params& p = out.params;
  const std::string at = "body/parameters/";
  out.female = read.number(root, "sex/female");
  p.gender = read.number(root, at + "gender");
  p.age_years = read.number(root, at + "age_years");
  p.muscle = read.number(root, at + "muscle");
  p.weight = read.number(root, at + "weight");
  p.height = read.number(root, at + "height");
  p.proportions = read.number(root, at + "proportions");
  p.cup = read.number(root, at + "cup");
  p.firmness = read.number(root, at + "firmness");
  p.race = {read.number(root, at + "race/african"), read.number(root, at + "race/asian"),
            read.number(root, at + "race/caucasian")};
  if (read.fault()) return *read.fault();
  const Json& parameters = root["body"]["parameters"];
  p.modifiers.assign(model.modifier_names().size(), 0);
  if (const auto all = parameters.find("modifiers"); all != parameters.end() && all->is_object())
    for (const auto& [name, value] : all->items()) {
      const int index = model.modifier_index(name);
      if (index < 0 || !value.is_number())
        return Error{ErrorCode::corrupt,
                     path + ": body/parameters/modifiers has " + name + ", which the body file lacks"};
      p.modifiers[static_cast<std::size_t>(index)] = value.get<float>();
    }
  if (const auto warp = parameters.find("warp"); warp != parameters.end() && warp->is_object())
    for (std::size_t i = 0; i < body::kWarpCount; ++i)
      if (const auto value = warp->find(std::string(body::kWarpNames[i])); value != warp->end() && value->is_number())
        p.warp.values[i] = value->get<float>();
  read_tape(root, out);
  return out;
}

}  // namespace im2fit
