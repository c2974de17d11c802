// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/shop_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>

#include "core/file.h"
#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

constexpr char kShopSchema[] = "im2fit.shop/1";
constexpr std::array kSchemes = {"light", "dark"};
constexpr std::array<std::string_view, 5> kLanguages = {"en", "de", "es", "fr", "zh"};
constexpr std::size_t kNameMax = 40, kLineMax = 160, kVersionMax = 16;  // characters
constexpr std::size_t kLogoBytesMax = std::size_t{256} << 10;
constexpr std::uint32_t kLogoSideMax = 2048;
constexpr double kContrastMin = 4.5;  // WCAG 2.1, 1.4.3

// The first fault ends it.
class ShopReader {
 public:
  explicit ShopReader(const std::string& path) : path_(path) {}

  Result<Shop> read(const Json& json) {
    Shop shop;
    if (!keys(json, "", {"schema", "name", "logo", "colours", "consent"})) return Error{ErrorCode::corrupt, fault_};
    if (json.value("schema", Json()) != kShopSchema) wrong("schema", fmt::format("expected \"{}\"", kShopSchema));
    shop.name = line(json, "", "name", kNameMax);
    if (json.contains("logo")) shop.logo = logo(line(json, "", "logo", kLineMax));
    if (json.contains("colours")) colours(json["colours"], shop);
    if (json.contains("consent")) shop.consent = consent(json["consent"]);
    if (!fault_.empty()) return Error{ErrorCode::corrupt, fault_};
    return shop;
  }

 private:
  void wrong(const std::string& key, const std::string& reason) {
    if (fault_.empty()) fault_ = path_ + ": " + key + ": " + reason;
  }
  bool keys(const Json& json, const std::string& prefix, std::initializer_list<std::string_view> known) {
    if (!json.is_object()) {
      wrong(prefix.empty() ? "the file" : prefix.substr(0, prefix.size() - 1), "expected an object");
      return false;
    }
    for (const auto& [key, value] : json.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        wrong(prefix + excerpt(key), fmt::format("not known; keys are {}", fmt::join(known, ", ")));
    return true;
  }
  std::string text(const Json& value, const std::string& key, std::size_t characters_max) {
    if (!value.is_string()) {
      wrong(key, "expected a text");
      return "";
    }
    auto found = value.get<std::string>();
    if (found.find_first_not_of(' ') == std::string::npos) wrong(key, "is empty");
    if (printable(found) != found) wrong(key, "has control characters");
    if (const auto count = character_count(found); count > characters_max)
      wrong(key, fmt::format("has {} characters, expected at most {}", count, characters_max));
    return found;
  }
  std::string line(const Json& json, const std::string& prefix, const char* key, std::size_t characters_max) {
    const auto found = json.is_object() ? json.find(key) : json.end();
    if (found != json.end()) return text(*found, prefix + key, characters_max);
    wrong(prefix + key, "is missing");
    return "";
  }

  // A name is relative to the shop's file.
  std::string logo(const std::string& name) {
    if (!fault_.empty()) return "";
    const std::string path = (std::filesystem::path(path_).parent_path() / name).string();
    const auto bytes = read_file(path, kLogoBytesMax);
    if (!bytes) {
      wrong("logo", bytes.error().message);
      return "";
    }
    // PNG 1.2, 5.2 and 11.2.2: signature, then the chunk IHDR with width and height.
    std::string png(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    if (png.size() < 33 || png.compare(0, 8, "\x89PNG\r\n\x1a\n", 8) != 0 || png.compare(12, 4, "IHDR") != 0) {
      wrong("logo", path + " is not a PNG picture");
      return "";
    }
    const auto number = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t i = at; i < at + 4; ++i) value = value << 8U | static_cast<unsigned char>(png[i]);
      return value;
    };
    for (const std::uint32_t side : {number(16), number(20)})
      if (side == 0 || side > kLogoSideMax)
        wrong("logo",
              fmt::format("{} is {} x {} pixels, expected at most {}", path, number(16), number(20), kLogoSideMax));
    return png;
  }

  std::string colour(const Json& json, const std::string& prefix, const char* key) {
    if (!json.contains(key)) return "";
    const Json& value = json[key];
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    if (text.size() == 7 && text[0] == '#' &&
        text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos)
      return text;
    wrong(prefix + key, "is " + excerpt(json_text(value)) + ", expected a colour such as \"#17566d\"");
    return "";
  }
  void colours(const Json& json, Shop& shop) {
    if (!keys(json, "colours.", {"light", "dark"})) return;
    for (std::size_t i = 0; i < kSchemes.size(); ++i) {
      if (!json.contains(kSchemes[i])) continue;
      const std::string prefix = fmt::format("colours.{}.", kSchemes[i]);
      const Json& scheme = json[kSchemes[i]];
      if (!keys(scheme, prefix, {"accent", "paper"})) return;
      shop.accent[i] = colour(scheme, prefix, "accent");
      shop.paper[i] = colour(scheme, prefix, "paper");
      if (fault_.empty()) legible(prefix, kPageColours[i], shop.accent[i], shop.paper[i]);
    }
  }
  // All text of the page stays legible on its background.
  void legible(const std::string& prefix, const PageColours& page, const std::string& accent,
               const std::string& paper) {
    const std::string_view ground = paper.empty() ? page.paper : paper;
    const auto check = [&](const char* key, const std::string& colour, std::string_view other) {
      const double contrast = colour_contrast(colour, other);
      if (contrast < kContrastMin)
        wrong(prefix + key, fmt::format("{} has a contrast of {:.1f} with {}, expected at least {}", colour, contrast,
                                        other, kContrastMin));
    };
    if (!paper.empty()) {
      for (const std::string_view text : page.texts) check("paper", paper, text);
      if (accent.empty()) check("paper", paper, page.accent);
    }
    if (!accent.empty())
      for (const std::string_view other : {ground, page.card}) check("accent", accent, other);
  }

  ShopConsent consent(const Json& json) {
    ShopConsent found;
    if (!keys(json, "consent.", {"version", "operator", "purpose", "contact"})) return found;
    found.version = line(json, "consent.", "version", kVersionMax);
    if (found.version.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-") !=
        std::string::npos)
      wrong("consent.version", "expected letters, digits, . and - such as \"2\"");
    found.operator_name = line(json, "consent.", "operator", kLineMax);
    found.contact = line(json, "consent.", "contact", kLineMax);
    const auto purpose = json.find("purpose");
    if (purpose == json.end()) {
      wrong("consent.purpose", "is missing");
    } else if (!purpose->is_object()) {
      found.purpose["en"] = text(*purpose, "consent.purpose", kLineMax);
    } else {
      for (const auto& [language, words] : purpose->items()) {
        if (std::find(kLanguages.begin(), kLanguages.end(), language) == kLanguages.end())
          wrong("consent.purpose." + excerpt(language),
                fmt::format("not a language of the page; they are {}", fmt::join(kLanguages, ", ")));
        else
          found.purpose[language] = text(words, "consent.purpose." + language, kLineMax);
      }
      if (!found.purpose.contains("en")) wrong("consent.purpose.en", "is missing; it stands for languages left out");
    }
    return found;
  }

  const std::string& path_;
  std::string fault_;
};

// WCAG 2.1, "relative luminance".
double luminance(std::string_view colour) {
  const auto channel = [&](std::size_t at) {
    const double share = std::stoi(std::string(colour.substr(at, 2)), nullptr, 16) / 255.0;
    return share <= 0.03928 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

}  // namespace

const std::string& ShopConsent::purpose_in(const std::string& language) const {
  const auto found = purpose.find(language);
  return found != purpose.end() ? found->second : purpose.at("en");
}

double colour_contrast(std::string_view one, std::string_view other) {
  const double a = luminance(one), b = luminance(other);
  return (std::max(a, b) + 0.05) / (std::min(a, b) + 0.05);
}

Result<Shop> read_shop(const std::string& path) {
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  return parse_shop({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

Result<Shop> parse_shop(std::string_view text, const std::string& path) {
  const auto json = parse_json<Json>(text, path);
  if (!json) return json.error();
  return ShopReader(path).read(*json);
}

std::string shop_css(const Shop& shop) {
  std::string css;
  for (std::size_t i = 0; i < kSchemes.size(); ++i) {
    std::string rules;
    if (!shop.paper[i].empty()) rules += " --paper: " + shop.paper[i] + ";";
    if (!shop.accent[i].empty()) {
      const bool white = colour_contrast(shop.accent[i], "#ffffff") >= colour_contrast(shop.accent[i], "#000000");
      rules += " --accent: " + shop.accent[i] + "; --on-accent: " + (white ? "#ffffff;" : "#000000;");
    }
    if (!rules.empty())
      css += fmt::format("@media (prefers-color-scheme: {}) {{ :root {{{} }} }}\n", kSchemes[i], rules);
  }
  return css;
}

Json shop_json(const Shop& shop) {
  Json json = {{"name", shop.name}, {"logo", !shop.logo.empty()}};
  if (shop.consent)
    json["consent"] = {{"version", shop.consent->version},
                       {"operator", shop.consent->operator_name},
                       {"purpose", shop.consent->purpose},
                       {"contact", shop.consent->contact}};
  return json;
}

std::string consent_version(const std::string& own, const std::optional<Shop>& shop) {
  return shop && shop->consent ? own + "+" + shop->consent->version : own;
}

}  // namespace im2fit::apps
