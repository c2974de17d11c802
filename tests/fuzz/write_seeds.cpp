// SPDX-License-Identifier: Apache-2.0
// Sound files for the fuzzers to start from: write_seeds DIRECTORY makes DIRECTORY/index, DIRECTORY/body,
// DIRECTORY/tracker and DIRECTORY/site_calibration.
#include <cstdio>
#include <filesystem>

#include "core/file.h"
#include "estimate/site_calibration.h"
#include "tests/body/fake_shape_space.h"
#include "tests/fuzz/index_use.h"
#include "tests/perception/joints_model_builder.h"

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("write_seeds: expected a directory\n", stderr), 2;
  const std::string root = argv[1];
  const auto body = im2fit::body::fake_body_file();
  if (body.empty()) return std::fputs("write_seeds: no body file\n", stderr), 1;
  const auto tracker = im2fit::test::constant_model(0, 0, 0, 0).bytes();
  im2fit::SiteCalibration shop;
  shop.name = "Shop";
  shop.people = 20;
  shop.rows[0] = {1.01, -4, 6, 1.25};
  shop.row_people[0] = 20;
  shop.cameras = {{"Kinect", 1.01}};
  const auto site = shop.file();
  if (!site) return std::fputs("write_seeds: no site calibration\n", stderr), 1;
  for (const auto& [name, bytes] : {std::pair("index", im2fit::fuzz::small_index()),
                                    {"body", body},
                                    {"tracker", tracker},
                                    {"site_calibration", *site}}) {
    std::filesystem::create_directories(root + "/" + name);
    if (const auto s = im2fit::write_file_atomically(root + "/" + name + "/sound", bytes); !s)
      return std::fprintf(stderr, "write_seeds: %s\n", s.error().message.c_str()), 1;
  }
  return 0;
}
