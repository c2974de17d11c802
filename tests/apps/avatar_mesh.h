// SPDX-License-Identifier: Apache-2.0
// An avatar.glb read and measured by code that shares nothing with body/: bytes by the glTF 2.0 specification, poses
// by linear blend skinning with trigonometry, girths by Cauchy's formula (the mean width of a section, which is its
// hull's), after the definitions in docs/result.md and docs/makehuman.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

namespace im2fit::test {

struct Point {
  double x = 0, y = 0, z = 0;
};
inline Point operator+(Point a, Point b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Point operator-(Point a, Point b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Point operator*(Point a, double f) {
  return {a.x * f, a.y * f, a.z * f};
}
inline double inner(Point a, Point b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Point outer(Point a, Point b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Point a) {
  return std::sqrt(inner(a, a));
}

// The skin of an avatar in its bind pose, mm.
struct AvatarMesh {
  struct Influence {
    std::array<std::uint8_t, 4> joint{};
    std::array<float, 4> weight{};
  };
  std::vector<Point> points;
  std::vector<Influence> skin;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  std::map<std::string, int> joint_of_name;
  std::vector<Point> joints;  // where each turns

  explicit AvatarMesh(const std::string& bytes) {
    const auto number = [&](std::size_t at) {
      std::uint32_t v = 0;
      std::memcpy(&v, bytes.data() + at, 4);
      return v;
    };
    const std::size_t text_size = number(12);
    const auto json = nlohmann::json::parse(bytes.substr(20, text_size));
    const char* binary = bytes.data() + 20 + text_size + 8;
    const auto values = [&](int accessor, auto& out) {
      const auto& a = json["accessors"][static_cast<std::size_t>(accessor)];
      const auto& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
      out.resize(view["byteLength"].get<std::size_t>() / sizeof out[0]);
      std::memcpy(out.data(), binary + view.value("byteOffset", 0), out.size() * sizeof out[0]);
    };
    const auto& body = json["meshes"][0]["primitives"][0];
    const auto& attributes = body["attributes"];
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<std::uint8_t, 4>> influences;
    std::vector<std::array<std::uint16_t, 4>> weights;  // 65535: 1
    std::vector<std::array<float, 16>> inverse_bind;
    values(attributes["POSITION"], positions);
    values(attributes["JOINTS_0"], influences);
    values(attributes["WEIGHTS_0"], weights);
    values(body["indices"], triangles);
    if (body.contains("extras")) {
      auto below = triangles;  // skin that clothes hide
      values(body["extras"]["hidden_indices"], below);
      triangles.insert(triangles.end(), below.begin(), below.end());
    }
    values(json["skins"][0]["inverseBindMatrices"], inverse_bind);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      points.push_back(Point{positions[i][0], positions[i][1], positions[i][2]} * 1e3);
      Influence influence{influences[i], {}};
      for (std::size_t k = 0; k < 4; ++k) influence.weight[k] = static_cast<float>(weights[i][k]) / 65535;
      skin.push_back(influence);
    }
    const auto& names = json["skins"][0]["joints"];
    for (std::size_t j = 0; j < names.size(); ++j) {
      joint_of_name[json["nodes"][names[j].get<std::size_t>()]["name"]] = static_cast<int>(j);
      const auto& m = inverse_bind[j];
      joints.push_back(Point{m[12], m[13], m[14]} * -1e3);
    }
  }
  Point joint(const std::string& name) const { return joints[static_cast<std::size_t>(joint_of_name.at(name))]; }
};

// What the file does not say of its mesh.
struct AvatarFacts {
  std::map<int, int> place_of_vertex;  // where a vertex of MakeHuman's mesh is in the file
  int left_acromion = 0, right_acromion = 0;
  double gender = 0;
};

// What is measured of an avatar, by measurement id; mm and kg.
class AvatarTape {
 public:
  AvatarTape(const AvatarMesh& mesh, const AvatarFacts& facts) : m_(mesh), facts_(facts) {
    double low = 1e9, high = -1e9;
    for (const Point& p : m_.points) {
      low = std::min(low, p.y);
      high = std::max(high, p.y);
    }
    const double stature = high - low, litres = volume();
    out_["stature"] = stature;
    const double index = litres / (stature * stature * 1e-6);
    out_["weight"] = litres * 1e-3 * (1025 - 25 * std::clamp((index - 18) / 24, 0.0, 1.0));
    relax(std::clamp(index < 30 ? 10 + (index - 20) * 0.4 : 14 + (index - 30) * 7 / 12, 10.0, 22.0));
    measure(low);
  }
  const std::map<std::string, double>& values() const { return out_; }

 private:
  // Landmarks of MakeHuman's mesh.
  enum { kLeftNipple = 8451, kRightNipple = 1779, kCrotch = 6431, kNavel = 4116 };

  struct Rotation {
    std::array<Point, 3> rows = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Point operator()(Point p) const { return {inner(rows[0], p), inner(rows[1], p), inner(rows[2], p)}; }
  };
  // About the axis square to both, by the angle between them.
  static Rotation turning(Point from, Point to) {
    const Point a = from * (1 / length(from)), b = to * (1 / length(to));
    Point n = outer(a, b);
    const double angle = std::atan2(length(n), inner(a, b));
    n = n * (1 / length(n));
    const auto turned = [&](Point p) {
      return p * std::cos(angle) + outer(n, p) * std::sin(angle) + n * (inner(n, p) * (1 - std::cos(angle)));
    };
    const Point x = turned({1, 0, 0}), y = turned({0, 1, 0}), z = turned({0, 0, 1});
    return {{{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}}};
  }
  static Rotation after(const Rotation& second, const Rotation& first) {
    const Point x = second(first({1, 0, 0})), y = second(first({0, 1, 0})), z = second(first({0, 0, 1}));
    return {{{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}}};
  }

  double volume() const {
    double six = 0;
    for (const auto& t : m_.triangles) six += inner(m_.points[t[0]], outer(m_.points[t[1]], m_.points[t[2]]));
    return six / 6e6;
  }

  // Arms down, `spread_deg` from the vertical; forearms a little closer and forward.
  void relax(double spread_deg) {
    const double upper = spread_deg * std::numbers::pi / 180, lower = 0.8 * upper;
    posed_joints_ = m_.joints;
    std::vector<Rotation> rotation(m_.joints.size());
    for (const std::string side : {"left", "right"}) {
      const double x = side == "left" ? 1 : -1;
      const auto of = [&](const char* part) { return static_cast<std::size_t>(m_.joint_of_name.at(side + part)); };
      const std::size_t shoulder = of("_upper_arm"), elbow = of("_lower_arm"), wrist = of("_hand");
      const Rotation up =
          turning(m_.joints[elbow] - m_.joints[shoulder], {x * std::sin(upper), -std::cos(upper), -0.02});
      const Point forearm = m_.joints[wrist] - m_.joints[elbow];
      const Rotation down = after(turning(up(forearm), {x * std::sin(lower), -std::cos(lower), 0.2}), up);
      rotation[shoulder] = up;
      rotation[elbow] = rotation[wrist] = down;
      posed_joints_[elbow] = m_.joints[shoulder] + up(m_.joints[elbow] - m_.joints[shoulder]);
      posed_joints_[wrist] = posed_joints_[elbow] + down(forearm);
    }
    for (std::size_t v = 0; v < m_.points.size(); ++v) {
      Point sum;
      double total = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto j = static_cast<std::size_t>(m_.skin[v].joint[i]);
        const double weight = static_cast<double>(m_.skin[v].weight[i]);
        sum = sum + (posed_joints_[j] + rotation[j](m_.points[v] - m_.joints[j])) * weight;
        total += weight;
      }
      posed_.push_back(sum * (1 / total));
    }
  }

  Point landmark(int vertex) const { return posed_[static_cast<std::size_t>(facts_.place_of_vertex.at(vertex))]; }
  Point joint(const std::string& name) const {
    return posed_joints_[static_cast<std::size_t>(m_.joint_of_name.at(name))];
  }
  bool is_arm(std::size_t joint) const {
    for (const char* name :
         {"left_upper_arm", "left_lower_arm", "left_hand", "right_upper_arm", "right_lower_arm", "right_hand"})
      if (m_.joint_of_name.at(name) == static_cast<int>(joint)) return true;
    return false;
  }
  double arm_weight(std::uint16_t v) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (is_arm(m_.skin[v].joint[i])) sum += static_cast<double>(m_.skin[v].weight[i]);
    return sum;
  }

  // The hull's length of the section square to `normal` through `at`, of triangles that `takes`.
  template <class Takes>
  double girth(Point at, Point normal, const Takes& takes) const {
    const Point n = normal * (1 / length(normal));
    const Point u = [&] {
      const Point p = outer(n, std::abs(n.x) < 0.7 ? Point{1, 0, 0} : Point{0, 0, 1});
      return p * (1 / length(p));
    }();
    const Point w = outer(n, u);
    std::vector<std::array<double, 2>> section;
    for (const auto& t : m_.triangles) {
      if (!takes(t)) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const Point a = posed_[t[i]], b = posed_[t[(i + 1) % 3]];
        const double da = inner(a - at, n), db = inner(b - at, n);
        if ((da > 0) == (db > 0)) continue;
        const Point p = a + (b - a) * (da / (da - db)) - at;
        section.push_back({inner(p, u), inner(p, w)});
      }
    }
    constexpr int kDirections = 2880;
    double sum = 0;
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDirections, c = std::cos(angle), s = std::sin(angle);
      double farthest = -1e9;
      for (const auto& p : section) farthest = std::max(farthest, p[0] * c + p[1] * s);
      sum += farthest;
    }
    return section.empty() ? 0 : sum * 2 * std::numbers::pi / kDirections;
  }

  void measure(double sole) {
    using Triangle = std::array<std::uint16_t, 3>;
    const auto trunk = [&](const Triangle& t) {
      return arm_weight(t[0]) + arm_weight(t[1]) + arm_weight(t[2]) < 1.5;
    };
    const auto all = [](const Triangle&) { return true; };
    const Point up = {0, 1, 0};
    const auto level = [&](double y, const auto& takes) { return girth({0, y, 0}, up, takes); };

    const double nipples = 0.5 * (landmark(kLeftNipple).y + landmark(kRightNipple).y), navel = landmark(kNavel).y;
    out_["chest_girth"] = level(nipples, trunk);
    out_["waist_girth"] = level(navel + (0.239 + (0.145 - 0.239) * facts_.gender) * (nipples - navel), trunk);
    Point rearmost = {0, 0, 1e9};
    for (std::size_t v = 0; v < posed_.size(); ++v) {
      const Point p = posed_[v];
      const int main_joint = m_.skin[v].joint[0];
      bool seat = false;
      for (const char* name : {"pelvis", "left_upper_leg", "right_upper_leg"})
        seat = seat || m_.joint_of_name.at(name) == main_joint;
      if (seat && p.z < rearmost.z && p.y >= landmark(kCrotch).y - 60 && p.y <= navel) rearmost = p;
    }
    out_["hip_girth"] = level(rearmost.y, trunk);
    double arms = 0;
    for (const std::string side : {"left", "right"})
      arms += 0.5 * (0.8 * joint(side + "_upper_arm").y + 0.2 * joint(side + "_lower_arm").y);
    out_["shoulder_girth"] = level(arms, all);
    out_["inside_leg"] = landmark(kCrotch).y - sole;
    neck(trunk);

    double sleeves = 0, legs = 0;
    for (const std::string side : {"left", "right"}) {
      const Point acromion = landmark(side == "left" ? facts_.left_acromion : facts_.right_acromion);
      sleeves += 0.5 * (length(acromion - joint(side + "_lower_arm")) +
                        length(joint(side + "_lower_arm") - joint(side + "_hand")));
      legs += 0.5 * (length(joint(side + "_upper_leg") - joint(side + "_lower_leg")) +
                     length(joint(side + "_lower_leg") - joint(side + "_foot")));
    }
    out_["sleeve_length"] = sleeves;
    out_["leg_length"] = legs;
    out_["shoulder_breadth"] = length(landmark(facts_.left_acromion) - landmark(facts_.right_acromion));
  }

  template <class Takes>
  void neck(const Takes& trunk) {
    const Point root = joint("neck"), axis = joint("head") - root;
    const double tall = length(axis);
    const auto near = [&](const std::array<std::uint16_t, 3>& t) {
      const Point p = posed_[t[0]] - root;
      const double along = inner(p, axis) / tall;
      return trunk(t) && along > -30 && along < tall + 60 && inner(p, p) - along * along < 150.0 * 150;
    };
    double least = 1e9, best = 0;
    const auto look = [&](double share) {
      const double mm = girth(root + axis * share, axis, near);
      if (mm <= 0 || mm >= least) return;
      least = mm;
      best = share;
    };
    for (int i = 0; i <= 10; ++i) look(0.1 * i);
    const double coarse = best;
    for (const int i : {-2, -1, 1, 2}) look(coarse + i / 30.0);
    out_["neck_girth"] = least;
  }

  const AvatarMesh& m_;
  const AvatarFacts& facts_;
  std::vector<Point> posed_, posed_joints_;
  std::map<std::string, double> out_;
};

}  // namespace im2fit::test
