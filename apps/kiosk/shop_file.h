// SPDX-License-Identifier: Apache-2.0
// The shop that measures: its name, logo and colours on the page, and who is named in the consent. A JSON file,
// schema im2fit.shop/1, described in docs/page.md ("A shop's own page").
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "apps/common/events.h"
#include "core/status.h"

namespace im2fit::apps {

// Who measures, what for, and whom to ask: added to the consent.
struct ShopConsent {
  std::string version;  // changed by the shop with its words
  std::string operator_name;
  std::map<std::string, std::string> purpose;  // by language; "en" is there and stands for those that are not
  std::string contact;
  const std::string& purpose_in(const std::string& language) const;
};

struct Shop {
  std::string name;
  std::string logo;                    // of a PNG its bytes; "": none
  std::array<std::string, 2> accent;   // "#rrggbb" by scheme, light and dark; "": the page's own
  std::array<std::string, 2> paper;    // of the background
  std::optional<ShopConsent> consent;  // none: nobody is named
};

// Errors: as read_file; corrupt, naming the file, the key and the reason.
Result<Shop> read_shop(const std::string& path);
// Of the file's text: `path` names it in errors, and its logo's name is relative to it.
Result<Shop> parse_shop(std::string_view text, const std::string& path);
// The style sheet of its colours.
std::string shop_css(const Shop& shop);
// What the page is told of it: "name", "logo" (whether there is one), "consent".
Json shop_json(const Shop& shop);
// Of the text that people agree to: that of the page's own text, and the shop's behind a "+".
std::string consent_version(const std::string& own, const std::optional<Shop>& shop);

// WCAG 2.1: from 1 (the same) to 21 (black on white). Of "#rrggbb".
double colour_contrast(std::string_view one, std::string_view other);
// The colours of text on the page's background, as web/page.css has them, by scheme.
struct PageColours {
  std::string_view paper, card, accent;
  std::array<std::string_view, 5> texts;  // ink, faint, good, amber, red
};
inline constexpr std::array<PageColours, 2> kPageColours = {
    {{"#f6f5f2", "#ffffff", "#17566d", {"#1c2025", "#555c64", "#1c6337", "#8a4b00", "#a3201b"}},
     {"#15181c", "#1e2329", "#8fd0e6", {"#eceef0", "#b0b8c0", "#86dca4", "#ffc46b", "#ff9d94"}}}};

}  // namespace im2fit::apps
