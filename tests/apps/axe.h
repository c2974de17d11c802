// SPDX-License-Identifier: Apache-2.0
// axe-core's rules for WCAG 2.1 A and AA and its best practices, on a page in a browser. scripts/page-check fetches
// it.
#pragma once

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "browser.h"

namespace im2fit::test {

// axe-core's source; "" where there is none.
inline std::string axe_script() {
  const char* path = std::getenv("IM2FIT_AXE");
  std::ifstream file(path != nullptr ? path : "");
  std::string source{std::istreambuf_iterator<char>(file), {}};
  return source.size() < 100'000 ? "" : source;
}

// What it says against the page as it stands: pairs of a rule and the elements that break it.
inline nlohmann::json axe_violations(Browser& browser, const std::string& axe) {
  if (browser.run("return typeof axe") == "undefined") browser.run(axe + ";window.axe = axe;");
  return browser.run_until_called(R"js(
    const done = arguments[arguments.length - 1];
    axe.run(document, {resultTypes: ['violations']}).then(
      (r) => done(r.violations.map((v) => [v.id, v.nodes.map((n) => n.html.slice(0, 200))])), (e) => done(String(e)));
  )js");
}

// Light and dark.
inline void prefer_colours(Browser& browser, const char* scheme) {
  browser.devtools("Emulation.setEmulatedMedia", {{"features",
                                                   {{{"name", "prefers-color-scheme"}, {"value", scheme}},
                                                    {{"name", "prefers-reduced-motion"}, {"value", "reduce"}}}}});
}
inline constexpr const char* kColourSchemes[] = {"light", "dark"};

}  // namespace im2fit::test
