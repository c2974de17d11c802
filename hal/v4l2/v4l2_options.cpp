// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/v4l2_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace im2fit::hal {
namespace {

std::optional<int> whole_number(std::string_view text, int min, int max) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < min || value > max) return std::nullopt;
  return value;
}

// Degrees with up to three decimals: locales have no say here.
std::optional<float> angle_deg(std::string_view text) {
  const std::size_t point = text.find('.');
  const auto whole = whole_number(text.substr(0, point), 10, 150);
  const std::string_view decimals = point == text.npos ? std::string_view("0") : text.substr(point + 1);
  const auto fraction = decimals.size() <= 3 ? whole_number(decimals, 0, 999) : std::nullopt;
  if (!whole || !fraction) return std::nullopt;
  int scale = 1;
  for (std::size_t i = 0; i < decimals.size(); ++i) scale *= 10;
  return static_cast<float>(*whole) + static_cast<float>(*fraction) / static_cast<float>(scale);
}

Error refused(std::string_view key, std::string_view value, const char* expected) {
  return {ErrorCode::invalid_argument,
          "v4l2: " + std::string(key) + " is '" + std::string(value) + "', expected " + expected};
}

// "%20" and the like, because names of controls have spaces.
std::string unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    int code = 0;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(text.data() + i + 1, text.data() + i + 3, code, 16).ptr == text.data() + i + 3) {
      plain += static_cast<char>(code);
      i += 2;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

std::string escaped(const std::string& text) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string safe;
  for (const char c : text) {
    if (c > ' ' && c < 0x7F && c != '%' && c != '&' && c != '?') {
      safe += c;
    } else {
      safe += '%';
      safe += kDigits[c >> 4 & 0xF];
      safe += kDigits[c & 0xF];
    }
  }
  return safe;
}

const char* name_of(V4l2Format format) {
  if (format == V4l2Format::z16) return "Z16";
  return format == V4l2Format::inzi ? "INZI" : "Y16";
}

Status apply(std::string_view key, std::string_view value, V4l2Options& options) {
  if (key == "format") {
    if (value == "Z16")
      options.format = V4l2Format::z16;
    else if (value == "INZI")
      options.format = V4l2Format::inzi;
    else if (value == "Y16")
      options.format = V4l2Format::y16;
    else
      return refused(key, value, "Z16, INZI or Y16");
  } else if (key == "unit_um") {
    const auto unit = whole_number(value, 1, 100'000);
    if (!unit) return refused(key, value, "1 to 100000 micrometres to a step");
    options.unit_um = *unit;
  } else if (key == "unit_control") {
    if (value.empty()) return refused(key, value, "the name of one of the driver's controls");
    options.unit_control = unescaped(value);
  } else if (key == "hfov") {
    const auto angle = angle_deg(value);
    if (!angle) return refused(key, value, "10 to 150 degrees");
    options.hfov_deg = *angle;
  } else if (key == "size") {
    const std::size_t by = value.find('x');
    const auto width = whole_number(value.substr(0, by), 1, kImageSideMax);
    const auto height = by == value.npos ? std::nullopt : whole_number(value.substr(by + 1), 1, kImageSideMax);
    if (!width || !height) return refused(key, value, "WIDTHxHEIGHT, 1 to 2048 pixels a side");
    options.width = *width;
    options.height = *height;
  } else if (key == "fps") {
    const auto fps = whole_number(value, 1, 1000);
    if (!fps) return refused(key, value, "1 to 1000 frames a second");
    options.fps = *fps;
  } else if (key == "serial") {
    options.serial = unescaped(value);
  } else {
    return Error{ErrorCode::invalid_argument,
                 "v4l2: no key '" + std::string(key) +
                     "'; there are format, unit_um, unit_control, hfov, size, fps and serial"};
  }
  return Ok{};
}

}  // namespace

Result<V4l2Options> parse_v4l2_uri(const std::string& text, const V4l2Options& defaults) {
  V4l2Options options = defaults;
  const std::size_t question = text.find('?');
  options.path = text.substr(0, question);
  std::string_view rest = question == text.npos ? std::string_view() : std::string_view(text).substr(question + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const std::size_t equals = pair.find('=');
    const std::string_view value = equals == pair.npos ? std::string_view() : pair.substr(equals + 1);
    if (auto ok = apply(pair.substr(0, equals), value, options); !ok) return ok.error();
  }
  return options;
}

std::string v4l2_uri(const V4l2Options& options) {
  const V4l2Options plain;
  std::string keys;
  const auto add = [&](const char* key, const std::string& value) {
    keys += (keys.empty() ? "?" : "&") + std::string(key) + "=" + value;
  };
  if (!options.serial.empty()) add("serial", escaped(options.serial));
  if (options.format) add("format", name_of(*options.format));
  if (options.unit_um) add("unit_um", std::to_string(*options.unit_um));
  if (!options.unit_control.empty()) add("unit_control", escaped(options.unit_control));
  if (options.hfov_deg && !options.calibration) {
    const long thousandths = std::lround(static_cast<double>(*options.hfov_deg) * 1000);
    std::string decimals = "." + std::to_string(1000 + thousandths % 1000).substr(1);
    while (decimals.back() == '0') decimals.pop_back();
    add("hfov", std::to_string(thousandths / 1000) + (decimals == "." ? "" : decimals));
  }
  if (options.width != plain.width || options.height != plain.height)
    add("size", std::to_string(options.width) + "x" + std::to_string(options.height));
  if (options.fps != plain.fps) add("fps", std::to_string(options.fps));
  return "v4l2:" + (options.serial.empty() ? options.path : std::string()) + keys;
}

}  // namespace im2fit::hal
