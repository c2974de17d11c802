// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0 (Khronos specification, sections 3.6 buffers, 3.7 meshes and skins, 4.4 GLB layout).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "body/export/export.h"
#include "body/export/figure.h"
#include "body/export/motion.h"
#include "body/model_data.h"
#include "core/file.h"

namespace im2fit::body {
namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedByte = 5121;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987;

// The one binary buffer and the views and accessors into it.
class Buffer {
 public:
  template <class T>
  int add(std::span<const T> values, const char* type, int component, std::size_t count, int target = 0) {
    while (bytes_.size() % 4 != 0) bytes_.push_back(std::byte{0});
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size_bytes()}};
    if (target != 0) view["target"] = target;
    const auto raw = std::as_bytes(values);
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    views_.push_back(view);
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    return static_cast<int>(accessors_.size()) - 1;
  }
  // Of 0..1: the component's largest number means 1. One a vertex.
  template <class T>
  int add_shares(std::span<const T> values, const char* type, int component) {
    const int accessor = add(values, type, component, values.size(), kArrayBuffer);
    accessors_.back()["normalized"] = true;
    return accessor;
  }
  // A view that no accessor reads; its number.
  std::size_t add_bytes(std::span<const std::byte> bytes) {
    while (bytes_.size() % 4 != 0) bytes_.push_back(std::byte{0});
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}});
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return views_.size() - 1;
  }
  int add_positions(std::span<const Vec3f> values) {
    const int accessor = add(values, "VEC3", kFloat, values.size(), kArrayBuffer);
    Vec3f low = values[0], high = values[0];
    for (const Vec3f& v : values) {
      low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
      high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
    accessors_.back()["min"] = {low.x, low.y, low.z};
    accessors_.back()["max"] = {high.x, high.y, high.z};
    return accessor;
  }
  std::vector<std::byte> bytes_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

// A set of vertices with the faces among them, numbered afresh.
struct Part {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<std::array<std::uint8_t, 4>> joints;
  std::vector<std::array<std::uint16_t, 4>> weights;  // 65535: 1; they sum to it
  std::vector<TextureCoordinate> texture;             // none, or one a vertex: repeated, so beyond 0..1
  std::vector<TexturePlace> texture_places;           // within 0..1 instead
  std::vector<std::array<std::uint8_t, 4>> colours;   // linear, 255: 1; none, or one a vertex
  // In its moving mesh, of cloth that moves: three vertices, the fourth number is none; and their shares.
  std::vector<std::array<std::uint16_t, 4>> corners;
  std::vector<std::array<float, 3>> shares;
  std::vector<std::uint16_t> indices;
  std::vector<std::uint16_t> hidden_indices;  // of triangles that cloth hides
};

Vec3f standing(Vec3f rest, float floor_mm) {
  return Vec3f{rest.x, rest.y - floor_mm, rest.z} * kMetres;
}

constexpr float kWhole = 65535;  // 1 in 16 bits

// The heaviest, which is the first, takes what rounding leaves. A joint whose weight vanishes is joint 0, as glTF
// wants.
void add_influences(Part& part, std::array<std::uint8_t, 4> joints, const std::array<float, 4>& weights) {
  std::array<std::uint16_t, 4> out{};
  long left = std::lround(kWhole);
  for (std::size_t k = 1; k < 4; ++k) {
    out[k] = static_cast<std::uint16_t>(std::clamp(std::lround(kWhole * weights[k]), 0L, left));
    left -= out[k];
    if (out[k] == 0) joints[k] = 0;
  }
  out[0] = static_cast<std::uint16_t>(left);
  part.joints.push_back(joints);
  part.weights.push_back(out);
}

TexturePlace rounded_place(TextureCoordinate t) {
  const auto share = [](float of) {
    return static_cast<std::uint16_t>(std::lround(kWhole * std::clamp(of, 0.0F, 1.0F)));
  };
  return {share(t.u), share(t.v)};
}

// What is drawn of a look's surface at rest, triangle by triangle.
Part part_of(const LookPart& look, float floor_mm) {
  Part part;
  for (const Vec3f& p : look.positions) part.positions.push_back(standing(p, floor_mm));
  part.normals = look.normals;
  for (const SkinRecord& s : look.skin) add_influences(part, s.segment, s.weight);
  for (const TextureCoordinate& t : look.texture) part.texture_places.push_back(rounded_place(t));
  return part;
}

void append_quad(const std::array<std::int32_t, 4>& quad, std::vector<std::uint16_t>& indices) {
  for (const std::size_t i : std::array<std::size_t, 6>{0, 1, 2, 0, 2, 3})
    indices.push_back(static_cast<std::uint16_t>(quad[i]));
}

// Quads whose corners are all hidden stand apart; `hidden` may be empty.
Part body_part(const BodyModel& model, std::span<const Vec3f> rest, float floor_mm,
               std::span<const std::uint8_t> hidden) {
  const SkinPart look = skin_part(model, rest);
  Part part = part_of(look, floor_mm);
  for (const auto& q : look.quads) {
    const bool seen = hidden.empty() || std::any_of(q.begin(), q.end(), [&](std::int32_t v) {
                        return hidden[static_cast<std::size_t>(look.body_vertex[static_cast<std::size_t>(v)])] == 0;
                      });
    append_quad(q, seen ? part.indices : part.hidden_indices);
  }
  return part;
}

Part look_part(const LookPart& look, float floor_mm) {
  Part part = part_of(look, floor_mm);
  for (const auto& q : look.quads) append_quad(q, part.indices);
  return part;
}

std::array<std::uint8_t, 4> bytes_of_colour(const std::array<float, 3>& linear) {
  const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(c, 0.0F, 1.0F))); };
  return {byte(linear[0]), byte(linear[1]), byte(linear[2]), 255};
}

Part part_of(const SkinnedPart& worn, float floor_mm) {
  Part part;
  for (const Vec3f& p : worn.positions) part.positions.push_back(standing(p, floor_mm));
  part.normals = worn.normals;
  for (std::size_t v = 0; v < worn.weights.size(); ++v) add_influences(part, worn.segments[v], worn.weights[v]);
  part.texture = worn.texture;
  for (const auto& colour : worn.vertex_colours) part.colours.push_back(bytes_of_colour(colour));
  for (const auto& c : worn.corners) part.corners.push_back({c[0], c[1], c[2], 0});
  part.shares = worn.shares;
  for (const auto& t : worn.triangles)
    for (const std::int32_t v : t) part.indices.push_back(static_cast<std::uint16_t>(v));
  return part;
}

Json primitive(Buffer& buffer, const Part& part, int material) {
  const std::size_t count = part.positions.size();
  const int positions = buffer.add_positions(part.positions);
  const int normals = buffer.add(std::span(part.normals), "VEC3", kFloat, count, kArrayBuffer);
  const int joints = buffer.add(std::span(part.joints), "VEC4", kUnsignedByte, count, kArrayBuffer);
  const int weights = buffer.add_shares(std::span(part.weights), "VEC4", kUnsignedShort);
  const int indices =
      buffer.add(std::span(part.indices), "SCALAR", kUnsignedShort, part.indices.size(), kElementArrayBuffer);
  Json attributes = {{"POSITION", positions}, {"NORMAL", normals}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}};
  if (!part.texture.empty())
    attributes["TEXCOORD_0"] = buffer.add(std::span(part.texture), "VEC2", kFloat, count, kArrayBuffer);
  if (!part.texture_places.empty())
    attributes["TEXCOORD_0"] = buffer.add_shares(std::span(part.texture_places), "VEC2", kUnsignedShort);
  if (!part.colours.empty())
    attributes["COLOR_0"] = buffer.add_shares(std::span(part.colours), "VEC4", kUnsignedByte);
  if (!part.corners.empty()) {
    attributes["_CORNERS"] = buffer.add(std::span(part.corners), "VEC4", kUnsignedShort, count, kArrayBuffer);
    attributes["_SHARES"] = buffer.add(std::span(part.shares), "VEC3", kFloat, count, kArrayBuffer);
  }
  Json json = {{"attributes", attributes}, {"indices", indices}, {"material", material}};
  // Skin below cloth is not drawn. Programs that undress or measure the avatar find its triangles in the extras.
  if (!part.hidden_indices.empty())
    json["extras"]["hidden_indices"] = buffer.add(std::span(part.hidden_indices), "SCALAR", kUnsignedShort,
                                                  part.hidden_indices.size(), kElementArrayBuffer);
  return json;
}

// Which OpenNI joint a segment's head is; HE, LA and RA lie elsewhere and have nodes of their own.
constexpr std::array<const char*, kSegmentCount> kOpenNiOfSegment = {
    nullptr, nullptr, "TO",    "NE", nullptr, nullptr, "LS", "LE", nullptr, nullptr,
    "RS",    "RE",    nullptr, "LH", "LK",    "LF",    "RH", "RK", "RF"};

struct Extra {
  const char* name;
  const char* openni;
  Segment parent;
};
constexpr Extra kExtraNodes[] = {{"head_centre", "HE", Segment::head},
                                 {"left_hand_centre", "LA", Segment::left_hand},
                                 {"right_hand_centre", "RA", Segment::right_hand}};

Json list_of(Vec3f v) {
  return {v.x, v.y, v.z};
}
Json metres(Vec3f v) {
  return list_of(v * kMetres);
}

// Nodes 0..18 are the segments in order, then the extra joints; the mesh's node comes last.
Json joint_nodes(const Figure& f) {
  Json nodes = Json::array();
  const RigPose rig = rig_pose(f.skeleton, f.pose);
  for (std::size_t s = 0; s < static_cast<std::size_t>(kSegmentCount); ++s) {
    const int parent = kSegmentParent[s];
    const Vec3f offset = f.skeleton.head[s] - f.skeleton.head[static_cast<std::size_t>(std::max(parent, 0))];
    Json node = {{"name", kSegmentNames[s]},
                 {"translation", parent < 0 ? list_of(rig.root_m) : metres(offset)},
                 {"rotation", rig.rotation[s]}};
    if (kOpenNiOfSegment[s] != nullptr) node["extras"] = {{"openni", kOpenNiOfSegment[s]}};
    nodes.push_back(node);
    if (parent >= 0) nodes[static_cast<std::size_t>(parent)]["children"].push_back(s);
  }
  for (const Extra& extra : kExtraNodes) {
    const auto s = static_cast<std::size_t>(extra.parent);
    const Vec3f at = extra.parent == Segment::head ? (f.skeleton.tail[s] - f.skeleton.head[s]) * 0.5F
                                                   : f.skeleton.tail[s] - f.skeleton.head[s];
    nodes[s]["children"].push_back(nodes.size());
    nodes.push_back({{"name", extra.name}, {"translation", metres(at)}, {"extras", {{"openni", extra.openni}}}});
  }
  return nodes;
}

Json material(const char* name, std::array<float, 4> colour, bool double_sided, double roughness = 0.8) {
  return {
      {"name", name},
      {"doubleSided", double_sided},
      {"pbrMetallicRoughness", {{"baseColorFactor", colour}, {"metallicFactor", 0}, {"roughnessFactor", roughness}}}};
}

// Of the one texture.
Json textured(const char* name, bool double_sided, double roughness) {
  Json json = material(name, {1, 1, 1, 1}, double_sided, roughness);
  json["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  return json;
}

// Channels for node 0's translation and every segment's rotation, all at the same times.
Json animation(Buffer& buffer, const Skeleton& rest, std::span<const PoseKey> keys) {
  std::vector<float> times;
  std::vector<Vec3f> roots;
  std::array<std::vector<std::array<float, 4>>, static_cast<std::size_t>(kSegmentCount)> rotations;
  for (const PoseKey& key : keys) {
    const RigPose rig = rig_pose(rest, key.pose);
    times.push_back(static_cast<float>(key.time_s));
    roots.push_back(rig.root_m);
    for (std::size_t s = 0; s < rotations.size(); ++s) {
      std::array<float, 4> q = rig.rotation[s];
      // q and -q are one rotation; the sign nearer to the key before goes the short way in every player.
      float along = 0;
      for (std::size_t i = 0; i < 4 && !rotations[s].empty(); ++i) along += q[i] * rotations[s].back()[i];
      if (along < 0)
        for (float& c : q) c = -c;
      rotations[s].push_back(q);
    }
  }
  const int input = buffer.add(std::span<const float>(times), "SCALAR", kFloat, times.size());
  buffer.accessors_.back()["min"] = {times.front()};
  buffer.accessors_.back()["max"] = {times.back()};
  Json samplers = Json::array(), channels = Json::array();
  const auto add = [&](int output, std::size_t node, const char* path) {
    channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
  };
  add(buffer.add(std::span<const Vec3f>(roots), "VEC3", kFloat, roots.size()), 0, "translation");
  for (std::size_t s = 0; s < rotations.size(); ++s)
    add(buffer.add(std::span<const std::array<float, 4>>(rotations[s]), "VEC4", kFloat, rotations[s].size()), s,
        "rotation");
  return {{"name", "motion"}, {"samplers", samplers}, {"channels", channels}};
}

void append_chunk(std::vector<std::byte>& out, const char* kind, std::span<const std::byte> bytes,
                  std::byte padding) {
  const auto length = static_cast<std::uint32_t>((bytes.size() + 3) / 4 * 4);
  const auto* raw = reinterpret_cast<const std::byte*>(&length);
  out.insert(out.end(), raw, raw + 4);
  const auto* name = reinterpret_cast<const std::byte*>(kind);
  out.insert(out.end(), name, name + 4);
  out.insert(out.end(), bytes.begin(), bytes.end());
  out.insert(out.end(), length - bytes.size(), padding);
}

// A still avatar without keys.
std::vector<std::byte> bytes_of(const Avatar& avatar, const Figure& figure, std::span<const PoseKey> keys) {
  const BodyModel::Data& d = avatar.model->data();
  Buffer buffer;
  // By name: clang reads a list of one in braces as that one, GCC as a list.
  Json primitives = Json::array(
      {primitive(buffer, body_part(*avatar.model, figure.rest, figure.floor_rest, avatar.hidden_skin), 0)});
  const bool has_look = !d.look.empty();
  Json materials =
      Json::array({has_look ? textured("skin", false, 0.7) : material("skin", {0.78F, 0.63F, 0.55F, 1}, false)});
  for (const SkinnedPart& worn : avatar.parts) {
    const std::array<float, 3> c = worn.vertex_colours.empty() ? worn.colour : std::array<float, 3>{1, 1, 1};
    primitives.push_back(primitive(buffer, part_of(worn, figure.floor_rest), static_cast<int>(materials.size())));
    materials.push_back(material(worn.material.c_str(), {c[0], c[1], c[2], 1}, true));
  }
  const LookOf whose = look_of(avatar.params.gender);
  if (has_look) {
    const auto add = [&](const LookPart& look, Json of) {
      if (look.quads.empty()) return;
      primitives.push_back(primitive(buffer, look_part(look, figure.floor_rest), static_cast<int>(materials.size())));
      materials.push_back(std::move(of));
    };
    add(eyes_part(*avatar.model, figure.rest), textured("eyes", false, 0.25));
    add(hair_part(*avatar.model, figure.rest, {}, whose), textured("hair", true, 0.6));
  }

  // Column-major translations by minus the joint's rest position, in the mesh's own space (floor at y = 0).
  std::vector<std::array<float, 16>> inverse_bind;
  Json joints = Json::array();
  for (std::size_t s = 0; s < static_cast<std::size_t>(kSegmentCount); ++s) {
    const Vec3f h = figure.skeleton.head[s];
    inverse_bind.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -h.x * kMetres, -(h.y - figure.floor_rest) * kMetres,
                            -h.z * kMetres, 1});
    joints.push_back(s);
  }
  const int matrices =
      buffer.add(std::span<const std::array<float, 16>>(inverse_bind), "MAT4", kFloat, inverse_bind.size());

  const std::size_t image =
      has_look ? buffer.add_bytes(d.look.texture[static_cast<std::size_t>(whose)]) : std::size_t{0};
  const Json animations = keys.empty() ? Json() : Json::array({animation(buffer, figure.skeleton, keys)});

  Json nodes = joint_nodes(figure);
  nodes.push_back({{"name", "avatar"}, {"mesh", 0}, {"skin", 0}});
  const std::size_t mesh_node = nodes.size() - 1;
  Json document = {
      {"asset", {{"version", "2.0"}, {"generator", "im2fit"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0, mesh_node}}}}},
      {"nodes", nodes},
      {"meshes", {{{"name", "avatar"}, {"primitives", primitives}}}},
      {"skins", {{{"inverseBindMatrices", matrices}, {"joints", joints}, {"skeleton", 0}}}},
      {"materials", materials},
      {"accessors", buffer.accessors_},
      {"bufferViews", buffer.views_},
      {"buffers", {{{"byteLength", buffer.bytes_.size()}}}},
  };
  if (!keys.empty()) document["animations"] = animations;
  if (has_look) {
    document["images"] = {{{"bufferView", image}, {"mimeType", "image/png"}, {"name", "skin"}}};
    document["samplers"] = {{{"magFilter", kLinear}, {"minFilter", kLinearMipmapLinear}}};
    document["textures"] = {{{"source", 0}, {"sampler", 0}}};
  }
  const std::string text = document.dump();

  std::vector<std::byte> chunks;
  append_chunk(chunks, "JSON", std::as_bytes(std::span(text)), std::byte{' '});
  append_chunk(chunks, "BIN\0", buffer.bytes_, std::byte{0});
  const std::array<std::uint32_t, 3> header = {0x46546C67, 2, static_cast<std::uint32_t>(12 + chunks.size())};
  const auto head = std::as_bytes(std::span(header));
  chunks.insert(chunks.begin(), head.begin(), head.end());
  return chunks;
}

Result<std::vector<std::byte>> bytes_of(const Avatar& avatar, std::span<const PoseKey> keys) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  return bytes_of(avatar, *figure, keys);
}

}  // namespace

Result<std::vector<std::byte>> glb_of(const Avatar& avatar) {
  return bytes_of(avatar, {});
}

std::vector<std::byte> glb_of(const Avatar& avatar, const Figure& figure) {
  return bytes_of(avatar, figure, {});
}

Result<std::vector<std::byte>> animated_glb_of(const Avatar& avatar, std::span<const PoseKey> keys) {
  if (auto ok = check_ascending(keys); !ok) return ok.error();
  return bytes_of(avatar, keys);
}

Status write_glb(const Avatar& avatar, const std::string& path) {
  const auto glb = glb_of(avatar);
  return glb ? write_file_atomically(path, *glb, Readable::by_owner) : glb.error();
}

Status write_glb(const Avatar& avatar, std::span<const PoseKey> keys, const std::string& path) {
  const auto glb = animated_glb_of(avatar, keys);
  return glb ? write_file_atomically(path, *glb, Readable::by_owner) : glb.error();
}

}  // namespace im2fit::body
