// SPDX-License-Identifier: Apache-2.0
// --motion: each kind of file read again by code of its own. Angles between limbs are the same in all axes, so the
// joints of the .csv give the angles that the .bvh and the .glb must show at the same times.
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "avatar_mesh.h"
#include "measured_clip.h"

namespace im2fit {
namespace {

using test::Point;

double angle_deg(Point a, Point b) {
  return std::acos(std::clamp(test::inner(a, b) / (test::length(a) * test::length(b)), -1.0, 1.0)) * 180 /
         std::numbers::pi;
}

// Of one frame: at the elbows, between thigh and upper arm of each side, between the thighs. `names`: shoulder, elbow
// and hand of the left and of the right arm, then hip and knee of the left and of the right leg.
using Angles = std::array<double, 5>;
Angles angles_of(const std::map<std::string, Point>& at, const std::array<const char*, 10>& names) {
  const auto place = [&](int i) { return at.at(names[static_cast<std::size_t>(i)]); };
  return {angle_deg(place(1) - place(0), place(2) - place(1)), angle_deg(place(4) - place(3), place(5) - place(4)),
          angle_deg(place(7) - place(6), place(1) - place(0)), angle_deg(place(9) - place(8), place(4) - place(3)),
          angle_deg(place(7) - place(6), place(9) - place(8))};
}
constexpr std::array<const char*, 10> kJoints = {"LS", "LE", "LA", "RS", "RE", "RA", "LH", "LK", "RH", "RK"};
constexpr std::array<const char*, 10> kNodes = {
    "left_upper_arm",    "left_lower_arm", "left_hand_centre", "right_upper_arm", "right_lower_arm",
    "right_hand_centre", "left_upper_leg", "left_lower_leg",   "right_upper_leg", "right_lower_leg"};

struct CsvRow {
  double time_s = 0;
  int user = 0;
  std::map<std::string, Point> joints;
  std::vector<std::string> cells;
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

std::vector<CsvRow> read_csv(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> head = cells_of(line);
  EXPECT_EQ(head.size(), 4 + 5 * 15U);
  EXPECT_EQ(line.substr(0, 30), "frame,time_s,user,view,HE_x_mm");
  std::vector<CsvRow> rows;
  while (std::getline(in, line)) {
    CsvRow row;
    row.cells = cells_of(line);
    EXPECT_EQ(row.cells.size(), head.size()) << line;
    row.time_s = std::stod(row.cells[1]);
    row.user = std::stoi(row.cells[2]);
    for (std::size_t c = 4; row.user != 0 && c + 4 < head.size(); c += 5)
      row.joints[head[c].substr(0, 2)] = {std::stod(row.cells[c]), std::stod(row.cells[c + 1]),
                                          std::stod(row.cells[c + 2])};
    rows.push_back(row);
  }
  return rows;
}

// A rotation and a place, by textbook trigonometry.
struct Frame {
  std::array<Point, 3> columns = {Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}};
  Point origin;
  Point turned(Point p) const { return columns[0] * p.x + columns[1] * p.y + columns[2] * p.z; }
  Frame child(Point offset, const std::array<Point, 3>& turn) const {
    return {{turned(turn[0]), turned(turn[1]), turned(turn[2])}, origin + turned(offset)};
  }
};

struct Bvh {
  struct Node {
    std::string name;
    int parent = -1;
    Point offset;
  };
  std::vector<Node> nodes;
  std::map<std::string, Point> ends;  // End Site of a node
  double frame_s = 0;
  std::vector<std::vector<double>> frames;

  // Where every node is in a frame, and where the leaf bones end.
  std::map<std::string, Point> places(std::size_t frame) const {
    const auto& channel = frames[frame];
    std::vector<Frame> world;
    std::map<std::string, Point> at;
    std::size_t c = 3;
    for (const Node& node : nodes) {
      const auto sin_cos = [&](std::size_t i) {
        const double rad = channel[c + i] * std::numbers::pi / 180;
        return std::pair{std::sin(rad), std::cos(rad)};
      };
      const auto [sz, cz] = sin_cos(0);
      const auto [sx, cx] = sin_cos(1);
      const auto [sy, cy] = sin_cos(2);
      c += 3;
      // Rz Rx Ry, by columns.
      const std::array<Point, 3> turn = {Point{cz * cy - sz * sx * sy, sz * cy + cz * sx * sy, -cx * sy},
                                         Point{-sz * cx, cz * cx, sx},
                                         Point{cz * sy + sz * sx * cy, sz * sy - cz * sx * cy, cx * cy}};
      if (node.parent < 0)
        world.push_back(Frame{}.child({channel[0], channel[1], channel[2]}, turn));
      else
        world.push_back(world[static_cast<std::size_t>(node.parent)].child(node.offset, turn));
      at[node.name] = world.back().origin;
      if (ends.contains(node.name))
        at[node.name + ".end"] = world.back().origin + world.back().turned(ends.at(node.name));
    }
    return at;
  }
};

Bvh read_bvh(const std::string& path) {
  Bvh bvh;
  std::ifstream in(path);
  std::vector<int> open;
  std::string word;
  bool end = false;
  while (in >> word && word != "MOTION") {
    if (word == "ROOT" || word == "JOINT") {
      bvh.nodes.emplace_back();
      in >> bvh.nodes.back().name;
      bvh.nodes.back().parent = open.empty() ? -1 : open.back();
    } else if (word == "End") {
      end = true;
    } else if (word == "{") {
      open.push_back(end ? open.back() : static_cast<int>(bvh.nodes.size()) - 1);
    } else if (word == "}") {
      open.pop_back();
      end = false;
    } else if (word == "OFFSET") {
      Point offset;
      in >> offset.x >> offset.y >> offset.z;
      if (end)
        bvh.ends[bvh.nodes.back().name] = offset;
      else
        bvh.nodes.back().offset = offset;
    }
  }
  std::size_t count = 0;
  in >> word >> count >> word >> word >> bvh.frame_s;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::stringstream numbers(line);
    bvh.frames.emplace_back();
    for (double value = 0; numbers >> value;) bvh.frames.back().push_back(value);
    EXPECT_EQ(bvh.frames.back().size(), 6 + 3 * (bvh.nodes.size() - 1));
  }
  EXPECT_EQ(bvh.frames.size(), count);
  return bvh;
}

// The clip of a person who sways, so that frames differ.
class Motion : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "14"}); }
  static std::string moved(const std::string& ending) {
    const std::string path = clip() + "-motion" + ending;
    measured({"--frames", "9", "--motion", path});
    return path;
  }
};

TEST_F(Motion, TheCsvHasEveryFrameAtItsTime) {
  const auto rows = read_csv(moved(".csv"));
  ASSERT_GE(rows.size(), 9U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows[i].time_s, static_cast<double>(i) / 30, 1e-3);
    EXPECT_EQ(rows[i].cells[0], std::to_string(i));
    ASSERT_NE(rows[i].user, 0);
    EXPECT_EQ(rows[i].cells[3], "front");
    // Camera axes: y down, z forward; the person's left is the picture's right.
    EXPECT_LT(rows[i].joints.at("HE").y, rows[i].joints.at("LF").y - 1000);
    EXPECT_GT(rows[i].joints.at("LS").x, rows[i].joints.at("RS").x + 200);
    EXPECT_NEAR(rows[i].joints.at("TO").z, 2500, 1500);
  }
}

TEST_F(Motion, TheBvhShowsTheJointsOfTheCsv) {
  const auto rows = read_csv(moved(".csv"));
  const Bvh bvh = read_bvh(moved(".bvh"));
  ASSERT_EQ(bvh.nodes.size(), 19U);
  ASSERT_EQ(bvh.frames.size(), rows.size());
  EXPECT_NEAR(bvh.frame_s, 1.0 / 30, 1e-4);
  auto names = kNodes;
  names[2] = "left_hand.end";
  names[5] = "right_hand.end";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto places = bvh.places(i);
    double lowest = 1e9;
    for (const auto& [name, at] : places) lowest = std::min(lowest, at.y);
    EXPECT_GE(lowest, -1) << "centimetres, soles on the floor";
    EXPECT_LT(lowest, 15);
    const Angles shown = angles_of(places, names), seen = angles_of(rows[i].joints, kJoints);
    for (std::size_t a = 0; a < shown.size(); ++a)
      EXPECT_NEAR(shown[a], seen[a], 1.0) << "frame " << i << " angle " << a;
  }
}

TEST_F(Motion, TheGlbMovesAtTheTimesOfTheCsv) {
  const auto rows = read_csv(moved(".csv"));
  const std::string bytes = test::read_text(moved(".glb"));
  std::uint32_t text_size = 0;
  std::memcpy(&text_size, bytes.data() + 12, 4);
  const auto json = nlohmann::json::parse(bytes.substr(20, text_size));
  const char* binary = bytes.data() + 20 + text_size + 8;
  const auto floats = [&](std::size_t accessor) {
    const auto& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::vector<float> out(view["byteLength"].get<std::size_t>() / 4);
    std::memcpy(out.data(), binary + view["byteOffset"].get<std::size_t>(), out.size() * 4);
    return out;
  };
  ASSERT_EQ(json["animations"].size(), 1U);
  const auto& animation = json["animations"][0];
  EXPECT_EQ(animation["channels"].size(), 20U) << "19 rotations and the root's place";
  const auto times = floats(animation["samplers"][0]["input"].get<std::size_t>());
  ASSERT_EQ(times.size(), rows.size());
  std::map<std::size_t, std::vector<float>> rotation, translation;
  for (const auto& channel : animation["channels"]) {
    const auto values =
        floats(animation["samplers"][channel["sampler"].get<std::size_t>()]["output"].get<std::size_t>());
    const auto node = channel["target"]["node"].get<std::size_t>();
    (channel["target"]["path"] == "rotation" ? rotation : translation)[node] = values;
  }
  ASSERT_EQ(rotation.size(), 19U);
  ASSERT_EQ(translation.size(), 1U);
  double moved_m = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(times[i], rows[i].time_s, 1e-5);
    std::map<std::string, Point> at;
    const std::function<void(std::size_t, const Frame&)> visit = [&](std::size_t n, const Frame& parent) {
      const auto& node = json["nodes"][n];
      auto t = node.value("translation", std::array<double, 3>{});
      if (translation.contains(n))
        for (std::size_t k = 0; k < 3; ++k) t[k] = static_cast<double>(translation[n][3 * i + k]);
      std::array<double, 4> q = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
      if (rotation.contains(n))
        for (std::size_t k = 0; k < 4; ++k) q[k] = static_cast<double>(rotation[n][4 * i + k]);
      EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-4);
      const auto [x, y, z, w] = q;
      const Frame here = parent.child({t[0], t[1], t[2]},
                                      {Point{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                                       Point{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                                       Point{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}});
      at[node["name"]] = here.origin;
      for (const auto& child : node.value("children", std::vector<std::size_t>())) visit(child, here);
    };
    visit(0, {});
    const Angles shown = angles_of(at, kNodes), seen = angles_of(rows[i].joints, kJoints);
    for (std::size_t a = 0; a < shown.size(); ++a)
      EXPECT_NEAR(shown[a], seen[a], 1.0) << "frame " << i << " angle " << a;
    if (i > 0) moved_m += std::abs(static_cast<double>(rotation[6][4 * i] - rotation[6][4 * i - 4]));
  }
  EXPECT_GT(moved_m, 0) << "frames differ";
}

TEST_F(Motion, RecordFollowsWithoutMeasuring) {
  const std::string out = clip() + "-again", csv = clip() + "-recorded.csv";
  const auto run = test::run_program({test::kProgram, "record", clip(), "--out", out, "--frames", "0", "--motion",
                                      csv, "--tracker", test::tracker_path(), "--body", test::body_path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, testing::HasSubstr("-recorded.csv: 14 frames"));
  const auto rows = read_csv(csv), by_measure = read_csv(moved(".csv"));
  ASSERT_EQ(rows.size(), 14U);
  for (std::size_t i = 0; i < by_measure.size(); ++i)
    EXPECT_EQ(rows[i].cells, by_measure[i].cells) << "the same joints, measured or not";
}

TEST_F(Motion, AnotherEndingIsRefused) {
  const auto run = test::measure(clip(), clip() + "-none", {"--motion", "x.fbx"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, testing::HasSubstr("x.fbx: motion is written as .csv, .bvh or .glb"));
}

}  // namespace
}  // namespace im2fit
