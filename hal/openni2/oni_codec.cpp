// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_codec.h"

#include <algorithm>
#include <cstdlib>

namespace im2fit::hal {
namespace {

constexpr int kNibbleMax = 6;     // differences a half byte holds
constexpr int kByteMax = 63;      // and a byte behind an escape
constexpr int kRunPairsMax = 15;  // pairs of equal pixels in a byte
constexpr int kNoPartner = 0xD;   // half bytes that do not code a difference
constexpr int kEscaped = 0xF;

void put(std::vector<std::byte>& out, int value) {
  out.push_back(static_cast<std::byte>(value));
}

void put16(std::vector<std::byte>& out, std::size_t value) {
  put(out, static_cast<int>(value & 0xFF));
  put(out, static_cast<int>(value >> 8));
}

void put_escaped(std::vector<std::byte>& out, int before, int place) {
  const int difference = place - before;
  if (std::abs(difference) <= kByteMax) {
    put(out, 192 - difference);
  } else {
    put(out, place >> 8);
    put(out, place & 0xFF);
  }
}

bool fits_nibble(int difference) {
  return std::abs(difference) <= kNibbleMax;
}

// Pairs equal to the pixel before, held back until the run ends: nothing may be written before the run is.
class Run {
 public:
  explicit Run(std::vector<std::byte>& out) : out_(out) {}
  void add_pair() {
    if (++pairs_ == kRunPairsMax) end();
  }
  void end() {
    if (pairs_ > 0) put(out_, 0xE0 + pairs_);
    pairs_ = 0;
  }

 private:
  std::vector<std::byte>& out_;
  int pairs_ = 0;
};

// The pixels' places one after the other, whatever the picture's stride.
class Places {
 public:
  Places(DepthView picture, const std::vector<std::uint16_t>& places)
      : picture_(picture), places_(places), row_(picture.row(0)) {}
  bool done() const { return v_ == picture_.height; }
  int take() {
    const int place = places_[row_[u_]];
    if (++u_ == picture_.width) {
      u_ = 0;
      if (++v_ < picture_.height) row_ = picture_.row(v_);
    }
    return place;
  }

 private:
  DepthView picture_;
  const std::vector<std::uint16_t>& places_;
  const std::uint16_t* row_;
  int u_ = 0;
  int v_ = 0;
};

}  // namespace

bool OniEncoder::write_table(DepthView picture, std::vector<std::byte>& out) {
  std::fill(places_.begin(), places_.end(), std::uint16_t{0});
  for (int v = 0; v < picture.height; ++v) {
    const std::uint16_t* row = picture.row(v);
    for (int u = 0; u < picture.width; ++u) places_[row[u]] = 1;
  }
  const auto count = static_cast<std::size_t>(std::count(places_.begin(), places_.end(), std::uint16_t{1}));
  if (count > kValuesMax) return false;
  put16(out, count);
  std::uint16_t place = 0;
  for (std::size_t value = 0; value < places_.size(); ++value) {
    if (places_[value] == 0) continue;
    put16(out, value);
    places_[value] = place++;
  }
  return true;
}

bool OniEncoder::encode(DepthView picture, std::vector<std::byte>& out) {
  if (picture.width < 1 || picture.height < 1 || !write_table(picture, out)) return false;
  Places places(picture, places_);
  Run run(out);
  int before = places.take();
  put16(out, static_cast<std::size_t>(before));
  while (!places.done()) {
    const int first = places.take();
    if (!fits_nibble(first - before)) {
      run.end();
      put(out, 0xFF);
      put_escaped(out, before, first);
      before = first;
      continue;
    }
    const int high = (kNibbleMax - (first - before)) << 4;
    if (places.done()) {
      run.end();
      put(out, high | kNoPartner);
      break;
    }
    const int second = places.take();
    if (!fits_nibble(second - first)) {
      run.end();
      put(out, high | kEscaped);
      put_escaped(out, first, second);
    } else if (first == before && second == first) {
      run.add_pair();
    } else {
      run.end();
      put(out, high | (kNibbleMax - (second - first)));
    }
    before = second;
  }
  run.end();
  return true;
}

}  // namespace im2fit::hal
