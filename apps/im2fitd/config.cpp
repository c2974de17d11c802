// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fitd/config.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "core/file.h"
#include "engine/engine.h"

namespace im2fit::daemon {
namespace {

// What is wrong, and where.
struct Wrong {
  int line = 0;
  std::string what;
  bool named = false;  // the key is in it
};
const std::set<std::string> kMaps = {"measure", "consent", "socket"};

// Reads a value or throws Wrong; YAML's own exceptions mean that the value is of another kind.
using Reader = std::function<void(const YAML::Node&)>;
using Readers = std::map<std::string, Reader>;

[[noreturn]] void refuse(const YAML::Node& node, const std::string& what) {
  throw Wrong{node.Mark().line + 1, what, false};
}

std::string shown(const YAML::Node& node) {
  return node.IsScalar() ? "\"" + node.Scalar() + "\"" : node.IsNull() ? "empty" : "not a single value";
}

Reader text(std::string& field, bool may_be_empty = true) {
  return [&field, may_be_empty](const YAML::Node& node) {
    if (!node.IsScalar() && !node.IsNull()) refuse(node, "is " + shown(node) + ", expected a text");
    field = node.IsNull() ? "" : node.Scalar();
    if (field.empty() && !may_be_empty) refuse(node, "is empty, expected a text");
  };
}

Reader whole(int& field, int low, int high) {
  return [&field, low, high](const YAML::Node& node) {
    int value = 0;
    if (!node.IsScalar() || !YAML::convert<int>::decode(node, value) || value < low || value > high)
      refuse(node, "is " + shown(node) + ", expected a whole number from " + std::to_string(low) + " to " +
                       std::to_string(high));
    field = value;
  };
}

Reader yes_or_no(bool& field) {
  return [&field](const YAML::Node& node) {
    if (!node.IsScalar() || !YAML::convert<bool>::decode(node, field))
      refuse(node, "is " + shown(node) + ", expected true or false");
  };
}

// true and false: as older files say back and none.
Reader turn(std::string& field) {
  return [&field](const YAML::Node& node) {
    bool back = false;
    if (node.IsScalar() && std::find(kTurnNames.begin(), kTurnNames.end(), node.Scalar()) != kTurnNames.end())
      field = node.Scalar();
    else if (node.IsScalar() && YAML::convert<bool>::decode(node, back))
      field = kTurnNames[back ? 1 : 0];
    else
      refuse(node, "is " + shown(node) + ", expected none, back, around or walk");
  };
}

Reader one_of(std::string& field, const std::vector<std::string>& words) {
  return [&field, words](const YAML::Node& node) {
    std::string all;
    for (const auto& word : words) {
      if (node.IsScalar() && node.Scalar() == word) {
        field = word;
        return;
      }
      all += (all.empty() ? "" : ", ") + word;
    }
    refuse(node, "is " + shown(node) + ", expected one of " + all);
  };
}

Reader rotation(int& field) {
  return [&field](const YAML::Node& node) {
    whole(field, 0, 270)(node);
    if (!hal::is_rotation(field)) refuse(node, "is " + shown(node) + ", expected 0, 90, 180 or 270");
  };
}

// Octal, as chmod(1) takes it; YAML would read 0660 without quotes as another number.
Reader mode(unsigned& field) {
  return [&field](const YAML::Node& node) {
    const std::string word = node.IsScalar() ? node.Scalar() : "";
    bool good = word.size() == 3 || (word.size() == 4 && word[0] == '0');
    for (const char c : word) good = good && c >= '0' && c <= '7';
    if (!good) refuse(node, "is " + shown(node) + ", expected three octal digits such as \"0660\"");
    field = static_cast<unsigned>(std::stoul(word, nullptr, 8));
  };
}

Reader texts(std::vector<std::string>& field) {
  return [&field](const YAML::Node& node) {
    if (!node.IsSequence()) refuse(node, "is not a list; write [FILE, FILE]");
    field.clear();
    for (const auto& item : node) {
      if (!item.IsScalar()) refuse(item, "has an item that is not a text");
      field.push_back(item.Scalar());
    }
  };
}

Reader region(std::string& field) {
  return [&field](const YAML::Node& node) {
    text(field)(node);
    if (!field.empty() && !apps::region_of(field)) refuse(node, apps::region_fault(field));
  };
}

void read_map(const YAML::Node& map, const std::string& prefix, const Readers& readers) {
  if (!map.IsMap()) refuse(map, std::string(prefix.empty() ? "the file " : "") + "holds no `key: value` lines");
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    const auto reader = readers.find(key);
    if (reader == readers.end()) {
      std::string known;
      for (const auto& [word, unused] : readers) known += (known.empty() ? "" : ", ") + word;
      refuse(entry.first, "unknown key \"" + name + "\"; known keys are " + known);
    }
    if (!seen.insert(key).second) refuse(entry.first, "\"" + name + "\" appears twice");
    try {
      reader->second(entry.second);
    } catch (const Wrong& wrong) {
      // A map of settings has named its key already; an empty value has no line of its own.
      const bool named = wrong.named || (entry.second.IsMap() && prefix.empty() && kMaps.count(key) != 0);
      throw Wrong{entry.second.IsNull() ? entry.first.Mark().line + 1 : wrong.line,
                  named ? wrong.what : name + " " + wrong.what, true};
    }
  }
}

Config interpret(const YAML::Node& root) {
  Config config;
  apps::MeasuringOptions& m = config.measuring;
  m.live = true;
  m.one_after_another = true;
  m.rest = true;
  int buffer_kib = static_cast<int>(config.client_buffer_bytes / 1024);
  const Readers measure = {{"frames", whole(m.frames, 1, 1000)},
                           {"calibration", one_of(m.calibration, {"none", "psi"})},
                           {"turn", turn(m.turn)},
                           {"clothing", one_of(m.clothing, {kClothingGivenNames.begin(), kClothingGivenNames.end()})},
                           {"sensor", one_of(m.sensor, {kSensorKindNames.begin(), kSensorKindNames.end()})},
                           {"threads", whole(m.threads, 1, 2)},
                           {"region", region(m.region)},
                           {"size_charts", texts(m.size_charts)},
                           {"calibration_site", text(m.site)}};
  const Readers consent = {{"ask", yes_or_no(config.consent_ask)},
                           {"absent_s", whole(config.consent_absent_s, 1, 3600)}};
  const Readers socket = {{"path", text(config.socket_path, false)},
                          {"mode", mode(config.socket_mode)},
                          {"group", text(config.socket_group)},
                          {"clients", whole(config.clients_max, 1, 1000)},
                          {"client_buffer_kib", whole(buffer_kib, 16, 65536)}};
  const Readers top = {{"source", text(config.source, false)},
                       {"rotate", rotation(config.rotate_deg)},
                       {"camera", text(config.camera_yaml)},
                       {"body", text(config.body, false)},
                       {"tracker", text(m.tracker, false)},
                       {"index", text(m.index, false)},
                       {"measure", [&](const YAML::Node& node) { read_map(node, "measure", measure); }},
                       {"consent", [&](const YAML::Node& node) { read_map(node, "consent", consent); }},
                       {"socket", [&](const YAML::Node& node) { read_map(node, "socket", socket); }},
                       {"state_directory", text(config.state_directory)}};
  read_map(root, "", top);
  config.client_buffer_bytes = static_cast<std::size_t>(buffer_kib) * 1024;
  return config;
}

}  // namespace

Result<Config> load_config(const std::string& path) {
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  const auto at = [&](int line, const std::string& what) {
    return Error{ErrorCode::invalid_argument,
                 path + " line " + std::to_string(line) + ": " + what + " (docs/daemon.md lists every key)"};
  };
  try {
    return interpret(YAML::Load(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())));
  } catch (const Wrong& wrong) {
    return at(std::max(1, wrong.line), wrong.what);
  } catch (const YAML::Exception& wrong) {
    return at(wrong.mark.line + 1, wrong.msg);
  }
}

}  // namespace im2fit::daemon
