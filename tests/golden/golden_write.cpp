// SPDX-License-Identifier: Apache-2.0
// golden_write [DIRECTORY]: writes what this build finds as what is expected; scripts/golden calls it.
#include <cstdio>

#include "core/file.h"
#include "tests/body/body_pack.h"
#include "tests/golden/golden_run.h"

namespace {

int fail(const im2fit::Error& error) {
  std::fprintf(stderr, "golden_write: %s\n", error.message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace im2fit;
  const std::string directory = argc > 1 ? argv[1] : IM2FIT_GOLDEN_DATA;
  const auto data = golden::Data::load(directory);
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
