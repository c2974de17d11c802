// SPDX-License-Identifier: Apache-2.0
// The keywords of JSON Schema that docs/result.schema.json uses. A keyword it does not know is a failure, so that a
// schema cannot grow past its check.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace im2fit::test {

class SchemaCheck {
 public:
  explicit SchemaCheck(const nlohmann::json& schema) : root_(schema) {}
  // One line per violation; empty when valid.
  std::vector<std::string> run(const nlohmann::json& value) {
    faults_.clear();
    check(root_, value, "$");
    return faults_;
  }

 private:
  using Json = nlohmann::json;

  static bool is_type(const Json& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "boolean") return value.is_boolean();
    if (type == "null") return value.is_null();
    return false;
  }

  void fault(const std::string& at, const std::string& what) { faults_.push_back(at + ": " + what); }

  void check(const Json& schema, const Json& value, const std::string& at) {
    static const std::set<std::string> kKnown = {"$schema",
                                                 "$defs",
                                                 "title",
                                                 "$ref",
                                                 "type",
                                                 "const",
                                                 "enum",
                                                 "items",
                                                 "minItems",
                                                 "maxItems",
                                                 "required",
                                                 "minimum",
                                                 "maximum",
                                                 "properties",
                                                 "uniqueItems",
                                                 "additionalProperties",
                                                 "exclusiveMinimum"};
    for (const auto& [key, unused] : schema.items())
      if (kKnown.count(key) == 0) fault(at, "schema keyword " + key + " is not checked");
    if (schema.contains("$ref"))
      check(root_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))), value, at);
    check_type(schema, value, at);
    if (schema.contains("const") && value != schema["const"]) fault(at, "is not " + schema["const"].dump());
    if (schema.contains("enum")) {
      bool found = false;
      for (const Json& one : schema["enum"]) found = found || one == value;
      if (!found) fault(at, value.dump() + " is not one of " + schema["enum"].dump());
    }
    if (value.is_number()) check_number(schema, value.get<double>(), at);
    if (value.is_array()) check_array(schema, value, at);
    if (value.is_object()) check_object(schema, value, at);
  }

  void check_type(const Json& schema, const Json& value, const std::string& at) {
    if (!schema.contains("type")) return;
    const Json& types = schema["type"];
    bool fits = types.is_string() && is_type(value, types.get<std::string>());
    if (types.is_array())
      for (const Json& type : types) fits = fits || is_type(value, type.get<std::string>());
    if (!fits) fault(at, value.dump() + " is not of type " + types.dump());
  }

  void check_number(const Json& schema, double value, const std::string& at) {
    if (schema.contains("minimum") && value < schema["minimum"].get<double>()) fault(at, "too small");
    if (schema.contains("maximum") && value > schema["maximum"].get<double>()) fault(at, "too large");
    if (schema.contains("exclusiveMinimum") && value <= schema["exclusiveMinimum"].get<double>())
      fault(at, "too small");
  }

  void check_array(const Json& schema, const Json& value, const std::string& at) {
    if (schema.contains("minItems") && value.size() < schema["minItems"].get<std::size_t>()) fault(at, "too short");
    if (schema.contains("maxItems") && value.size() > schema["maxItems"].get<std::size_t>()) fault(at, "too long");
    if (schema.value("uniqueItems", false) && std::set<Json>(value.begin(), value.end()).size() != value.size())
      fault(at, "has an item twice");
    if (!schema.contains("items")) return;
    for (std::size_t i = 0; i < value.size(); ++i)
      check(schema["items"], value[i], at + "[" + std::to_string(i) + "]");
  }

  void check_object(const Json& schema, const Json& value, const std::string& at) {
    if (schema.contains("required"))
      for (const Json& name : schema["required"])
        if (!value.contains(name.get<std::string>())) fault(at, "has no " + name.dump());
    for (const auto& [name, member] : value.items()) {
      const std::string place = at + "." + name;
      if (schema.contains("properties") && schema["properties"].contains(name)) {
        check(schema["properties"][name], member, place);
      } else if (schema.contains("additionalProperties")) {
        const Json& extra = schema["additionalProperties"];
        if (extra.is_object())
          check(extra, member, place);
        else if (!extra.get<bool>())
          fault(place, "is not in the schema");
      }
    }
  }

  Json root_;
  std::vector<std::string> faults_;
};

}  // namespace im2fit::test
