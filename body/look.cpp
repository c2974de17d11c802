// SPDX-License-Identifier: Apache-2.0
#include "body/look.h"

#include <algorithm>
#include <cmath>

#include "body/model_data.h"
#include "core/container.h"

namespace im2fit::body {
namespace {

constexpr std::array<const char*, 2> kTextureSections = {"look_man", "look_woman"};
constexpr float kEyeRadiusMax = 2;  // of the lids' distance

std::uint32_t big_endian(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

// A PNG by its first chunk (PNG specification, 5.2 and 11.2.2): who shows it decodes it and says more.
bool is_square_png(std::span<const std::byte> bytes) {
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  if (bytes.size() < 33 || !std::equal(kSignature.begin(), kSignature.end(), bytes.begin(),
                                       [](std::uint8_t a, std::byte b) { return std::byte{a} == b; }))
    return false;
  const std::uint32_t width = big_endian(bytes, 16), height = big_endian(bytes, 20);
  return width == height && width >= kTextureSideMin && width <= kTextureSideMax;
}

bool sane(float v, float low, float high) {
  return v >= low && v <= high && (v == 0 || std::fabs(v) > 1e-18F);
}

TextureCoordinate coordinate(TexturePlace place) {
  return {static_cast<float>(place.u) / 65535.0F, static_cast<float>(place.v) / 65535.0F};
}

Vec3f mean_of(std::span<const std::int32_t> list, std::span<const Vec3f> vertices) {
  Vec3f sum;
  for (const std::int32_t v : list) sum = sum + vertices[static_cast<std::size_t>(v)];
  return sum * (1.0F / static_cast<float>(list.size()));
}

// Rings of an eyeball from the middle of the pupil outwards: sine and cosine of the angle at the eyeball's middle,
// and how far out in the texture. Lids cover what is more than 75 degrees aside.
struct Ring {
  float sine, cosine;
};
constexpr std::array<Ring, 6> kRings = {{{0.1736F, 0.9848F},    // 10 degrees
                                         {0.3420F, 0.9397F},    // 20
                                         {0.5000F, 0.8660F},    // 30
                                         {0.6691F, 0.7431F},    // 42
                                         {0.8290F, 0.5592F},    // 56
                                         {0.9659F, 0.2588F}}};  // 75
constexpr std::array<float, 6> kRingReach = {10.0F / 75, 20.0F / 75, 30.0F / 75, 42.0F / 75, 56.0F / 75, 1};
// A sixteenth of a turn each, cosine and sine.
constexpr std::array<std::array<float, 2>, 16> kRays = {{{1, 0},
                                                         {0.92387953F, 0.38268343F},
                                                         {0.70710678F, 0.70710678F},
                                                         {0.38268343F, 0.92387953F},
                                                         {0, 1},
                                                         {-0.38268343F, 0.92387953F},
                                                         {-0.70710678F, 0.70710678F},
                                                         {-0.92387953F, 0.38268343F},
                                                         {-1, 0},
                                                         {-0.92387953F, -0.38268343F},
                                                         {-0.70710678F, -0.70710678F},
                                                         {-0.38268343F, -0.92387953F},
                                                         {0, -1},
                                                         {0.38268343F, -0.92387953F},
                                                         {0.70710678F, -0.70710678F},
                                                         {0.92387953F, -0.38268343F}}};

void add_eye(const EyeRecord& eye, std::span<const Vec3f> vertices, LookPart& part) {
  const Vec3f middle = mean_of(eye.centre, vertices);
  const Vec3f before = mean_of(eye.front, vertices) - middle;
  float radius = 0;
  for (const std::int32_t v : eye.rim) radius += norm(vertices[static_cast<std::size_t>(v)] - middle);
  radius *= eye.radius / static_cast<float>(eye.rim.size());
  const Vec3f ahead = normalized(before);
  const Vec3f side = normalized(cross({0, 1, 0}, ahead)), up = cross(ahead, side);
  SkinRecord skin;
  skin.segment[0] = static_cast<std::uint8_t>(Segment::head);
  skin.weight[0] = 1;
  const auto add = [&](Vec3f direction, float right, float above) {
    part.positions.push_back(middle + direction * radius);
    part.normals.push_back(direction);
    part.texture.push_back({eye.texture_u + right * eye.texture_r, eye.texture_v - above * eye.texture_r});
    part.skin.push_back(skin);
  };
  const auto first = static_cast<std::int32_t>(part.positions.size());
  const auto rays = static_cast<std::int32_t>(kRays.size());
  add(ahead, 0, 0);
  for (std::size_t r = 0; r < kRings.size(); ++r)
    for (const auto& [cosine, sine] : kRays)
      add(ahead * kRings[r].cosine + (side * cosine + up * sine) * kRings[r].sine, cosine * kRingReach[r],
          sine * kRingReach[r]);
  for (std::int32_t i = 0; i < rays; ++i) {
    const std::int32_t next = (i + 1) % rays;
    for (std::int32_t r = 1; r < static_cast<std::int32_t>(kRings.size()); ++r) {
      const std::int32_t in = first + 1 + (r - 1) * rays, out = in + rays;
      part.quads.push_back({in + i, out + i, out + next, in + next});
    }
    // The middle: two sixteenths a quad.
    if (i % 2 == 0) part.quads.push_back({first, first + 1 + i, first + 1 + next, first + 1 + (i + 2) % rays});
  }
}

// Each vertex over an ear goes to the mean of those it has an edge with, again and again: a file's offsets, which are
// of one ear, are the beginning, and the ears of others need this many passes.
void spread_over_ears(std::span<const HairRecord> hair, std::span<const std::array<std::int32_t, 4>> quads,
                      std::vector<Vec3f>& at) {
  constexpr int kPasses = 400;
  std::vector<std::array<std::size_t, 2>> edges;  // a vertex over an ear, its neighbour
  for (const auto& q : quads)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto a = static_cast<std::size_t>(q[k]), b = static_cast<std::size_t>(q[(k + 1) % 4]);
      if ((hair[a].above & kHairOverEar) != 0) edges.push_back({a, b});
      if ((hair[b].above & kHairOverEar) != 0) edges.push_back({b, a});
    }
  std::vector<Vec3f> sum(at.size());
  std::vector<float> count(at.size());
  for (const auto& [a, b] : edges) count[a] += 1;
  for (int pass = 0; pass < kPasses; ++pass) {
    for (const auto& [a, b] : edges) sum[a] = sum[a] + at[b];
    for (std::size_t v = 0; v < at.size(); ++v) {
      if (count[v] == 0) continue;
      at[v] = sum[v] * (1 / count[v]);
      sum[v] = {};
    }
  }
}

Error bad(const std::string& what, const char* section, const std::string& why) {
  return {ErrorCode::corrupt, what + ": section '" + section + "': " + why};
}

}  // namespace

Result<Look> read_look(const ContainerReader& reader, std::size_t vertex_count, std::size_t quad_count,
                       const std::string& what) {
  Look look;
  if (!reader.entries().contains("look_corners")) return look;
  if (const auto status = reader.take("look_corners", look.corners, quad_count); !status) return status.error();
  for (std::size_t i = 0; i < kTextureSections.size(); ++i) {
    const auto section = reader.section(kTextureSections[i]);
    if (!section) return section.error();
    if (!is_square_png(*section))
      return bad(what, kTextureSections[i],
                 "not a square PNG of " + std::to_string(kTextureSideMin) + " to " + std::to_string(kTextureSideMax) +
                     " pixels a side");
    look.texture[i] = *section;
  }
  if (const auto status = reader.take("look_eyes", look.eyes, 2); !status) return status.error();
  for (const EyeRecord& eye : look.eyes) {
    for (const std::span<const std::int32_t> list :
         {std::span<const std::int32_t>(eye.centre), {eye.front}, {eye.rim}})
      for (const std::int32_t v : list)
        if (v < 0 || static_cast<std::size_t>(v) >= vertex_count)
          return bad(what, "look_eyes", "vertex out of range");
    if (!sane(eye.radius, 0, kEyeRadiusMax) || !sane(eye.texture_u, 0, 1) || !sane(eye.texture_v, 0, 1) ||
        !sane(eye.texture_r, 0, 1))
      return bad(what, "look_eyes", "a radius or a place in the texture is out of range");
  }
  if (const auto status = reader.take("look_hair", look.hair); !status) return status.error();
  for (std::size_t i = 0; i < look.hair.size(); ++i)
    if (look.hair[i].vertex >= kBodyVertexCount || (i > 0 && look.hair[i].vertex <= look.hair[i - 1].vertex))
      return bad(what, "look_hair", "vertices do not ascend, or are not the body's");
  return look;
}

Result<std::vector<std::byte>> shape_only(std::span<const std::byte> pack, const std::string& what) {
  const auto reader = ContainerReader::parse(pack, kBodyMagic, kBodyVersion, what);
  if (!reader) return reader.error();
  std::vector<std::pair<std::uint64_t, std::string>> order;
  for (const auto& [name, entry] : reader->entries())
    if (!name.starts_with("look_") && !name.starts_with("start_")) order.emplace_back(entry.offset, name);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  ContainerWriter writer(kBodyMagic, kBodyVersion);
  for (const auto& [offset, name] : order) {
    const auto section = *reader->section(name);
    writer.add(name, {section.begin(), section.end()});
  }
  return writer.finish();
}

LookOf look_of(float gender) {
  return gender > 0.5F ? LookOf::man : LookOf::woman;
}

SkinPart skin_part(const BodyModel& model, std::span<const Vec3f> vertices) {
  const BodyModel::Data& d = model.data();
  const auto count = static_cast<std::size_t>(kBodyVertexCount);
  SkinPart part;
  part.positions.assign(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(count));
  part.normals = vertex_normals(part.positions, d.quads);
  part.skin.assign(d.skin.begin(), d.skin.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t v = 0; v < count; ++v) part.body_vertex.push_back(static_cast<std::int32_t>(v));
  part.quads.assign(d.quads.begin(), d.quads.end());
  if (d.look.empty()) return part;
  // Of each vertex the copies that there are, each with the next: the vertex itself has the coordinate first met.
  constexpr std::int32_t kNone = -1, kUnmet = -2;
  std::vector<std::int32_t> next(count, kUnmet);
  std::vector<TexturePlace> places(count);
  for (std::size_t q = 0; q < part.quads.size(); ++q)
    for (std::size_t k = 0; k < 4; ++k) {
      std::int32_t& corner = part.quads[q][k];
      const TexturePlace place = d.look.corners[q][k];
      auto v = static_cast<std::size_t>(corner);
      if (next[v] == kUnmet) {
        next[v] = kNone;
        places[v] = place;
        continue;
      }
      while ((places[v].u != place.u || places[v].v != place.v) && next[v] != kNone)
        v = static_cast<std::size_t>(next[v]);
      if (places[v].u != place.u || places[v].v != place.v) {
        const auto copy = static_cast<std::int32_t>(places.size());
        next[v] = copy;
        next.push_back(kNone);
        places.push_back(place);
        part.body_vertex.push_back(corner);
        v = static_cast<std::size_t>(copy);
      }
      corner = static_cast<std::int32_t>(v);
    }
  for (std::size_t v = count; v < places.size(); ++v) {
    const auto of = static_cast<std::size_t>(part.body_vertex[v]);
    part.positions.push_back(part.positions[of]);
    part.normals.push_back(part.normals[of]);
    part.skin.push_back(part.skin[of]);
  }
  for (const TexturePlace place : places) part.texture.push_back(coordinate(place));
  return part;
}

LookPart eyes_part(const BodyModel& model, std::span<const Vec3f> vertices) {
  LookPart part;
  for (const EyeRecord& eye : model.data().look.eyes) add_eye(eye, vertices, part);
  return part;
}

LookPart hair_part(const BodyModel& model, std::span<const Vec3f> vertices, const Mat3f& head, LookOf whose) {
  const BodyModel::Data& d = model.data();
  const auto style = static_cast<std::size_t>(whose);
  LookPart part;
  if (d.look.empty()) return part;
  constexpr std::int32_t kNoHair = -1;
  std::vector<std::int32_t> record_of(static_cast<std::size_t>(kBodyVertexCount), kNoHair);
  for (std::size_t i = 0; i < d.look.hair.size(); ++i)
    record_of[d.look.hair[i].vertex] = static_cast<std::int32_t>(i);
  // Numbered as the quads come to them. A corner in another place of the texture is another vertex.
  std::vector<std::int32_t> first(d.look.hair.size(), kNoHair), next;
  std::vector<TexturePlace> places;
  std::vector<std::int32_t> records;
  const auto number = [&](std::int32_t record, TexturePlace place) {
    std::int32_t* link = &first[static_cast<std::size_t>(record)];
    while (*link != kNoHair) {
      const TexturePlace known = places[static_cast<std::size_t>(*link)];
      if (known.u == place.u && known.v == place.v) return *link;
      link = &next[static_cast<std::size_t>(*link)];
    }
    const auto fresh = static_cast<std::int32_t>(places.size());
    *link = fresh;
    places.push_back(place);
    records.push_back(record);
    next.push_back(kNoHair);
    return fresh;
  };
  std::vector<std::array<std::int32_t, 4>> by_record;
  for (std::size_t q = 0; q < d.quads.size(); ++q) {
    std::array<std::int32_t, 4> record{};
    bool whole = true, above = false;
    for (std::size_t k = 0; k < 4; ++k) {
      record[k] = record_of[static_cast<std::size_t>(d.quads[q][k])];
      whole = whole && record[k] != kNoHair;
      above = above || (whole && (d.look.hair[static_cast<std::size_t>(record[k])].above >> style & 1U) != 0);
    }
    if (!whole || !above) continue;
    std::array<std::int32_t, 4> quad{};
    for (std::size_t k = 0; k < 4; ++k) quad[k] = number(record[k], d.look.corners[q][k]);
    part.quads.push_back(quad);
    by_record.push_back(record);
  }
  std::vector<Vec3f> at(d.look.hair.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    const HairRecord& hair = d.look.hair[i];
    const auto& o = hair.offset[style];
    const Vec3f offset = {static_cast<float>(o[0]), static_cast<float>(o[1]), static_cast<float>(o[2])};
    at[i] = vertices[hair.vertex] + head * (offset * kHairUnitMm);
  }
  if (whose == LookOf::woman) spread_over_ears(d.look.hair, by_record, at);
  const std::vector<Vec3f> normals = vertex_normals(at, by_record);  // the same on both sides of a seam
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto record = static_cast<std::size_t>(records[i]);
    part.positions.push_back(at[record]);
    part.normals.push_back(normals[record]);
    part.texture.push_back(coordinate(places[i]));
    part.skin.push_back(d.skin[d.look.hair[record].vertex]);
  }
  return part;
}

std::vector<Vec3f> vertex_normals(std::span<const Vec3f> vertices,
                                  std::span<const std::array<std::int32_t, 4>> quads) {
  std::vector<Vec3f> normals(vertices.size());
  for (const auto& q : quads) {
    const auto v = [&](std::size_t i) { return vertices[static_cast<std::size_t>(q[i])]; };
    const Vec3f n = cross(v(2) - v(0), v(3) - v(1));  // the diagonals: twice the quad's area
    for (const std::int32_t i : q) normals[static_cast<std::size_t>(i)] = normals[static_cast<std::size_t>(i)] + n;
  }
  for (Vec3f& n : normals) n = dot(n, n) > 0 ? normalized(n) : Vec3f{0, 1, 0};
  return normals;
}

}  // namespace im2fit::body
