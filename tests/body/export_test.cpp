// SPDX-License-Identifier: Apache-2.0
#include "body/export/export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "body/model_data.h"
#include "body_pack.h"
#include "core/file.h"
#include "fake_makehuman.h"
#include "garment/drape/wear.h"
#include "train/dressed/dressed_people.h"

namespace im2fit::body {
namespace {

using Json = nlohmann::json;
constexpr std::size_t kCount = static_cast<std::size_t>(kSegmentCount);

class RealAvatar : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEEDS_BODY();
    avatar_.model = real_body();
    avatar_.params.gender = 1;
    avatar_.params.age_years = 33;
    std::vector<Vec3f> rest(static_cast<std::size_t>(avatar_.model->vertex_count()));
    avatar_.model->morph(avatar_.params, rest);
    const Skeleton skeleton = rest_skeleton(*avatar_.model, rest);
    avatar_.pose = psi_pose(skeleton);
    avatar_.pose.translation_mm = {250, 40, -1800};
    // The truth: skinned here, standing on zero.
    posed_.resize(rest.size());
    skin(*avatar_.model, rest, skeleton, avatar_.pose, posed_);
    float low = 1e9F;
    for (std::size_t i = 0; i < kBodyVertexCount; ++i) low = std::min(low, posed_[i].y);
    for (Vec3f& v : posed_) v.y -= low;
    joints_ = joints_of(*avatar_.model, posed_);
  }
  std::vector<std::string> lines(const std::string& name) const {
    std::ifstream in(folder_ / name);
    std::vector<std::string> out;
    for (std::string line; std::getline(in, line);) out.push_back(line);
    return out;
  }
  TemporaryFolder folder_;
  Avatar avatar_;
  std::vector<Vec3f> posed_;
  JointSet joints_;
};

struct Glb {
  Json json;
  std::vector<std::byte> bin;

  template <class T>
  std::vector<T> read(std::size_t accessor) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    std::vector<T> out(a["count"].get<std::size_t>());
    EXPECT_EQ(view["byteLength"].get<std::size_t>(), out.size() * sizeof(T));
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + out.size() * sizeof(T), bin.size());
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0U);
    std::memcpy(out.data(), bin.data() + view["byteOffset"].get<std::size_t>(), out.size() * sizeof(T));
    return out;
  }
  // Of 0..1 in 16 bits.
  template <std::size_t N>
  std::vector<std::array<float, N>> shares(std::size_t accessor) const {
    EXPECT_EQ(json["accessors"][accessor]["componentType"], 5123);
    EXPECT_EQ(json["accessors"][accessor]["normalized"], true);
    std::vector<std::array<float, N>> out;
    for (const auto& whole : read<std::array<std::uint16_t, N>>(accessor))
      for (std::size_t k = 0; k < N; ++k) {
        if (k == 0) out.emplace_back();
        out.back()[k] = static_cast<float>(whole[k]) / 65535;
      }
    return out;
  }
};

Glb parse_glb(const std::string& path) {
  Glb out;
  const auto bytes = read_file(path);
  EXPECT_TRUE(bytes);
  const auto word = [&](std::size_t at) {
    std::uint32_t w = 0;
    std::memcpy(&w, bytes->data() + at, 4);
    return w;
  };
  EXPECT_EQ(word(0), 0x46546C67U);
  EXPECT_EQ(word(4), 2U);
  EXPECT_EQ(word(8), bytes->size());
  const std::size_t json_length = word(12);
  EXPECT_EQ(json_length % 4, 0U);
  EXPECT_EQ(word(16), 0x4E4F534AU);
  const auto* text = reinterpret_cast<const char*>(bytes->data()) + 20;
  out.json = Json::parse(text, text + json_length);
  EXPECT_EQ(word(20 + json_length + 4), 0x004E4942U);
  const std::size_t begin = 20 + json_length + 8;
  EXPECT_EQ(begin + word(20 + json_length), bytes->size());
  out.bin.assign(bytes->begin() + static_cast<std::ptrdiff_t>(begin), bytes->end());
  EXPECT_LE(out.json["buffers"][0]["byteLength"].get<std::size_t>(), out.bin.size());
  return out;
}

using Matrix = std::array<double, 16>;  // column-major

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t col = 0; col < 4; ++col)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) c[col * 4 + row] += a[k * 4 + row] * b[col * 4 + k];
  return c;
}

Matrix node_matrix(const Json& node) {
  const auto t = node.value("translation", std::array<double, 3>{});
  const auto [x, y, z, w] = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
  return {1 - 2 * (y * y + z * z),
          2 * (x * y + z * w),
          2 * (x * z - y * w),
          0,
          2 * (x * y - z * w),
          1 - 2 * (x * x + z * z),
          2 * (y * z + x * w),
          0,
          2 * (x * z + y * w),
          2 * (y * z - x * w),
          1 - 2 * (x * x + y * y),
          0,
          t[0],
          t[1],
          t[2],
          1};
}

void visit(const Json& nodes, std::size_t index, const Matrix& parent, std::map<std::size_t, Matrix>& out) {
  out[index] = times(parent, node_matrix(nodes[index]));
  for (const auto& child : nodes[index].value("children", std::vector<std::size_t>()))
    visit(nodes, child, out[index], out);
}

// Reads the file back as a viewer does: node transforms, inverse bind matrices, weights.
TEST_F(RealAvatar, AViewerSkinsTheGlbToThePosedMesh) {
  ASSERT_TRUE(write_glb(avatar_, folder_ / "a.glb"));
  const Glb glb = parse_glb(folder_ / "a.glb");
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
  const Json& nodes = glb.json["nodes"];
  std::map<std::size_t, Matrix> world;
  for (const std::size_t root : glb.json["scenes"][0]["nodes"])
    visit(nodes, root, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, world);
  EXPECT_EQ(world.size(), nodes.size()) << "every node hangs in the scene";
  const Json& rig = glb.json["skins"][0];
  const auto joint_nodes = rig["joints"].get<std::vector<std::size_t>>();
  ASSERT_EQ(joint_nodes.size(), kCount);
  const auto inverse_bind = glb.read<std::array<float, 16>>(rig["inverseBindMatrices"]);
  std::vector<Matrix> bone;
  for (std::size_t j = 0; j < kCount; ++j) {
    Matrix m{};
    std::copy(inverse_bind[j].begin(), inverse_bind[j].end(), m.begin());
    bone.push_back(times(world.at(joint_nodes[j]), m));
  }
  const bool has_look = !avatar_.model->data().look.empty();  // then eyes and hair follow
  ASSERT_EQ(glb.json["meshes"][0]["primitives"].size(), has_look ? 3U : 1U);
  EXPECT_LT(std::filesystem::file_size(folder_ / "a.glb"), 2'000'000U);
  const Json& primitive = glb.json["meshes"][0]["primitives"][0];
  const Json& attributes = primitive["attributes"];
  const auto positions = glb.read<Vec3f>(attributes["POSITION"]);
  const auto normals = glb.read<Vec3f>(attributes["NORMAL"]);
  const auto joints = glb.read<std::array<std::uint8_t, 4>>(attributes["JOINTS_0"]);
  const auto weights = glb.shares<4>(attributes["WEIGHTS_0"]);
  const auto indices = glb.read<std::uint16_t>(primitive["indices"]);
  ASSERT_GE(positions.size(), static_cast<std::size_t>(kBodyVertexCount));
  ASSERT_EQ(indices.size(), 26756U * 3);
  // At seams of the texture vertices are copied: faces tell which is which.
  const auto triangles = avatar_.model->body_triangles();
  for (std::size_t t = 0; t < triangles.size(); t += 7)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t v = indices[3 * t + i];
      ASSERT_LT(v, positions.size());
      std::array<double, 3> sum{};
      double total = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const Matrix& m = bone.at(joints[v][k]);
        const auto w = static_cast<double>(weights[v][k]);
        total += w;
        for (std::size_t row = 0; row < 3; ++row)
          sum[row] +=
              w * (m[row] * static_cast<double>(positions[v].x) + m[4 + row] * static_cast<double>(positions[v].y) +
                   m[8 + row] * static_cast<double>(positions[v].z) + m[12 + row]);
      }
      ASSERT_NEAR(total, 1, 1e-5);
      ASSERT_NEAR(norm(normals[v]), 1, 1e-4);
      const Vec3f truth = posed_[static_cast<std::size_t>(triangles[t][i])];
      ASSERT_NEAR(sum[0] * 1e3, truth.x, 0.05);
      ASSERT_NEAR(sum[1] * 1e3, truth.y, 0.05);
      ASSERT_NEAR(sum[2] * 1e3, truth.z, 0.05);
    }
  const Json& box = glb.json["accessors"][attributes["POSITION"].get<std::size_t>()];
  EXPECT_NEAR(box["min"][1].get<double>(), 0, 1e-6);
  EXPECT_NEAR(box["max"][1].get<double>(), 1.73, 0.01);
  // The fifteen joints are nodes.
  int found = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].contains("extras")) continue;
    const std::string name = nodes[n]["extras"]["openni"];
    for (std::size_t j = 0; j < kJointCount; ++j)
      if (name == kJointNames[j]) {
        ++found;
        for (std::size_t row = 0; row < 3; ++row)
          EXPECT_NEAR(world[n][12 + row] * 1e3, (&joints_.position_mm[j].x)[row], 0.1) << name;
      }
  }
  EXPECT_EQ(found, 15);
}

// Eyes and hair of the texture the skin has, in the places where they are in the posed mesh.
TEST_F(RealAvatar, EyesAndHairAreFurtherPrimitivesOfOneTexture) {
  if (avatar_.model->data().look.empty()) GTEST_SKIP() << "the body file has no look: run im2fit-lab fetch";
  ASSERT_TRUE(write_glb(avatar_, folder_ / "a.glb"));
  const Glb glb = parse_glb(folder_ / "a.glb");
  const Json& primitives = glb.json["meshes"][0]["primitives"];
  ASSERT_EQ(primitives.size(), 3U);
  const char* names[] = {"skin", "eyes", "hair"};
  const auto& d = avatar_.model->data();
  std::vector<Vec3f> rest(static_cast<std::size_t>(avatar_.model->vertex_count()));
  avatar_.model->morph(avatar_.params, rest);
  float floor = 1e9F;
  for (std::size_t v = 0; v < kBodyVertexCount; ++v) floor = std::min(floor, rest[v].y);
  const LookPart parts[] = {skin_part(*avatar_.model, rest), eyes_part(*avatar_.model, rest),
                            hair_part(*avatar_.model, rest, {}, LookOf::man)};
  for (std::size_t p = 0; p < 3; ++p) {
    const Json& primitive = primitives[p];
    const Json& material = glb.json["materials"][primitive["material"].get<std::size_t>()];
    EXPECT_EQ(material["name"], names[p]);
    EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
    const auto places = glb.read<Vec3f>(primitive["attributes"]["POSITION"]);
    const auto texture = glb.shares<2>(primitive["attributes"]["TEXCOORD_0"]);
    ASSERT_EQ(places.size(), parts[p].positions.size());
    ASSERT_EQ(texture.size(), places.size());
    for (std::size_t v = 0; v < places.size(); ++v) {
      const Vec3f at = {places[v].x * 1000, places[v].y * 1000 + floor, places[v].z * 1000};
      ASSERT_LT(norm(at - parts[p].positions[v]), 0.01F) << names[p];
      ASSERT_TRUE(texture[v][0] >= 0 && texture[v][0] <= 1 && texture[v][1] >= 0 && texture[v][1] <= 1);
    }
    for (const std::uint16_t i : glb.read<std::uint16_t>(primitive["indices"])) ASSERT_LT(i, places.size());
  }
  ASSERT_EQ(glb.json["images"].size(), 1U);
  EXPECT_EQ(glb.json["images"][0]["mimeType"], "image/png");
  const Json& view = glb.json["bufferViews"][glb.json["images"][0]["bufferView"].get<std::size_t>()];
  const auto& png = d.look.texture[static_cast<std::size_t>(LookOf::man)];
  ASSERT_EQ(view["byteLength"], png.size());
  EXPECT_EQ(std::memcmp(glb.bin.data() + view["byteOffset"].get<std::size_t>(), png.data(), png.size()), 0);
}

TEST_F(RealAvatar, ObjHasTextureCoordinatesEyesAndHair) {
  if (avatar_.model->data().look.empty()) GTEST_SKIP() << "the body file has no look: run im2fit-lab fetch";
  ASSERT_TRUE(write_obj(avatar_, folder_ / "a.obj"));
  std::vector<std::string> objects;
  std::size_t vertices = 0, coordinates = 0, normals = 0;
  for (const std::string& line : lines("a.obj")) {
    std::stringstream in(line);
    std::string kind, word;
    in >> kind;
    vertices += kind == "v" ? 1 : 0;
    coordinates += kind == "vt" ? 1 : 0;
    normals += kind == "vn" ? 1 : 0;
    if (kind == "o" && in >> word) objects.push_back(word);
    for (int corner = 0; kind == "f" && corner < 4; ++corner) {
      std::size_t v = 0, t = 0, n = 0;
      char slash = 0;
      ASSERT_TRUE(in >> v >> slash >> t >> slash >> n) << line;
      ASSERT_TRUE(v >= 1 && v <= vertices && t >= 1 && t <= coordinates && n >= 1 && n <= normals) << line;
    }
  }
  EXPECT_EQ(objects, (std::vector<std::string>{"body", "eyes", "hair"}));
}

// As a reader goes: from the .obj to its library, from the library to the pictures, all beside it.
TEST_F(RealAvatar, ATexturedObjLeadsToItsTexture) {
  const auto& look = avatar_.model->data().look;
  if (look.empty()) GTEST_SKIP() << "the body file has no look: run im2fit-lab fetch";
  ASSERT_TRUE(write_textured_obj(avatar_, folder_ / "a.obj"));
  std::string library, object, material;
  std::map<std::string, std::string> worn;  // by object
  for (const std::string& line : lines("a.obj")) {
    std::stringstream in(line);
    std::string kind;
    in >> kind;
    if (kind == "mtllib") {
      EXPECT_TRUE(object.empty()) << "named before it is used";
      in >> library;
    }
    if (kind == "o") in >> object;
    if (kind == "usemtl") in >> material;
    if (kind == "f") {
      worn.emplace(object, material);
      ASSERT_EQ(worn[object], material);
    }
  }
  EXPECT_EQ(worn, (std::map<std::string, std::string>{{"body", "skin"}, {"eyes", "eyes"}, {"hair", "hair"}}));
  ASSERT_EQ(library, "a.mtl");
  std::map<std::string, std::string> picture;  // by material
  for (const std::string& line : lines(library)) {
    std::stringstream in(line);
    std::string kind;
    in >> kind;
    if (kind == "newmtl") in >> material;
    if (kind == "map_Kd") in >> picture[material];
  }
  const auto& png = look.texture[static_cast<std::size_t>(LookOf::man)];
  for (const auto& [of, uses] : worn) {
    ASSERT_TRUE(picture.contains(uses)) << uses;
    EXPECT_EQ(picture[uses].find('/'), std::string::npos) << "beside it, wherever the folder goes";
    const auto bytes = read_file(folder_ / picture[uses]);
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_TRUE(std::equal(bytes->begin(), bytes->end(), png.begin(), png.end())) << uses;
  }
  // The text alone, for a caller who writes no files, names none.
  const auto alone = obj_of(avatar_);
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->find("mtl"), std::string::npos);
}

TEST_F(RealAvatar, NormalsPointOutwards) {
  ASSERT_TRUE(write_glb(avatar_, folder_ / "a.glb"));
  const Glb glb = parse_glb(folder_ / "a.glb");
  const Json& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
  const auto positions = glb.read<Vec3f>(attributes["POSITION"]);
  const auto normals = glb.read<Vec3f>(attributes["NORMAL"]);
  // Divergence theorem: a closed surface whose normals point outwards has a positive flux of its positions.
  double flux = 0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    flux += static_cast<double>(normals[i].x * positions[i].x + normals[i].z * positions[i].z);
  EXPECT_GT(flux, 0);
}

// Shirt and trousers, each a primitive of its own: skinned to where they were draped, and the skin below left out.
TEST_F(RealAvatar, GarmentsArePrimitivesThatStandWhereTheyWereDraped) {
  ASSERT_TRUE(write_glb(avatar_, folder_ / "naked.glb"));
  const Glb naked = parse_glb(folder_ / "naked.glb");
  std::vector<Vec3f> rest(static_cast<std::size_t>(avatar_.model->vertex_count()));
  avatar_.model->morph(avatar_.params, rest);
  const Skeleton skeleton = rest_skeleton(*avatar_.model, rest);
  const lab::DressedPerson person = lab::example_people(*avatar_.model)[1];
  Outfit outfit(*avatar_.model, lab::pieces_for(person, {"trousers", "t_shirt"}));
  outfit.dress(rest, skeleton, avatar_.pose);
  const ClothLook looks[] = {{"trousers", {0, 0, 1}}, {"shirt", {1, 0, 0}}};
  wear(avatar_, outfit, looks);
  ASSERT_TRUE(write_glb(avatar_, folder_ / "a.glb"));
  EXPECT_LT(std::filesystem::file_size(folder_ / "a.glb"), 3U << 20);
  const Glb glb = parse_glb(folder_ / "a.glb");
  const Json& primitives = glb.json["meshes"][0]["primitives"];
  ASSERT_EQ(primitives.size(), avatar_.model->data().look.empty() ? 3U : 5U);
  EXPECT_EQ(glb.json["materials"][2]["name"], "shirt");
  const auto count = [](const Glb& of, std::size_t primitive) {
    const Json& indices = of.json["meshes"][0]["primitives"][primitive]["indices"];
    return of.json["accessors"][indices.get<std::size_t>()]["count"].get<std::size_t>();
  };
  EXPECT_LT(count(glb, 0), count(naked, 0) * 9 / 10);

  // Skinned by hand: the sum of the joints' rigid motions gives the drape back.
  const PosedSkeleton posed = pose_skeleton(skeleton, outfit.pose());
  float floor = 1e9F;
  for (std::size_t v = 0; v < kBodyVertexCount; ++v) floor = std::min(floor, rest[v].y);
  for (const std::size_t garment : {0U, 1U}) {
    const Json& attributes = primitives[garment + 1]["attributes"];
    const auto places = glb.read<Vec3f>(attributes["POSITION"]);
    const auto joints = glb.read<std::array<std::uint8_t, 4>>(attributes["JOINTS_0"]);
    const auto weights = glb.shares<4>(attributes["WEIGHTS_0"]);
    ASSERT_EQ(places.size(), outfit.cloth(garment).mesh().vertex_count());
    EXPECT_EQ(glb.read<Flat>(attributes["TEXCOORD_0"]).size(), places.size());
    std::vector<Vec3f> shown(places.size());
    outfit.shown(garment, shown);
    float worst = 0;
    for (std::size_t v = 0; v < places.size(); ++v) {
      const Vec3f at = {places[v].x * 1000, places[v].y * 1000 + floor, places[v].z * 1000};
      Vec3f skinned{};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t s = joints[v][k];
        skinned = skinned + (posed.head[s] + outfit.pose().rotation[s] * (at - skeleton.head[s])) * weights[v][k];
      }
      worst = std::max(worst, norm(skinned - shown[v]));
    }
    EXPECT_LT(worst, 0.1F) << garment;
  }
}

TEST_F(RealAvatar, ObjHoldsThePosedMeshInMetres) {
  ASSERT_TRUE(write_obj(avatar_, folder_ / "a.obj"));
  std::size_t vertices = 0, faces = 0;
  for (const std::string& line : lines("a.obj")) {
    std::stringstream in(line);
    std::string kind;
    in >> kind;
    if (kind == "o" && line != "o body") break;  // eyes and hair
    if (kind == "v") {
      double x = 0, y = 0, z = 0;
      in >> x >> y >> z;
      ASSERT_NEAR(x * 1e3, posed_[vertices].x, 0.01);
      ASSERT_NEAR(y * 1e3, posed_[vertices].y, 0.01);
      ASSERT_NEAR(z * 1e3, posed_[vertices].z, 0.01);
      ++vertices;
    }
    if (kind == "f") {
      int first = 0;
      in >> first;
      ASSERT_EQ(first, avatar_.model->body_quads()[faces][0] + 1);
      ++faces;
    }
  }
  EXPECT_EQ(vertices, static_cast<std::size_t>(kBodyVertexCount));
  EXPECT_EQ(faces, 13378U);
}

TEST_F(RealAvatar, SkelListsTheFifteenJoints) {
  ASSERT_TRUE(write_skel(avatar_, folder_ / "a.skel"));
  const auto text = lines("a.skel");
  ASSERT_EQ(text.size(), kJointCount);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    std::stringstream in(text[j]);
    std::string name;
    Vec3f p;
    in >> name >> p.x >> p.y >> p.z;
    EXPECT_EQ(name, kJointNames[j]);
    EXPECT_LT(norm(p - joints_.position_mm[j]), 0.02F);
  }
}

// Replays the hierarchy and the one frame: offsets, then Z X Y rotations, as a BVH player does.
TEST_F(RealAvatar, ABvhPlayerPutsTheJointsWhereTheyAre) {
  ASSERT_TRUE(write_bvh(avatar_, folder_ / "a.bvh"));
  struct Node {
    std::string name;
    int parent;
    std::array<double, 3> offset;
  };
  std::vector<Node> nodes;
  std::vector<int> open;
  std::vector<double> motion;
  bool end_site = false, in_motion = false;
  for (const std::string& line : lines("a.bvh")) {
    std::stringstream in(line);
    std::string word;
    if (in_motion && std::isalpha(static_cast<unsigned char>(line[0])) == 0) {
      for (double v = 0; in >> v;) motion.push_back(v);
      continue;
    }
    in >> word;
    if (word == "MOTION") in_motion = true;
    if (word == "ROOT" || word == "JOINT") {
      std::string name;
      in >> name;
      nodes.push_back({name, open.empty() ? -1 : open.back(), {}});
    }
    if (word == "End") end_site = true;
    if (word == "{") open.push_back(static_cast<int>(nodes.size()) - 1);
    if (word == "}") {
      open.pop_back();
      end_site = false;
    }
    if (word == "OFFSET" && !end_site) {
      auto& o = nodes.back().offset;
      in >> o[0] >> o[1] >> o[2];
    }
  }
  ASSERT_TRUE(open.empty());
  ASSERT_EQ(nodes.size(), kCount);
  ASSERT_EQ(motion.size(), 6 + 3 * (kCount - 1));
  std::vector<Matrix> world(kCount);
  std::size_t channel = 3;
  std::map<std::string, std::array<double, 3>> position;
  for (std::size_t n = 0; n < kCount; ++n) {
    const Mat3f r = rotation_about({0, 0, 1}, static_cast<float>(motion[channel])) *
                    rotation_about({1, 0, 0}, static_cast<float>(motion[channel + 1])) *
                    rotation_about({0, 1, 0}, static_cast<float>(motion[channel + 2]));
    channel += 3;
    const auto t = n == 0 ? std::array<double, 3>{motion[0], motion[1], motion[2]} : nodes[n].offset;
    Matrix local{};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t col = 0; col < 3; ++col) local[col * 4 + row] = static_cast<double>(r.m[row * 3 + col]);
      local[12 + row] = t[row];
    }
    local[15] = 1;
    world[n] = n == 0 ? local : times(world[static_cast<std::size_t>(nodes[n].parent)], local);
    position[nodes[n].name] = {world[n][12] * 10, world[n][13] * 10, world[n][14] * 10};
  }
  for (const auto& [name, joint] : {std::pair{"left_lower_arm", Joint::LE},
                                    {"right_upper_arm", Joint::RS},
                                    {"neck", Joint::NE},
                                    {"right_foot", Joint::RF},
                                    {"left_upper_leg", Joint::LH}})
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(position.at(name)[axis], (&joints_[joint].x)[axis], 0.2) << name;
}

TEST_F(RealAvatar, AttributesAreTheNine) {
  avatar_.params.muscle = 0.25F;
  ASSERT_TRUE(write_attributes(avatar_, folder_ / "a.txt"));
  std::map<std::string, double> read;
  for (const std::string& line : lines("a.txt")) {
    std::stringstream in(line);
    std::string name;
    in >> name >> read[name];
  }
  EXPECT_EQ(read.size(), 9U);
  EXPECT_NEAR(read["age"], 33, 1e-6);
  EXPECT_NEAR(read["muscle"], 0.25, 1e-6);
}

TEST_F(RealAvatar, NothingIsLeftBehindWhereNothingCanBeWritten) {
  for (const auto write : {write_glb, write_obj, write_textured_obj, write_bvh, write_skel, write_attributes}) {
    const Status status = write(avatar_, folder_ / "no/such/folder/file");
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("no/such/folder"), std::string::npos);
  }
}

TEST(Avatar, WithoutAModelIsAnError) {
  const TemporaryFolder folder;
  EXPECT_FALSE(write_glb(Avatar{}, folder / "a.glb"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
}

}  // namespace
}  // namespace im2fit::body
