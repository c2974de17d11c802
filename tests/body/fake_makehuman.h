// SPDX-License-Identifier: Apache-2.0
// A tiny stand-in for MakeHuman's data, written in either layout: a box for a body, a handful of bones, and targets
// that each move one vertex by an amount of their own, so that a test can tell from a mesh which weights were used.
#pragma once

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace im2fit::body {

inline constexpr int kFakeVertexCount = 19158;
inline constexpr int kFakeTextureSide = 64;  // pixels: quickly drawn

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-body-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

struct FakeRow {
  int vertex;
  std::array<int, 3> delta;  // 1e-3 dm
};

class FakeMakeHuman {
 public:
  // The box: 3 x 17 x 2 dm. Ring vertices 100..109 (left) and 110..119 (right) lie about the knees.
  static constexpr int kRingLeft = 100, kRingRight = 110;
  static constexpr int kKneeLeft = 13838, kKneeRight = 14278;

  FakeMakeHuman() {
    for (int v = 0; v < kFakeVertexCount; ++v)
      base.push_back({std::sin(v * 0.7) * 1.2, std::sin(v * 1.3) * 7.0, std::sin(v * 2.1) * 0.8});
    int corner = 0;
    for (const double y : {-8.5, 8.5})
      for (const auto& [x, z] : {std::pair{-1.5, -1.0}, {1.5, -1.0}, {1.5, 1.0}, {-1.5, 1.0}})
        base[static_cast<std::size_t>(corner++)] = {x, y, z};
    for (int i = 0; i < 10; ++i) {
      base[static_cast<std::size_t>(kRingLeft + i)] = {1.0, -4 + 0.06 * (i - 5), 0.1 * i};
      base[static_cast<std::size_t>(kRingRight + i)] = {-1.0, -4 + 0.06 * (i - 5), 0.1 * i};
    }
    int cube = 13606;
    const auto joint = [&](const std::string& name, double x, double y) {
      for (int i = 0; i < 8; ++i) base[static_cast<std::size_t>(cube + i)] = {x + (i & 1 ? 0.1 : -0.1), y, 0};
      joints[name] = cube;
      cube += 8;
    };
    const auto bone = [&](const std::string& name, const std::string& parent, double x, double y) {
      joint(name + "____head", x, y);
      bones[name] = parent;
    };
    bone("root", "", 0, 0);
    bone("spine05", "root", 0, 1);
    bone("spine03", "spine05", 0, 2);
    bone("neck01", "spine03", 0, 6);
    bone("head", "neck01", 0, 7);
    joint("head____tail", 0, 8);
    for (const std::string side : {".L", ".R"}) {
      const double s = side == ".L" ? 1 : -1;
      bone("clavicle" + side, "spine03", 0.3 * s, 5);
      bone("upperarm01" + side, "clavicle" + side, 1.2 * s, 5);
      bone("lowerarm01" + side, "upperarm01" + side, 1.3 * s, 3);
      bone("wrist" + side, "lowerarm01" + side, 1.4 * s, 1);
      bone("metacarpal3" + side, "wrist" + side, 1.4 * s, 0.5);
      joint("metacarpal3" + side + "____tail", 1.4 * s, 0.2);
      bone("upperleg01" + side, "root", 0.8 * s, 0);
      cube = side == ".L" ? kKneeLeft : kKneeRight;
      bone("lowerleg01" + side, "upperleg01" + side, 1.0 * s, -4);
      bone("foot" + side, "lowerleg01" + side, 1.0 * s, -8);
      joint("foot" + side + "____tail", 1.0 * s, -8.3);
      cube = 14000;
    }
    cube = 14080;
    for (const std::string side : {".L", ".R"}) {
      bone("eye" + side, "head", side == ".L" ? 0.3 : -0.3, 7.3);
      joint("eye" + side + "____tail", side == ".L" ? 0.3 : -0.3, 7.4);
    }
    for (int v = 0; v < kFakeVertexCount; ++v) weights.push_back({{"root", 1.0}});
    for (int i = 0; i < 10; ++i) {
      weights[static_cast<std::size_t>(kRingLeft + i)] = {{"lowerleg01.L", 0.4}, {"upperleg01.L", 0.3}};
      weights[static_cast<std::size_t>(kRingRight + i)] = {{"lowerleg01.R", 0.9}, {"upperleg01.R", 0.7}};
    }
    require_macros();
  }

  // Moves a vertex of its own, by which the test recognises it; returns that vertex.
  int add_target(const std::string& name) {
    const int vertex = 1000 + static_cast<int>(targets.size());
    targets[name] = {{vertex, {100, 0, 0}}};
    return vertex;
  }
  int marker(const std::string& name) const { return targets.at(name).front().vertex; }

  void write_npm(const std::string& directory) const {
    write(directory + "/src/json/rigs/default.json", rig_json());
    std::string list = "{\"targets\":{";
    // Written backwards: the order in the file means nothing.
    for (auto it = targets.rbegin(); it != targets.rend(); ++it)
      list += (it == targets.rbegin() ? "\"" : ",\"") + ("data/targets/" + it->first + ".target\":[]");
    write(directory + "/src/json/targets/target-list.json", list + "}}");
    std::vector<std::int16_t> bin(targets.size() * kFakeVertexCount * 3);
    std::size_t at = 0;
    for (const auto& [name, rows] : targets) {
      for (const FakeRow& row : rows)
        for (std::size_t axis = 0; axis < 3; ++axis)
          bin[at + static_cast<std::size_t>(row.vertex) * 3 + axis] = static_cast<std::int16_t>(row.delta[axis]);
      at += kFakeVertexCount * 3;
    }
    write(directory + "/public/data/targets/targets.bin",
          {reinterpret_cast<const char*>(bin.data()), bin.size() * sizeof bin[0]});
    write(directory + "/public/data/models/human_full_size.json", npm_mesh());
  }

  void write_upstream(const std::string& directory) const {
    const std::string data = directory + "/makehuman/data";
    write(data + "/rigs/default.mhskel", rig_json());
    std::string obj = "# base\nvt 0.25 0.5\nvt 0.5 0.5\nvt 0.5 0.75\nvt 0.25 0.75\n";
    for (const auto& v : base)
      obj += "v " + std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]) + "\n";
    for (const auto& [group, quads] : groups()) {
      obj += "g " + group + "\n";
      for (const auto& q : quads) {
        obj += "f";
        for (std::size_t i = 0; i < 4; ++i) obj += " " + std::to_string(q[i] + 1) + "/" + std::to_string(i + 1);
        obj += "\n";
      }
    }
    write(data + "/3dobjs/base.obj", obj);
    std::map<std::string, std::string> rows_of;
    for (std::size_t v = 0; v < weights.size(); ++v)
      for (const auto& [bone, weight] : weights[v])
        rows_of[bone] +=
            (rows_of[bone].empty() ? "[" : ",[") + std::to_string(v) + "," + std::to_string(weight) + "]";
    std::string json;
    for (const auto& [bone, rows] : rows_of) json += (json.empty() ? "\"" : ",\"") + (bone + "\":[" + rows + "]");
    write(data + "/rigs/default_weights.mhw", "{\"weights\":{" + json + "}}");
    for (const auto& [name, rows] : targets) {
      std::string text = "# a comment\n";
      for (const FakeRow& row : rows)
        text += std::to_string(row.vertex) + " " + std::to_string(row.delta[0] * 1e-3) + " " +
                std::to_string(row.delta[1] * 1e-3) + " " + std::to_string(row.delta[2] * 1e-3) + "\r\n";
      write(data + "/targets/" + name + ".target", text);
    }
  }

  static void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }

  std::vector<std::array<double, 3>> base;
  std::map<std::string, std::string> bones;  // name -> parent
  std::map<std::string, int> joints;         // name -> first vertex of its cube
  std::vector<std::vector<std::pair<std::string, double>>> weights;
  std::map<std::string, std::vector<FakeRow>> targets;  // sorted, as the npm package's bytes are

 private:
  using Quads = std::vector<std::array<int, 4>>;

  static std::map<std::string, Quads> groups() {
    const Quads box = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
    return {{"body", box},
            {"helper-tights", {{15328, 15329, 15330, 15331}}},
            {"helper-skirt", {{18002, 18003, 18004, 18005}}}};
  }

  void require_macros() {
    for (const std::string g : {"male", "female"}) {
      for (const std::string a : {"young", "old"}) {
        for (const std::string r : {"african", "asian", "caucasian"})
          add_target("macrodetails/" + r + "-" + g + "-" + a);
        for (const std::string m : {"minmuscle", "averagemuscle", "maxmuscle"})
          for (const std::string k : {"minweight", "averageweight", "maxweight"}) {
            const std::string who = g + "-" + a + "-" + m + "-" + k;
            add_target("macrodetails/universal-" + who);
            for (const std::string h : {"minheight", "maxheight"}) add_target("macrodetails/height/" + who + "-" + h);
            for (const std::string p : {"uncommonproportions", "idealproportions"})
              add_target("macrodetails/proportions/" + who + "-" + p);
          }
      }
    }
  }

  std::string rig_json() const {
    std::string bone_text, joint_text;
    for (const auto& [bone, parent] : bones) {
      const std::string tail = joints.contains(bone + "____tail") ? bone + "____tail" : bone + "____head";
      bone_text += (bone_text.empty() ? "\"" : ",\"") + bone +
                   "\":{\"parent\":" + (parent.empty() ? "null" : "\"" + parent + "\"") + ",\"head\":\"" + bone +
                   "____head\",\"tail\":\"" + tail + "\"}";
    }
    for (const auto& [name, first] : joints) {
      std::string list;
      for (int i = 0; i < 8; ++i) list += (i == 0 ? "" : ",") + std::to_string(first + i);
      joint_text += (joint_text.empty() ? "\"" : ",\"") + name + "\":[" + list + "]";
    }
    return "{\"bones\":{" + bone_text + "},\"joints\":{" + joint_text + "}}";
  }

  std::string npm_mesh() const {
    std::string vertices, faces, materials, names, index, weight;
    const auto comma = [](std::string& s) { s += s.empty() ? "" : ","; };
    for (const auto& v : base) {
      comma(vertices);
      vertices += std::to_string(v[0]) + "," + std::to_string(v[1]) + "," + std::to_string(v[2]);
    }
    int material = 0;
    for (const auto& [group, quads] : groups()) {
      comma(materials);
      materials += "{\"DbgName\":\"" + group + "\"}";
      for (const auto& q : quads) {
        comma(faces);
        faces += "11";
        for (const int v : q) faces += "," + std::to_string(v);
        faces += "," + std::to_string(material) + ",0,1,2,3";
      }
      ++material;
    }
    std::map<std::string, int> number;
    for (const auto& [bone, parent] : bones) {
      number[bone] = static_cast<int>(number.size()) * 2;
      comma(names);
      names += "{\"name\":\"" + bone + "____head\"},{\"name\":\"" + bone + "\"}";
    }
    for (const auto& list : weights)
      for (std::size_t i = 0; i < 4; ++i) {
        comma(index);
        comma(weight);
        index += std::to_string(i < list.size() ? number.at(list[i].first) : 0);
        weight += std::to_string(i < list.size() ? list[i].second : 0.0);
      }
    return "{\"uvs\":[[0.25,0.5,0.5,0.5,0.5,0.75,0.25,0.75]],\"vertices\":[" + vertices + "],\"faces\":[" + faces +
           "],\"materials\":[" + materials + "],\"bones\":[" + names + "],\"skinIndices\":[" + index +
           "],\"skinWeights\":[" + weight + "]}";
  }
};

}  // namespace im2fit::body
