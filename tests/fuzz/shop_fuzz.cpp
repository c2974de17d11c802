// SPDX-License-Identifier: Apache-2.0
// A shop's file as anyone may write it: refused with one line, or a shop that the page can show.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "apps/kiosk/shop_file.h"
#include "core/text.h"
#include "formats/json_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // A name of a logo may lead anywhere, and its text may be escaped: no file of this machine is read here.
  if (const auto json = parse_json<apps::Json>(text, "shop.json");
      json && json->is_object() && json->contains("logo"))
    if (const auto& logo = (*json)["logo"];
        logo.is_string() && logo.get<std::string>().find('/') != std::string::npos)
      return 0;
  const auto shop = apps::parse_shop(text, "/nowhere/shop.json");
  if (!shop) {
    if (shop.error().message.empty() || shop.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  if (shop->name.empty() || printable(shop->name) != shop->name || character_count(shop->name) > 40) __builtin_trap();
  // A style sheet that a text could end would be the shop's own code.
  const std::string css = apps::shop_css(*shop);
  for (const char* bad : {"<", ";;", "url", "/*"})
    if (css.find(bad) != std::string::npos) __builtin_trap();
  for (std::size_t i = 0; i < 2; ++i)
    for (const std::string& colour : {shop->accent[i], shop->paper[i]})
      if (!colour.empty() && colour.size() != 7) __builtin_trap();
  if (shop->consent) {
    for (const char* language : {"en", "de", "xx"})
      if (shop->consent->purpose_in(language).empty()) __builtin_trap();
    if (apps::consent_version("1", *shop) != "1+" + shop->consent->version) __builtin_trap();
  }
  if (!parse_json(json_text(apps::shop_json(*shop)), "again")) __builtin_trap();
  return 0;
}
