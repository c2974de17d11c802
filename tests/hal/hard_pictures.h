// SPDX-License-Identifier: Apache-2.0
// Pictures a depth codec may stumble over, among them those that OpenNI2's own encoder changes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "support.h"

namespace im2fit::hal {

inline Picture constant_picture(int width, int height, int value) {
  Picture picture(width, height);
  std::fill(picture.pixels.begin(), picture.pixels.end(), static_cast<std::uint16_t>(value));
  return picture;
}

// A slanted wall with a sensor's noise, steps and holes.
inline Picture noisy_picture(int width, int height, std::uint64_t seed) {
  Picture picture(width, height);
  Rng rng(seed);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const int wall_mm = 1500 + 2 * u + v + (u / 40 % 3 == 0 ? 400 : 0);
      picture.image().at(u, v) = static_cast<std::uint16_t>(
          rng.index(20) == 0 ? 0 : wall_mm + rng.index(9) - 4 + rng.index(3) * rng.index(30));
    }
  return picture;
}

// The last `run` pixels are equal, the one before them is `step` away, and the rest is noise.
inline Picture run_at_the_end(int width, int height, int run, int step) {
  Picture picture = random_picture(width, height, static_cast<std::uint64_t>(1000 * run + step), 5000);
  const int begin = std::max(0, static_cast<int>(picture.pixels.size()) - run);
  std::fill(picture.pixels.begin() + begin, picture.pixels.end(), std::uint16_t{2000});
  if (begin > 0) picture.pixels[static_cast<std::size_t>(begin) - 1] = static_cast<std::uint16_t>(2000 + step);
  return picture;
}

inline std::vector<Picture> hard_pictures(int width, int height) {
  std::vector<Picture> pictures;
  for (const int value : {0, 1, 32767, 32768, 65535}) pictures.push_back(constant_picture(width, height, value));
  // Runs of every length to beyond the longest a byte holds (30 pixels), at both places of a half byte.
  for (int run = 0; run <= 64; ++run)
    for (const int step : {1, 3000}) pictures.push_back(run_at_the_end(width, height, run, step));
  Picture extremes(width, height);
  Picture blocks(width, height);
  Picture climbing(width, height);  // every difference that is small, and some that are not
  Picture diverse(width, height);   // as many different values as the codec holds, where so many pixels are
  Rng rng(5);
  for (std::size_t i = 0; i < extremes.pixels.size(); ++i) {
    extremes.pixels[i] = i % 2 == 0 ? 0 : 65535;
    blocks.pixels[i] = rng.index(2) == 0 ? 0 : 65535;
    const int swing = static_cast<int>(i / 2 % 160);
    climbing.pixels[i] = static_cast<std::uint16_t>(30000 + (i % 2 == 0 ? 0 : swing - 80));
    diverse.pixels[i] = static_cast<std::uint16_t>(2 * ((i * 7919) % 32768) + 1);
  }
  for (auto* picture : {&extremes, &blocks, &climbing, &diverse}) pictures.push_back(std::move(*picture));
  for (std::uint64_t seed = 0; seed < 10; ++seed) pictures.push_back(random_picture(width, height, seed, 20'000));
  for (std::uint64_t seed = 0; seed < 45; ++seed) pictures.push_back(noisy_picture(width, height, seed));
  return pictures;
}

}  // namespace im2fit::hal
