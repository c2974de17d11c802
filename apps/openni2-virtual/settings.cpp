// SPDX-License-Identifier: Apache-2.0
#include "settings.h"

#include <charconv>
#include <cstdlib>
#include <filesystem>

namespace im2fit::openni2_virtual {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

template <class Number>
bool to_number(const std::string& text, Number& value) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size();
}

Error off(const std::string& key, const std::string& value, const std::string& expected) {
  return {ErrorCode::invalid_argument, "virtual camera: " + key + " is \"" + value + "\", expected " + expected};
}

Status set_whole(int& field, const std::string& key, const std::string& value, int low, int high) {
  int number = 0;
  if (!to_number(value, number) || number < low || number > high)
    return off(key, value, std::to_string(low) + " to " + std::to_string(high));
  field = number;
  return Ok{};
}

Status set_word(std::string& field, const std::string& key, const std::string& value,
                std::initializer_list<const char*> words) {
  std::string all;
  for (const char* word : words) {
    if (value == word) {
      field = value;
      return Ok{};
    }
    all += (all.empty() ? "" : ", ") + std::string(word);
  }
  return off(key, value, all);
}

Status set_size(Settings& settings, const std::string& value) {
  if (value == "640x480" || value == "320x240") {
    settings.width = value == "640x480" ? 640 : 320;
    settings.height = settings.width * 3 / 4;
    return Ok{};
  }
  return off("size", value, "640x480 or 320x240");
}

Status set(Settings& settings, const std::string& key, const std::string& value) {
  if (key == "seed") return to_number(value, settings.seed) ? Status(Ok{}) : off(key, value, "a whole number");
  if (key == "body") return settings.body_path = value, Ok{};
  if (key == "folder") return settings.folder = value, Ok{};
  if (key == "family") return set_word(settings.family, key, value, {"training", "held_out", "paper"});
  if (key == "pose") return set_word(settings.pose, key, value, {"relaxed", "a_pose", "psi", "free"});
  if (key == "size") return set_size(settings, value);
  if (key == "fps") return set_whole(settings.fps, key, value, 1, 1000);
  if (key == "rotate") {
    std::string word;
    if (auto ok = set_word(word, key, value, {"0", "90", "180", "270"}); !ok) return ok;
    return set_whole(settings.rotate_deg, key, value, 0, 270);
  }
  if (key == "furniture") return set_whole(settings.furniture_count, key, value, 0, 20);
  if (key == "noise") return set_whole(settings.noise, key, value, 0, 1);
  if (key == "back") return set_whole(settings.back_view, key, value, 0, 1);
  if (key == "unplug_ms") return set_whole(settings.unplug_ms, key, value, 0, 1'000'000'000);
  if (key == "replug_ms") return set_whole(settings.replug_ms, key, value, 0, 1'000'000'000);
  if (key == "plug") return set_whole(settings.plug, key, value, 0, 1'000'000'000);
  return off("key", key,
             "seed, body, folder, family, pose, size, fps, rotate, furniture, noise, back, unplug_ms, replug_ms or "
             "plug");
}

constexpr std::pair<const char*, const char*> kEnvironment[] = {
    {"seed", "IM2FIT_VIRTUAL_SEED"},           {"body", "IM2FIT_BODY"},
    {"body", "IM2FIT_VIRTUAL_BODY"},           {"folder", "IM2FIT_VIRTUAL_FOLDER"},
    {"family", "IM2FIT_VIRTUAL_FAMILY"},       {"pose", "IM2FIT_VIRTUAL_POSE"},
    {"size", "IM2FIT_VIRTUAL_SIZE"},           {"fps", "IM2FIT_VIRTUAL_FPS"},
    {"rotate", "IM2FIT_VIRTUAL_ROTATE"},       {"furniture", "IM2FIT_VIRTUAL_FURNITURE"},
    {"noise", "IM2FIT_VIRTUAL_NOISE"},         {"back", "IM2FIT_VIRTUAL_BACK"},
    {"unplug_ms", "IM2FIT_VIRTUAL_UNPLUG_MS"}, {"replug_ms", "IM2FIT_VIRTUAL_REPLUG_MS"}};

std::string default_body_path() {
  std::string cache = environment("XDG_CACHE_HOME");
  if (cache.empty()) cache = environment("HOME") + "/.cache";
  return cache + "/im2fit/body.i2b";
}

}  // namespace

std::string announced_uri() {
  const std::string seed = environment("IM2FIT_VIRTUAL_SEED");
  if (seed.empty() && environment("IM2FIT_VIRTUAL_FOLDER").empty()) return "";
  return kScheme + (seed.empty() ? std::string("0") : seed);
}

std::string plugged_in_again(const std::string& uri) {
  const auto settings = settings_of(uri);
  const auto at = uri.rfind("plug=");
  const bool numbered = at != std::string::npos && (uri[at - 1] == '?' || uri[at - 1] == '&');
  const std::string number = "plug=" + std::to_string(settings ? settings->plug + 1 : 1);
  if (numbered) return uri.substr(0, at) + number;  // the last key: it was put there here
  return uri + (uri.find('?') == std::string::npos ? "?" : "&") + number;
}

Result<Settings> settings_of(const std::string& uri) {
  Settings settings;
  settings.body_path = default_body_path();
  for (const auto& [key, variable] : kEnvironment) {
    const std::string value = environment(variable);
    if (value.empty()) continue;
    if (auto ok = set(settings, key, value); !ok) return ok.error();
  }
  std::string rest = uri.substr(std::string(kScheme).size());
  const auto query = rest.find('?');
  const std::string seed = rest.substr(0, query);
  if (!seed.empty()) {
    if (auto ok = set(settings, "seed", seed); !ok) return ok.error();
  }
  rest = query == std::string::npos ? "" : rest.substr(query + 1);
  while (!rest.empty()) {
    const auto end = rest.find('&');
    const std::string pair = rest.substr(0, end);
    const auto equals = pair.find('=');
    if (equals == std::string::npos) return off("query", pair, "key=value");
    if (auto ok = set(settings, pair.substr(0, equals), pair.substr(equals + 1)); !ok) return ok.error();
    rest = end == std::string::npos ? "" : rest.substr(end + 1);
  }
  return settings;
}

}  // namespace im2fit::openni2_virtual
