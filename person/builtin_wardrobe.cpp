// SPDX-License-Identifier: Apache-2.0
#include <cassert>
#include <cstddef>
#include <iterator>
#include <type_traits>

#include "person/wardrobe.h"
#include "person/wardrobe_row.h"

namespace im2fit {
namespace {

#include "person/builtin_wardrobe.inc"

// Reads what WardrobeRow wrote. The rows are ours, and a test reads all of them.
class WardrobeReader {
 public:
  void number(float& value) { value = kNumbers[numbers_++]; }
  template <class T>
  void whole(T& value) {
    value = static_cast<T>(kWholes[wholes_++]);
  }
  void text(std::string& words) { words = kTexts[texts_++]; }
  template <class T, class Each>
  void list(std::vector<T>& all, Each each) {
    std::size_t count = 0;
    whole(count);
    all.resize(count);
    for (T& one : all) each(one);
  }
  bool at_end() const {
    return numbers_ == std::size(kNumbers) && wholes_ == std::size(kWholes) && texts_ == std::size(kTexts);
  }

 private:
  std::size_t numbers_ = 0, wholes_ = 0, texts_ = 0;
};

Wardrobe read_builtin() {
  Wardrobe wardrobe;
  WardrobeReader reader;
  put_wardrobe(reader, wardrobe);
  assert(reader.at_end());
  return wardrobe;
}

template <class T>
const T* named(const std::vector<T>& list, std::string_view id) {
  for (const T& one : list)
    if (one.id == id) return &one;
  return nullptr;
}

}  // namespace

const body::GarmentPattern* Wardrobe::garment(std::string_view id) const {
  return named(garments, id);
}
const body::Fabric* Wardrobe::fabric(std::string_view id) const {
  return named(fabrics, id);
}

const Wardrobe& builtin_wardrobe() {
  static const Wardrobe wardrobe = read_builtin();
  return wardrobe;
}

}  // namespace im2fit
