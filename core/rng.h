// SPDX-License-Identifier: Apache-2.0
// Deterministic random numbers: the same seed gives the same bits on every machine and thread count.
// Generator: SplitMix64 (Steele, Lea, Flood 2014), which may be seeded with any value, also small consecutive ones.
#pragma once

#include <cmath>
#include <cstdint>

namespace im2fit {

class Rng {
 public:
  explicit Rng(std::uint64_t seed) : state_(seed) {}

  // An independent stream for item `index` of the purpose `stream`, whatever order items are made in.
  static Rng for_item(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
    Rng rng(seed ^ (stream * 0x9E3779B97F4A7C15ULL));
    rng.state_ = rng.next() ^ (index * 0xD1342543DE82EF95ULL);
    rng.next();
    return rng;
  }

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  // [0, 1)
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  // 0 .. count-1; count > 0
  int index(int count) { return static_cast<int>((next() >> 33) % static_cast<std::uint64_t>(count)); }
  // Standard normal (Box-Muller; the second value is dropped so that state is one word).
  double normal() {
    const double u = 1.0 - uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * uniform());
  }
  double normal(double mean, double sd) { return mean + sd * normal(); }
  // About normal, four times cheaper: sum of four 16-bit uniforms (variance-matched, tails end at 3.46 sd).
  float fast_normal() {
    const std::uint64_t r = next();
    const int sum = static_cast<int>(r & 0xFFFF) + static_cast<int>((r >> 16) & 0xFFFF) +
                    static_cast<int>((r >> 32) & 0xFFFF) + static_cast<int>(r >> 48);
    return (static_cast<float>(sum) - 131070.0F) * (1.7320508F / 65536.0F);
  }

 private:
  std::uint64_t state_;
};

}  // namespace im2fit
