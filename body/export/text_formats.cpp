// SPDX-License-Identifier: Apache-2.0
// .obj, .bvh, .skel and the attribute file.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "body/export/export.h"
#include "body/export/figure.h"
#include "body/export/motion.h"
#include "body/model_data.h"
#include "core/file.h"

namespace im2fit::body {
namespace {

void append_triple(std::string& out, Vec3f v, double scale, int decimals) {
  append_number(out, v.x * scale, decimals);
  out += ' ';
  append_number(out, v.y * scale, decimals);
  out += ' ';
  append_number(out, v.z * scale, decimals);
}

constexpr std::size_t kDigitsMax = 20;
// Returns the end of the digits; `to` has room for kDigitsMax.
char* put_count(char* to, std::size_t count) {
  return std::to_chars(to, to + kDigitsMax, count).ptr;
}

constexpr double kDegrees = 57.29577951308232;
constexpr double kMotionFramesMax = 1e6;   // nine hours at 30 Hz: beyond it a clock has jumped
constexpr double kStillFrameS = 1.0 / 30;  // a file of one frame needs a length of it

// Angles z, x, y with R = Rz Rx Ry, degrees: BVH's usual channel order.
Vec3f euler_zxy(const Mat3f& r) {
  const double sin_x = r.m[7] > 1 ? 1 : (r.m[7] < -1 ? -1 : r.m[7]);
  return {static_cast<float>(std::atan2(-r.m[1], r.m[4]) * kDegrees), static_cast<float>(std::asin(sin_x) * kDegrees),
          static_cast<float>(std::atan2(-r.m[6], r.m[8]) * kDegrees)};
}

// One frame, in the order of the hierarchy: depth first.
void append_channels(std::string& out, const Skeleton& rest, const Pose& pose, std::size_t segment) {
  if (kSegmentParent[segment] < 0) {
    append_triple(out, rest.head[segment] + pose.translation_mm, 0.1, 4);
    out += ' ';
  }
  append_triple(out, euler_zxy(local_rotation(pose, segment)), 1, 4);
  out += ' ';
  for (std::size_t child = segment + 1; child < static_cast<std::size_t>(kSegmentCount); ++child)
    if (kSegmentParent[child] == static_cast<int>(segment)) append_channels(out, rest, pose, child);
}

void append_joint(std::string& out, const Figure& f, std::size_t segment, int depth) {
  const std::string indent(static_cast<std::size_t>(depth) * 2, ' ');
  const int parent = kSegmentParent[segment];
  const Vec3f head = f.skeleton.head[segment];
  const Vec3f offset = parent < 0 ? Vec3f{} : head - f.skeleton.head[static_cast<std::size_t>(parent)];
  out += indent + (parent < 0 ? "ROOT " : "JOINT ") + std::string(kSegmentNames[segment]) + "\n" + indent + "{\n";
  out += indent + "  OFFSET ";
  append_triple(out, offset, 0.1, 4);
  out += "\n" + indent +
         (parent < 0 ? "  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
                     : "  CHANNELS 3 Zrotation Xrotation Yrotation\n");
  bool leaf = true;
  for (std::size_t child = segment + 1; child < static_cast<std::size_t>(kSegmentCount); ++child)
    if (kSegmentParent[child] == static_cast<int>(segment)) {
      leaf = false;
      append_joint(out, f, child, depth + 1);
    }
  if (leaf) {
    out += indent + "  End Site\n" + indent + "  {\n" + indent + "    OFFSET ";
    append_triple(out, f.skeleton.tail[segment] - head, 0.1, 4);
    out += "\n" + indent + "  }\n";
  }
  out += indent + "}\n";
}

// `poses`: one a frame.
std::string bvh_of(const Figure& figure, std::span<const Pose> poses, double frame_s) {
  std::string out = "HIERARCHY\n";
  append_joint(out, figure, 0, 0);
  out += "MOTION\nFrames: " + std::to_string(poses.size()) + "\nFrame Time: ";
  append_number(out, frame_s, 7);
  out += '\n';
  for (const Pose& pose : poses) {
    append_channels(out, figure.skeleton, pose, 0);
    out.back() = '\n';
  }
  return out;
}

// Appends an object. `material`: of its faces, "" for none. `first`: how many vertices, texture coordinates and
// normals the file has, kept up. `vertex_of`: which of the part's positions and normals, whose first `vertex_count`
// are written, each of its vertices has.
template <class VertexOf>
void append_object(std::string& out, const char* name, const char* material, const LookPart& part,
                   std::size_t vertex_count, VertexOf vertex_of, std::array<std::size_t, 2>& first) {
  out += std::string("o ") + name + "\n";
  for (const Vec3f& v : std::span(part.positions).first(vertex_count)) {
    out += "v ";
    append_triple(out, v, 1e-3, 6);
    out += '\n';
  }
  for (const TextureCoordinate& t : part.texture) {  // v upwards here
    out += "vt ";
    append_number(out, static_cast<double>(t.u), 5);
    out += ' ';
    append_number(out, 1 - static_cast<double>(t.v), 5);
    out += '\n';
  }
  for (const Vec3f& n : std::span(part.normals).first(vertex_count)) {
    out += "vn ";
    append_triple(out, n, 1, 4);
    out += '\n';
  }
  if (*material != 0) out += std::string("usemtl ") + material + "\n";
  for (const auto& q : part.quads) {
    std::array<char, 1 + 4 * (3 + 3 * kDigitsMax) + 1> line{};
    char* at = line.data();
    *at++ = 'f';
    for (const std::int32_t v : q) {
      const std::size_t index = first[0] + vertex_of(static_cast<std::size_t>(v)) + 1;
      *at++ = ' ';
      const char* const number = at;
      at = put_count(at, index);
      const char* const end = at;
      *at++ = '/';
      if (!part.texture.empty()) at = put_count(at, first[1] + static_cast<std::size_t>(v) + 1);
      *at++ = '/';
      at = std::copy(number, end, at);
    }
    *at++ = '\n';
    out.append(line.data(), at);
  }
  first[0] += vertex_count;
  first[1] += part.texture.size();
}

// Phong's terms that come nearest to the materials of the .glb (Ns = 2 / roughness^4 - 2, Blinn's exponent); skin
// reflects 4 % of what falls on it.
struct ObjMaterial {
  const char *name, *object;
  double shininess;
};
constexpr ObjMaterial kObjMaterials[] = {{"skin", "body", 6.3}, {"eyes", "eyes", 510}, {"hair", "hair", 13.4}};

std::string mtl_of(const std::string& texture_name) {
  std::string out = "# im2fit avatar\n";
  for (const ObjMaterial& material : kObjMaterials) {
    out += std::string("\nnewmtl ") + material.name + "\nKa 0 0 0\nKd 1 1 1\nKs 0.04 0.04 0.04\nNs ";
    append_number(out, material.shininess, 1);
    out += "\nillum 2\nmap_Kd " + texture_name + "\n";
  }
  return out;
}

std::string obj_of(const Avatar& avatar, const Figure& figure, const std::string& material_library) {
  const BodyModel& model = *avatar.model;
  std::string out = "# im2fit avatar: metres, y up\n";
  if (!material_library.empty()) out += "mtllib " + material_library + "\n";
  std::array<std::size_t, 2> first{};
  const auto append = [&](const ObjMaterial& material, const LookPart& part, std::size_t vertex_count,
                          auto vertex_of) {
    append_object(out, material.object, material_library.empty() ? "" : material.name, part, vertex_count, vertex_of,
                  first);
  };
  const SkinPart body = skin_part(model, figure.posed);
  append(kObjMaterials[0], body, static_cast<std::size_t>(model.body_vertex_count()),
         [&](std::size_t v) { return static_cast<std::size_t>(body.body_vertex[v]); });
  const Mat3f& head = figure.pose.rotation[static_cast<std::size_t>(Segment::head)];
  const std::pair<const ObjMaterial&, LookPart> others[] = {
      {kObjMaterials[1], eyes_part(model, figure.posed)},
      {kObjMaterials[2], hair_part(model, figure.posed, head, look_of(avatar.params.gender))}};
  for (const auto& [material, part] : others)
    if (!part.quads.empty()) append(material, part, part.positions.size(), [](std::size_t v) { return v; });
  return out;
}

}  // namespace

Result<std::string> obj_of(const Avatar& avatar, const std::string& material_library) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  return obj_of(avatar, *figure, material_library);
}

Status write_obj(const Avatar& avatar, const std::string& path) {
  const auto text = obj_of(avatar);
  if (!text) return text.error();
  return write_file_atomically(path, *text, Readable::by_owner);
}

Status write_textured_obj(const Avatar& avatar, const std::string& path) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  return write_textured_obj(avatar, *figure, path);
}

// The .obj last: what it names is there before it.
Status write_textured_obj(const Avatar& avatar, const Figure& figure, const std::string& path) {
  if (avatar.model->data().look.empty())
    return write_file_atomically(path, obj_of(avatar, figure, ""), Readable::by_owner);
  const std::string stem = path.substr(0, path.size() - (path.ends_with(".obj") ? 4 : 0));
  const std::string name = stem.substr(stem.find_last_of('/') + 1);
  const auto whose = static_cast<std::size_t>(look_of(avatar.params.gender));
  if (auto written =
          write_file_atomically(stem + "_skin.png", avatar.model->data().look.texture[whose], Readable::by_owner);
      !written)
    return written;
  if (auto written = write_file_atomically(stem + ".mtl", mtl_of(name + "_skin.png"), Readable::by_owner); !written)
    return written;
  return write_file_atomically(path, obj_of(avatar, figure, name + ".mtl"), Readable::by_owner);
}

Result<std::string> bvh_of(const Avatar& avatar) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  return bvh_of(*figure, std::span(&figure->pose, 1), kStillFrameS);
}

Status write_bvh(const Avatar& avatar, const std::string& path) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  return write_bvh(*figure, path);
}

Status write_bvh(const Figure& figure, const std::string& path) {
  return write_file_atomically(path, bvh_of(figure, std::span(&figure.pose, 1), kStillFrameS), Readable::by_owner);
}

Status write_bvh(const Avatar& avatar, std::span<const PoseKey> keys, const std::string& path) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  if (auto ok = check_ascending(keys); !ok) return ok;
  std::vector<double> steps;
  for (std::size_t i = 1; i < keys.size(); ++i) steps.push_back(keys[i].time_s - keys[i - 1].time_s);
  double frame_s = kStillFrameS;
  if (!steps.empty()) {
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    frame_s = *middle;
  }
  if (!((keys.back().time_s - keys.front().time_s) / frame_s < kMotionFramesMax))
    return Error{ErrorCode::unsupported, path + ": the times span more than a million frames of " +
                                             std::to_string(frame_s) + " s; a .glb or .csv keeps them as they are"};
  std::vector<Pose> poses;
  std::size_t at = 0;
  const auto frame_count = static_cast<std::size_t>((keys.back().time_s - keys.front().time_s) / frame_s + 0.5) + 1;
  for (std::size_t frame = 0; frame < frame_count; ++frame) {
    const double time_s = keys.front().time_s + frame_s * static_cast<double>(frame);
    while (at + 1 < keys.size() && keys[at + 1].time_s <= time_s + frame_s / 2) ++at;
    poses.push_back(keys[at].pose);
  }
  return write_file_atomically(path, bvh_of(*figure, poses, frame_s), Readable::by_owner);
}

Status write_skel(const Avatar& avatar, const std::string& path) {
  const auto figure = make_figure(avatar);
  if (!figure) return figure.error();
  const JointSet joints = joints_of(*avatar.model, figure->posed);
  std::string out;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    out += std::string(kJointNames[j]) + " ";
    append_triple(out, joints.position_mm[j], 1, 2);
    out += '\n';
  }
  return write_file_atomically(path, out, Readable::by_owner);
}

Status write_attributes(const Avatar& avatar, const std::string& path) {
  const Params& p = avatar.params;
  std::string out;
  const auto line = [&](const char* name, float value, int decimals) {
    out += std::string(name) + " ";
    append_number(out, value, decimals);
    out += '\n';
  };
  line("age", p.age_years, 2);
  line("gender", p.gender, 6);
  line("height", p.height, 6);
  line("weight", p.weight, 6);
  line("muscle", p.muscle, 6);
  line("african", p.race[0], 6);
  line("asian", p.race[1], 6);
  line("caucasian", p.race[2], 6);
  line("proportions", p.proportions, 6);
  return write_file_atomically(path, out, Readable::by_owner);
}

}  // namespace im2fit::body
