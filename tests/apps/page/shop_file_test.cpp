// SPDX-License-Identifier: Apache-2.0
// A shop's file: what it changes on the page, and that a bad one is refused by file, key and reason.
#include "apps/kiosk/shop_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace im2fit::apps {
namespace {

using testing::HasSubstr;

class ShopFile : public testing::Test {
 protected:
  ShopFile() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-shop-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    write("logo.png", png(120, 40));
  }
  ~ShopFile() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  // Signature and header of a picture.
  static std::string png(int width, int height) {
    std::string bytes("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
    for (const int side : {width, height})
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(side >> shift);
    return bytes + std::string(20, '\0');
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << bytes;
    return folder_ + "/" + name;
  }
  Result<Shop> read(const Json& patch) const {
    Json json = whole_;
    json.merge_patch(patch);
    return read_shop(write("shop.json", json.dump()));
  }
  std::string fault_of(const Json& patch) const {
    const auto shop = read(patch);
    return shop ? "none" : shop.error().message;
  }
  std::string folder_;
  const Json whole_ = {
      {"schema", "im2fit.shop/1"},
      {"name", "Müller & Söhne"},
      {"logo", "logo.png"},
      {"colours", {{"light", {{"accent", "#7a1f3d"}, {"paper", "#ffffff"}}}, {"dark", {{"accent", "#F2A7BD"}}}}},
      {"consent",
       {{"version", "3"},
        {"operator", "Müller GmbH, Berlin"},
        {"purpose", {{"en", "to find your size"}, {"de", "um Ihre Größe zu finden"}}},
        {"contact", "privacy@mueller.example"}}}};
};

TEST_F(ShopFile, GivesNameLogoColoursAndWhomTheConsentNames) {
  const auto shop = read(Json::object());
  ASSERT_TRUE(shop) << shop.error().message;
  EXPECT_EQ(shop->name, "Müller & Söhne");
  EXPECT_EQ(shop->logo, png(120, 40));
  EXPECT_EQ(shop_css(*shop),
            "@media (prefers-color-scheme: light) { :root { --paper: #ffffff; --accent: #7a1f3d; --on-accent: "
            "#ffffff; } }\n"
            "@media (prefers-color-scheme: dark) { :root { --accent: #F2A7BD; --on-accent: #000000; } }\n");
  ASSERT_TRUE(shop->consent);
  EXPECT_EQ(shop->consent->purpose_in("de"), "um Ihre Größe zu finden");
  EXPECT_EQ(shop->consent->purpose_in("zh"), "to find your size");
  EXPECT_EQ(consent_version("2", *shop), "2+3");
  const Json told = shop_json(*shop);
  EXPECT_EQ(told["logo"], true);
  EXPECT_EQ(told["consent"]["contact"], "privacy@mueller.example");
  // Only a name is needed; one text of the purpose is of every language.
  const auto plain = read({{"logo", nullptr}, {"colours", nullptr}, {"consent", {{"purpose", "fit"}}}});
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(shop_css(*plain), "");
  EXPECT_EQ(plain->consent->purpose_in("fr"), "fit");
  const auto named = read({{"logo", nullptr}, {"colours", nullptr}, {"consent", nullptr}});
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(consent_version("2", *named), "2");
  EXPECT_FALSE(shop_json(*named).contains("consent"));
  EXPECT_EQ(consent_version("2", std::nullopt), "2");
}

TEST_F(ShopFile, ABadOneIsRefusedByFileKeyAndReason) {
  const std::pair<Json, const char*> kCases[] = {
      {{{"schema", "im2fit.shop/2"}}, "schema: expected \"im2fit.shop/1\""},
      {{{"name", nullptr}}, "name: is missing"},
      {{{"name", "  "}}, "name: is empty"},
      {{{"name", std::string(41, 'x')}}, "name: has 41 characters, expected at most 40"},
      {{{"name", "a\nb"}}, "name: has control characters"},
      {{{"colors", Json::object()}}, "colors: not known; keys are schema, name, logo, colours, consent"},
      {{{"colours", {{"light", {{"acent", "#000000"}}}}}}, "colours.light.acent: not known; keys are accent, paper"},
      {{{"colours", {{"light", {{"accent", "red"}}}}}},
       "colours.light.accent: is \"red\", expected a colour such as"},
      {{{"colours", {{"dark", {{"accent", 7}}}}}}, "colours.dark.accent: is 7, expected a colour"},
      {{{"colours", {{"light", {{"accent", "#ffee00"}}}}}},
       "colours.light.accent: #ffee00 has a contrast of 1.2 with #ffffff, expected at least 4.5"},
      {{{"colours", {{"light", {{"paper", "#777777"}}}}}}, "colours.light.paper: #777777 has a contrast of"},
      {{{"colours", "red"}}, "colours: expected an object"},
      {{{"logo", "none.png"}}, "logo: "},
      {{{"logo", "shop.json"}}, "shop.json is not a PNG picture"},
      {{{"logo", "wide.png"}}, "wide.png is 2049 x 40 pixels, expected at most 2048"},
      {{{"logo", "heavy.png"}}, "logo: "},
      {{{"consent", {{"operator", nullptr}}}}, "consent.operator: is missing"},
      {{{"consent", {{"contact", ""}}}}, "consent.contact: is empty"},
      {{{"consent", {{"purpose", nullptr}}}}, "consent.purpose: is missing"},
      {{{"consent", {{"purpose", {{"en", nullptr}}}}}}, "consent.purpose.en: is missing"},
      {{{"consent", {{"purpose", {{"xx", "y"}}}}}},
       "consent.purpose.xx: not a language of the page; they are en, de"},
      {{{"consent", {{"version", "3\"; x"}}}}, "consent.version: expected letters"},
      {{{"consent", 1}}, "consent: expected an object"}};
  write("wide.png", png(2049, 40));
  write("heavy.png", png(10, 10) + std::string(300'000, 'x'));
  for (const auto& [patch, expected] : kCases) {
    const std::string fault = fault_of(patch);
    EXPECT_THAT(fault, HasSubstr(folder_ + "/shop.json: ")) << expected;
    EXPECT_THAT(fault, HasSubstr(expected));
    EXPECT_EQ(fault.find('\n'), std::string::npos) << fault;
  }
  for (const char* text : {"[1]", "7", "{", ""}) {
    const auto shop = read_shop(write("shop.json", text));
    ASSERT_FALSE(shop) << text;
    EXPECT_THAT(shop.error().message, HasSubstr("shop.json: "));
  }
  EXPECT_FALSE(read_shop(folder_ + "/absent.json"));
}

// The colours that a shop's are judged by are those of the page.
TEST(ShopColours, AreThoseOfThePage) {
  std::ifstream file(std::string(IM2FIT_WEB_DIR) + "/page.css");
  const std::string css{std::istreambuf_iterator<char>(file), {}};
  const std::size_t dark = css.find("prefers-color-scheme: dark");
  ASSERT_NE(dark, std::string::npos);
  const auto value = [&](std::size_t scheme, const std::string& name) {
    const std::size_t at = css.find("--" + name + ": ", scheme == 0 ? 0 : dark) + name.size() + 4;
    const std::string found = css.substr(at, css.find_first_of(";} ", at) - at);
    return found.size() == 4 ? std::string("#") + found[1] + found[1] + found[2] + found[2] + found[3] + found[3]
                             : found;
  };
  for (std::size_t scheme = 0; scheme < kPageColours.size(); ++scheme) {
    const PageColours& page = kPageColours[scheme];
    EXPECT_EQ(value(scheme, "paper"), page.paper);
    EXPECT_EQ(value(scheme, "card"), page.card);
    EXPECT_EQ(value(scheme, "accent"), page.accent);
    const char* names[] = {"ink", "faint", "good", "amber", "red"};
    for (std::size_t i = 0; i < page.texts.size(); ++i) {
      EXPECT_EQ(value(scheme, names[i]), page.texts[i]) << names[i];
      EXPECT_GE(colour_contrast(page.texts[i], page.paper), 4.5) << names[i];
    }
  }
  EXPECT_NEAR(colour_contrast("#000000", "#ffffff"), 21, 1e-9);
  EXPECT_NEAR(colour_contrast("#777777", "#ffffff"), 4.48, 0.01);
}

}  // namespace
}  // namespace im2fit::apps
