// SPDX-License-Identifier: Apache-2.0
// im2fit-clothes-beside BODY.i2b [PEOPLE [PICTURES.pgm]]
// How far off the skin clothes are as a camera in front sees them: the tailor's, which teach, beside draped garments,
// which must not. Parallel projection of held-out people, pixels of 4 mm.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "core/joints.h"
#include "lab/garment/draped_clothes.h"
#include "lab/population/scene_person.h"

namespace {

using namespace im2fit;
using namespace im2fit::lab;

constexpr std::uint64_t kSeed = 0x6362;
constexpr float kPixelMm = 4;
constexpr int kWidth = 400, kHeight = 560;  // 1.6 m by 2.24 m
constexpr float kNothing = -1e9F;

// What is nearest to the camera, y up from the floor, x to the picture's right from the hips.
struct Front {
  std::vector<float> z = std::vector<float>(std::size_t{kWidth} * kHeight, kNothing);
  static int column(float x) { return static_cast<int>(std::floor(x / kPixelMm)) + kWidth / 2; }
  static int row(float y) { return static_cast<int>(std::floor(y / kPixelMm)); }
  float at(int c, int r) const {
    return c < 0 || c >= kWidth || r < 0 || r >= kHeight ? kNothing : z[static_cast<std::size_t>(r * kWidth + c)];
  }
  bool seen(float x, float y) const { return at(column(x), row(y)) > kNothing; }
  void draw(std::span<const Vec3f> v, std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles) {
      const Vec3f a = v[static_cast<std::size_t>(t[0])], b = v[static_cast<std::size_t>(t[1])],
                  c = v[static_cast<std::size_t>(t[2])];
      const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
      if (area == 0) continue;
      const int left = std::max(0, column(std::min({a.x, b.x, c.x}))),
                right = std::min(kWidth - 1, column(std::max({a.x, b.x, c.x})));
      const int low = std::max(0, row(std::min({a.y, b.y, c.y}))),
                high = std::min(kHeight - 1, row(std::max({a.y, b.y, c.y})));
      for (int r = low; r <= high; ++r)
        for (int k = left; k <= right; ++k) {
          const float x = (static_cast<float>(k - kWidth / 2) + 0.5F) * kPixelMm,
                      y = (static_cast<float>(r) + 0.5F) * kPixelMm;
          const float u = ((b.x - x) * (c.y - y) - (c.x - x) * (b.y - y)) / area;
          const float w = ((c.x - x) * (a.y - y) - (a.x - x) * (c.y - y)) / area;
          if (u < 0 || w < 0 || u + w > 1) continue;
          float& nearest = z[static_cast<std::size_t>(r * kWidth + k)];
          nearest = std::max(nearest, u * a.z + w * b.z + (1 - u - w) * c.z);
        }
    }
  }
  // How far the silhouette reaches from a place inside it along a direction in the picture.
  float reach(float x, float y, float dx, float dy) const {
    float far = 0;
    while (far < 400 && seen(x + dx * far, y + dy * far)) far += 1;
    return far;
  }
  // Median of the nearest surface about a place.
  float depth(float x, float y, float half_width) const {
    std::vector<float> found;
    for (int r = row(y - 10); r <= row(y + 10); ++r)
      for (int c = column(x - half_width); c <= column(x + half_width); ++c)
        if (at(c, r) > kNothing) found.push_back(at(c, r));
    if (found.empty()) return kNothing;
    std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2), found.end());
    return found[found.size() / 2];
  }
  // Lowest place between the legs, within 40 mm of the middle, that is not empty from there up.
  float crotch(float x, float y) const {
    float highest = -1e9F;
    for (float at = x - 40; at <= x + 40; at += 4) {
      float down = y;
      while (down > 0 && seen(at, down)) down -= 2;
      highest = std::max(highest, down);
    }
    return highest;
  }
};

struct Seen {
  Front front;
  JointSet joints;
};

Seen look(ScenePerson& person, const Subject& subject, const std::vector<Vec3f>& rest, const PersonPlan& plan,
          std::uint64_t seed, Tailor& tailor) {
  person.stage(subject, rest, plan, seed, 0, &tailor);
  person.choose_frame(0);
  Seen seen;
  seen.joints = person.joints();
  seen.front.draw(person.surface(), person.closed_triangles());
  seen.front.draw(person.surface(), person.open_triangles());
  return seen;
}

constexpr std::array kMeasures = {"ankle breadth (0.85 of shank)",
                                  "shin breadth (half)",
                                  "knee breadth",
                                  "thigh breadth (0.6, outer half)",
                                  "shin depth",
                                  "knee depth",
                                  "mid-thigh depth",
                                  "crotch lower by",
                                  "hip breadth",
                                  "waist breadth",
                                  "trunk at 0.6, arms if they touch",
                                  "crotch depth",
                                  "belly depth",
                                  "waist depth",
                                  "below chest depth",
                                  "chest depth",
                                  "upper arm half, outer",
                                  "upper arm 0.75, outer",
                                  "forearm half, breadth",
                                  "arm 0.25, outer"};
using Values = std::array<float, kMeasures.size()>;

Values values_of(const Seen& s, float stature_mm) {
  Values v{};
  const auto j = [&](Joint which) { return s.joints[which]; };
  const auto& f = s.front;
  const Vec3f hip = j(Joint::LH), knee = j(Joint::LK), foot = j(Joint::LF);
  // As high as the ankle on the skin and the shoe alike.
  const auto leg = [&](float along) {
    return along < 1 ? hip + (knee - hip) * along : knee + (foot - knee) * (along - 1);
  };
  const auto breadth = [&](Vec3f p) { return f.reach(p.x, p.y, 1, 0) + f.reach(p.x, p.y, -1, 0); };
  v[0] = breadth(leg(1.8F));
  v[1] = breadth(leg(1.5F));
  v[2] = breadth(leg(1.0F));
  const float side = knee.x > j(Joint::RK).x ? 1.0F : -1.0F;
  v[3] = f.reach(leg(0.6F).x, leg(0.6F).y, side, 0);
  v[4] = f.depth(leg(1.5F).x, leg(1.5F).y, 20);
  v[5] = f.depth(leg(1.0F).x, leg(1.0F).y, 20);
  v[6] = f.depth(leg(0.6F).x, leg(0.6F).y, 20);
  const Vec3f hips = (hip + j(Joint::RH)) * 0.5F, shoulders = (j(Joint::LS) + j(Joint::RS)) * 0.5F;
  v[7] = -f.crotch(hips.x, hips.y);
  const auto trunk = [&](float up) { return hips + (shoulders - hips) * up; };
  v[8] = breadth(hips);
  v[9] = breadth(trunk(0.4F));
  v[10] = breadth(trunk(0.6F));
  v[11] = f.depth(hips.x, hips.y - 0.03F * stature_mm, 40);
  v[12] = f.depth(trunk(0.2F).x, trunk(0.2F).y, 40);
  v[13] = f.depth(trunk(0.4F).x, trunk(0.4F).y, 40);
  v[14] = f.depth(trunk(0.58F).x, trunk(0.58F).y, 40);
  v[15] = f.depth(trunk(0.74F).x, trunk(0.74F).y, 60);
  const Vec3f shoulder = j(Joint::LS), elbow = j(Joint::LE), hand = j(Joint::LA);
  const auto across = [](Vec3f along) {
    const float n = std::hypot(along.x, along.y);
    return std::array{-along.y / n, along.x / n};
  };
  auto d = across(elbow - shoulder);
  if (d[0] * side < 0) d = {-d[0], -d[1]};
  const auto arm = [&](float along) { return shoulder + (elbow - shoulder) * along; };
  v[16] = f.reach(arm(0.5F).x, arm(0.5F).y, d[0], d[1]);
  v[17] = f.reach(arm(0.75F).x, arm(0.75F).y, d[0], d[1]);
  const Vec3f forearm = elbow + (hand - elbow) * 0.45F;
  d = across(hand - elbow);
  v[18] = f.reach(forearm.x, forearm.y, d[0], d[1]) + f.reach(forearm.x, forearm.y, -d[0], -d[1]);
  d = across(elbow - shoulder);
  if (d[0] * side < 0) d = {-d[0], -d[1]};
  v[19] = f.reach(arm(0.25F).x, arm(0.25F).y, d[0], d[1]);
  return v;
}

struct Kind {
  const char* name;
  Clothing clothing;
  std::array<std::vector<float>, kMeasures.size()> off;
};

int run(int argc, char** argv) {
  const auto model = body::BodyModel::load(argv[1]);
  if (!model) {
    std::fprintf(stderr, "im2fit-clothes-beside: %s\n", model.error().message.c_str());
    return 1;
  }
  const int people = argc > 2 ? std::atoi(argv[2]) : 40;
  if (people < 1) {
    std::fprintf(stderr, "im2fit-clothes-beside: PEOPLE is \"%s\", expected a number from 1 on\n", argv[2]);
    return 2;
  }
  std::vector<Kind> kinds = {{"normal", Clothing::normal, {}},
                             {"loose", Clothing::loose, {}},
                             {"hanging", Clothing::hanging, {}},
                             {"garments", Clothing::garments, {}}};
  constexpr int kDrawn = 6, kMoreOutfits = 2;
  std::vector<Front> drawn;
  Tailor tailor(*model);
  ScenePerson person(*model);
  for (int i = 0; i < people; ++i) {
    std::vector<Vec3f> rest;
    const Subject subject = draw_subject(*model, Family::held_out, kSeed, static_cast<std::uint64_t>(i), rest);
    const float stature_mm = subject.truth[measurement_index(Measurement::stature)];
    PersonPlan plan;
    plan.pose = StandingPose::relaxed;
    plan.yaw_deg = 0.0F;
    plan.sway = false;
    const std::uint64_t seed = kSeed + 7919 * static_cast<std::uint64_t>(i);
    const Seen naked = look(person, subject, rest, plan, seed, tailor);
    const Values skin = values_of(naked, stature_mm);
    for (Kind& kind : kinds) {
      const bool draped = kind.clothing == Clothing::garments;
      for (int outfit = 0; outfit < (draped ? 1 : kMoreOutfits); ++outfit) {
        plan.clothing = kind.clothing;
        plan.outfit_seed = seed + static_cast<std::uint64_t>(outfit) + 1;
        Rng rng = Rng::for_item(kSeed, 1, static_cast<std::uint64_t>(i));
        plan.dresser = draped ? dresser_of(*model, subject.woman, draw_garments(rng)) : Dresser{};
        Seen worn = look(person, subject, rest, plan, seed, tailor);
        Values cloth = values_of(worn, stature_mm);
        const float sole = worn.joints[Joint::LH].y - naked.joints[Joint::LH].y;
        cloth[7] += sole;
        for (std::size_t m = 0; m < kMeasures.size(); ++m) kind.off[m].push_back(cloth[m] - skin[m]);
        if (i < kDrawn && outfit == 0) drawn.push_back(std::move(worn.front));
      }
    }
  }
  std::printf("%-32s", "off the skin, mm: mean (SD) 5..95");
  for (const Kind& k : kinds) std::printf(" %24s", k.name);
  std::printf("\n");
  for (std::size_t m = 0; m < kMeasures.size(); ++m) {
    std::printf("%-32s", kMeasures[m]);
    for (Kind& k : kinds) {
      auto& off = k.off[m];
      std::sort(off.begin(), off.end());
      double sum = 0, square = 0;
      for (const float o : off) sum += static_cast<double>(o);
      const double count = static_cast<double>(off.size()), mean = sum / count;
      for (const float o : off) square += (static_cast<double>(o) - mean) * (static_cast<double>(o) - mean);
      const auto share = [&](double s) {
        return static_cast<double>(off[static_cast<std::size_t>(s * (count - 1))]);
      };
      std::printf("   %5.0f (%3.0f) %4.0f ..%4.0f", mean, std::sqrt(square / count), share(0.05), share(0.95));
    }
    std::printf("\n");
  }
  if (argc > 3) {
    const int across = static_cast<int>(kinds.size()), rows = static_cast<int>(drawn.size()) / across;
    std::FILE* out = std::fopen(argv[3], "wb");
    if (out == nullptr) {
      std::fprintf(stderr, "im2fit-clothes-beside: cannot write %s\n", argv[3]);
      return 1;
    }
    std::fprintf(out, "P5\n%d %d\n255\n", across * kWidth, rows * kHeight);
    for (int y = 0; y < rows * kHeight; ++y)
      for (int x = 0; x < across * kWidth; ++x) {
        const Front& f = drawn[static_cast<std::size_t>(y / kHeight * across + x / kWidth)];
        const int c = x % kWidth, r = kHeight - 1 - y % kHeight;
        const float here = f.at(c, r), beside = f.at(c + 1, r), above = f.at(c, r + 1);
        float light = 255;
        if (here > kNothing) {
          const float sx = beside > kNothing ? (beside - here) / kPixelMm : 0;
          const float sy = above > kNothing ? (above - here) / kPixelMm : 0;
          light = 30 + 190 * std::max(0.0F, (1 + 0.5F * sx - 0.3F * sy) / std::sqrt(1 + sx * sx + sy * sy)) / 1.2F;
        }
        std::fputc(static_cast<int>(std::clamp(light, 0.0F, 255.0F)), out);
      }
    std::fclose(out);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-clothes-beside BODY.i2b [PEOPLE [PICTURES.pgm]]\n");
    return 2;
  }
  return run(argc, argv);
}
