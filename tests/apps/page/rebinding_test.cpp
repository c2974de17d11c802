// SPDX-License-Identifier: Apache-2.0
// What a page of another site gets in a real browser: nothing.
#include <gtest/gtest.h>

#include <thread>

#include "apps/kiosk/page_server.h"
#include "browser.h"

namespace im2fit {
namespace {

TEST(Rebinding, AForeignNameAndAForeignPageGetNothingInABrowser) {
  if (!test::Browser::installed()) GTEST_SKIP() << "no chromium: scripts/deps browser";
  apps::Board board;
  board.put("/result.json", {"application/json", R"({"chest": "of a customer"})"});
  // The smallest picture: a page that may load it learns that a person stands there.
  board.put("/picture.svg", {"image/svg+xml", "<svg xmlns='http://www.w3.org/2000/svg' width='3' height='3'/>"});
  auto page = apps::PageServer::open({"127.0.0.1", 0}, board);
  ASSERT_TRUE(page) << page.error().message;
  const std::string own = (*page)->url();
  const std::string port = own.substr(own.rfind(':'));

  httplib::Server elsewhere;
  elsewhere.Get("/",
                [](const httplib::Request&, httplib::Response& r) { r.set_content("<p>a page</p>", "text/html"); });
  const int other_port = elsewhere.bind_to_any_port("127.0.0.1");
  std::thread serving([&] { elsewhere.listen_after_bind(); });
  {
    test::TestFolder folder;
    // Every name leads here, as an attacker's name server would say.
    test::Browser browser(folder.path(""), {"--host-resolver-rules=MAP *.example 127.0.0.1"});
    EXPECT_TRUE(browser.ready()) << browser.messages();
    const auto text_at = [&](const std::string& url) {
      browser.go(url);
      return browser.run("return document.body.innerText").get<std::string>();
    };
    const auto has_chest = [](const std::string& text) { return text.find("of a customer") != std::string::npos; };
    EXPECT_TRUE(has_chest(text_at(own + "result.json")));
    EXPECT_FALSE(has_chest(text_at("http://127.attacker.example" + port + "result.json")));
    EXPECT_FALSE(has_chest(text_at("http://localhost.example" + port + "result.json")));

    const std::string picture =
        "const i = new Image(); window.verdict = null;"
        "i.onload = () => { window.verdict = 'seen'; }; i.onerror = () => { window.verdict = 'refused'; };";
    const auto verdict = [&] {
      browser.run(picture + "i.src = '" + own + "picture.svg'");
      EXPECT_TRUE(browser.wait_for("return window.verdict !== null"));
      return browser.run("return window.verdict");
    };
    browser.go(own + "result.json");
    EXPECT_EQ(verdict(), "seen");
    browser.go("http://shop.example:" + std::to_string(other_port) + "/");
    EXPECT_EQ(verdict(), "refused");
  }
  elsewhere.stop();
  serving.join();
}

}  // namespace
}  // namespace im2fit
