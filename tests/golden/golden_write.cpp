// SPDX-License-Identifier: Apache-2.0
// golden_tests --write [DIRECTORY]: writes this build's values as the expected ones; scripts/golden calls it. Without
// --write: the tests.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "core/file.h"
#include "tests/body/body_pack.h"
#include "tests/golden/golden_run.h"

namespace im2fit::golden {
namespace {

int fail(const Error& error) {
  std::fprintf(stderr, "golden_tests --write: %s\n", error.message.c_str());
  return 1;
}

int write(const std::string& directory) {
  const auto data = Data::load(directory);
  if (!data) return fail(data.error());
  const auto stages = golden::stages(*data);
  if (!stages) return fail(stages.error());
  const auto result = golden::result(*data, directory, true);
  if (!result) return fail(result.error());
  if (const auto written = write_file_atomically(directory + "/stages.txt", *stages); !written)
    return fail(written.error());
  if (const auto written = write_file_atomically(directory + "/result.json", *result); !written)
    return fail(written.error());
  const auto bodies = golden::bodies(body::body_pack_path());
  if (!bodies) return fail(bodies.error());
  if (const auto written = write_file_atomically(directory + "/bodies.txt", *bodies); !written)
    return fail(written.error());
  return 0;
}

}  // namespace
}  // namespace im2fit::golden

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--write")
    return im2fit::golden::write(argc > 2 ? argv[2] : IM2FIT_GOLDEN_DATA);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
