// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/modifier_table.h"

namespace im2fit::body::makehuman {
namespace {

// Target = stem + "-" + ending; the stem alone where the ending is empty. A row with an empty `low` has one side.
struct Row {
  const char* name;
  const char* stem;  // upstream
  const char* low;
  const char* high;
  const char* npm_stem;  // nullptr: as upstream
  const char* npm_low;
  const char* npm_high;
};

constexpr Row same(const char* stem, const char* low = "decr", const char* high = "incr") {
  return {stem, stem, low, high, stem, low, high};
}
constexpr Row renamed(const char* stem, const char* npm_stem, const char* npm_low, const char* npm_high) {
  return {stem, stem, "decr", "incr", npm_stem, npm_low, npm_high};
}
constexpr Row less_more(const char* stem) {
  return renamed(stem, stem, "less", "more");
}
constexpr Row one_sided(const char* stem) {
  return {stem, stem, "", "", stem, "", ""};
}

constexpr Row kSingle[] = {
    same("torso/torso-scale-depth"),
    same("torso/torso-scale-horiz"),
    same("torso/torso-scale-vert"),
    {"torso/torso-trans-horiz", "torso/torso-trans", "in", "out", "torso/torso-trans-horiz", "in", "out"},
    {"torso/torso-trans-vert", "torso/torso-trans", "down", "up", "torso/torso-trans-vert", "down", "up"},
    {"torso/torso-trans-depth", "torso/torso-trans", "backward", "forward", "torso/torso-trans-depth", "backward",
     "forward"},
    less_more("torso/torso-vshape"),
    same("torso/torso-muscle-dorsi"),
    same("torso/torso-muscle-pectoral"),
    same("hip/hip-scale-depth"),
    same("hip/hip-scale-horiz"),
    same("hip/hip-scale-vert"),
    {"hip/hip-trans-horiz", "hip/hip-trans", "in", "out", "hip/hip-trans", "in", "out"},
    {"hip/hip-trans-vert", "hip/hip-trans", "down", "up", "hip/hip-trans", "down", "up"},
    {"hip/hip-trans-depth", "hip/hip-trans", "backward", "forward", "hip/hip-trans", "backward", "forward"},
    same("hip/hip-waist", "down", "up"),
    {"stomach/stomach-navel-depth", "stomach/stomach-navel", "in", "out", "stomach/stomach-navel", "in", "out"},
    {"stomach/stomach-navel-vert", "stomach/stomach-navel", "down", "up", "stomach/stomach-navel", "down", "up"},
    // The npm package holds the two tone targets under each other's name.
    {"stomach/stomach-tone", "stomach/stomach-tone", "decr", "incr", "stomach/stomach-tone", "incr", "decr"},
    same("stomach/stomach-pregnant"),
    same("buttocks/buttocks-volume"),
    same("pelvis/pelvis-tone"),
    {"pelvis/pelvis-bulge", "pelvis/bulge", "decr", "incr", "pelvis/bulge", "decr", "incr"},
    {"breast/breast-trans-vert", "breast/breast-trans", "down", "up", "breast/breast-trans-vert", "down", "up"},
    renamed("breast/breast-dist", "breast/breast-dist", "min", "max"),
    renamed("breast/breast-point", "breast/breast-point", "min", "max"),
    same("breast/breast-volume-vert", "down", "up"),
    less_more("neck/neck-double"),
    less_more("neck/neck-scale-depth"),
    less_more("neck/neck-scale-horiz"),
    less_more("neck/neck-scale-vert"),
    {"neck/neck-trans-horiz", "neck/neck-trans", "in", "out", "neck/neck-trans-horiz", "in", "out"},
    {"neck/neck-trans-vert", "neck/neck-trans", "down", "up", "neck/neck-trans-vert", "down", "up"},
    {"neck/neck-trans-depth", "neck/neck-trans", "backward", "forward", "neck/neck-trans-depth", "backward",
     "forward"},
    less_more("neck/neck-back-scale-depth"),
    {"head/head-fat", "head/head-fat", "decr", "incr", "head/head", "skinny", "fat"},
    same("head/head-angle", "in", "out"),
    one_sided("head/head-oval"),
    one_sided("head/head-round"),
    one_sided("head/head-rectangular"),
    one_sided("head/head-square"),
    one_sided("head/head-triangular"),
    one_sided("head/head-invertedtriangular"),
    one_sided("head/head-diamond"),
    less_more("head/head-scale-depth"),
    less_more("head/head-scale-horiz"),
    less_more("head/head-scale-vert"),
    {"head/head-trans-horiz", "head/head-trans", "in", "out", "head/head-trans", "in", "out"},
    {"head/head-trans-vert", "head/head-trans", "down", "up", "head/head-trans", "down", "up"},
    {"head/head-trans-depth", "head/head-trans", "backward", "forward", "head/head-trans", "backward", "forward"},
    less_more("head/head-back-scale-depth"),
    renamed("armslegs/upperlegs-height", "legs/legs-upperlegheight", "decr", "incr"),
    renamed("armslegs/lowerlegs-height", "legs/legs-lowerlegheight", "decr", "incr"),
    renamed("measure/measure-neck-circ", "measure/measure-neckcirc", "decrease", "increase"),
    renamed("measure/measure-neck-height", "measure/measure-neckheight", "decrease", "increase"),
    renamed("measure/measure-upperarm-circ", "measure/measure-upperarm", "decrease", "increase"),
    renamed("measure/measure-upperarm-length", "measure/measure-upperarmlenght", "decrease", "increase"),
    renamed("measure/measure-lowerarm-length", "measure/measure-lowerarmlenght", "decrease", "increase"),
    renamed("measure/measure-wrist-circ", "measure/measure-wrist", "decrease", "increase"),
    renamed("measure/measure-frontchest-dist", "measure/measure-frontchest", "decrease", "increase"),
    renamed("measure/measure-bust-circ", "measure/measure-bust", "decrease", "increase"),
    renamed("measure/measure-underbust-circ", "measure/measure-underbust", "decrease", "increase"),
    renamed("measure/measure-waist-circ", "measure/measure-waist", "decrease", "increase"),
    renamed("measure/measure-napetowaist-dist", "measure/measure-napetowaist", "decrease", "increase"),
    renamed("measure/measure-waisttohip-dist", "measure/measure-waisttohip", "decrease", "increase"),
    renamed("measure/measure-shoulder-dist", "measure/measure-shoulder", "decrease", "increase"),
    renamed("measure/measure-hips-circ", "measure/measure-hips", "decrease", "increase"),
    renamed("measure/measure-upperleg-height", "measure/measure-upperlegheight", "decrease", "increase"),
    renamed("measure/measure-thigh-circ", "measure/measure-thighcirc", "decrease", "increase"),
    renamed("measure/measure-lowerleg-height", "measure/measure-lowerlegheight", "decrease", "increase"),
    renamed("measure/measure-calf-circ", "measure/measure-calf", "decrease", "increase"),
    renamed("measure/measure-knee-circ", "measure/measure-kneecirc", "decrease", "increase"),
    renamed("measure/measure-ankle-circ", "measure/measure-ankle", "decrease", "increase"),
};

// Stems of pairs lack the side: "armslegs/" + "l-" or "r-" + stem.
constexpr Row kPaired[] = {
    same("hand-fingers-distance"),
    same("hand-fingers-diameter"),
    same("hand-fingers-length"),
    same("hand-scale"),
    same("hand-trans", "in", "out"),
    same("foot-scale"),
    same("foot-scale-depth"),
    same("foot-scale-horiz"),
    same("foot-scale-vert"),
    {"foot-trans-horiz", "foot-trans", "in", "out", "foot-trans", "in", "out"},
    {"foot-trans-depth", "foot-trans", "backward", "forward", "foot-trans", "backward", "forward"},
    same("lowerarm-scale-depth"),
    same("lowerarm-scale-horiz"),
    same("lowerarm-scale-vert"),
    {"lowerarm-fat", "lowerarm-fat", "decr", "incr", "lowerarm", "skinny", "fat"},
    same("lowerarm-muscle"),
    same("upperarm-scale-depth"),
    same("upperarm-scale-horiz"),
    same("upperarm-scale-vert"),
    {"upperarm-fat", "upperarm-fat", "decr", "incr", "upperarm", "skinny", "fat"},
    same("upperarm-shoulder-muscle"),
    same("upperarm-muscle"),
    {"leg-valgus", "leg-valgus", "decr", "incr", "leg-genu", "varun", "valgus"},
    same("lowerleg-scale-depth"),
    same("lowerleg-scale-horiz"),
    same("lowerleg-scale-vert"),
    {"lowerleg-fat", "lowerleg-fat", "decr", "incr", "lowerleg", "skinny", "fat"},
    same("lowerleg-muscle"),
    same("upperleg-scale-depth"),
    same("upperleg-scale-horiz"),
    same("upperleg-scale-vert"),
    {"upperleg-fat", "upperleg-fat", "decr", "incr", "upperleg", "skinny", "fat"},
    same("upperleg-muscle"),
};

std::string target(const std::string& prefix, const char* stem, const char* ending) {
  return prefix + stem + (*ending != '\0' ? "-" : "") + ending;
}

void add_sides(Modifier& m, const std::string& prefix, const Row& row) {
  if (*row.low != '\0')
    m.low.push_back({target(prefix, row.stem, row.low), target(prefix, row.npm_stem, row.npm_low)});
  m.high.push_back({target(prefix, row.stem, row.high), target(prefix, row.npm_stem, row.npm_high)});
}

}  // namespace

std::vector<Modifier> modifier_table() {
  std::vector<Modifier> table;
  for (const Row& row : kSingle) add_sides(table.emplace_back(Modifier{row.name, {}, {}}), "", row);
  const std::string group = "armslegs/";
  for (const Row& row : kPaired) {
    Modifier& both = table.emplace_back(Modifier{group + row.name, {}, {}});
    add_sides(both, group + "l-", row);
    add_sides(both, group + "r-", row);
    for (const char* side : {"l-", "r-"})
      add_sides(table.emplace_back(Modifier{group + side + row.name, {}, {}}), group + side, row);
  }
  // Mirror images of each other: the negative side leans left, the positive right.
  for (const char* name : {"asym/asymm-breast-1", "asym/asymm-trunk-1"}) {
    Modifier& m = table.emplace_back(Modifier{name, {}, {}});
    const std::string stem = name;
    m.low.push_back({stem + "-l", stem + "-l"});
    m.high.push_back({stem + "-r", stem + "-r"});
  }
  return table;
}

}  // namespace im2fit::body::makehuman
