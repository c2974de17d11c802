// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/flat_places.h"

#include <algorithm>

namespace im2fit::body {

void FlatPlaces::add(Flat place, std::size_t vertex) {
  if (places_.size() % kBlock == 0) boxes_.push_back({place, place});
  Box& box = boxes_.back();
  box.low = {std::min(box.low.x, place.x), std::min(box.low.y, place.y)};
  box.high = {std::max(box.high.x, place.x), std::max(box.high.y, place.y)};
  places_.push_back(place);
  vertices_.push_back(static_cast<std::int32_t>(vertex));
}

FlatPlaces::Nearest FlatPlaces::nearest(Flat to) {
  constexpr float kRounding = 0.999F;  // a box is not passed by for the last bit
  if (places_.empty()) return {};
  const auto squared_to = [&](Flat place) {
    const float dx = to.x - place.x, dy = to.y - place.y;
    return dx * dx + dy * dy;
  };
  std::size_t found = last_;
  float best = squared_to(places_[found]);
  for (std::size_t b = 0; b < boxes_.size(); ++b) {
    const Box& box = boxes_[b];
    const float x = std::max(std::max(box.low.x - to.x, to.x - box.high.x), 0.0F);
    const float y = std::max(std::max(box.low.y - to.y, to.y - box.high.y), 0.0F);
    if ((x * x + y * y) * kRounding > best) continue;
    const std::size_t end = std::min(places_.size(), (b + 1) * kBlock);
    for (std::size_t i = b * kBlock; i < end; ++i) {
      const float squared = squared_to(places_[i]);
      if (squared > best || (squared == best && i >= found)) continue;
      best = squared;
      found = i;
    }
  }
  last_ = found;
  return {best, vertices_[found]};
}

}  // namespace im2fit::body
