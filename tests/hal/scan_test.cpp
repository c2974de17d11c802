// SPDX-License-Identifier: Apache-2.0
// Scans of bodies: a figure of simple solids, written in each format as that format's text says, in other units and
// axes; looked at by the scan's camera.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <numbers>

#include "core/file.h"
#include "hal/open/open.h"
#include "hal/scan/scan_camera.h"
#include "hal/scan/scan_file.h"
#include "hal/scan/scan_source.h"
#include "hal/scan/standing_scan.h"
#include "support.h"

namespace im2fit::hal {
namespace {

constexpr float kTrunkWideMm = 180, kTrunkDeepMm = 110, kTallMm = 1700;

// In mm, y up from the floor, facing +z: two legs with feet, a trunk, a head.
Scan figure() {
  Scan scan;
  // A tube about an axis that points up, from its bottom to its top, closed at both ends.
  const auto tube = [&](float x, float z, float low, float high, float rx, float rz) {
    constexpr int kRound = 24, kRows = 20;
    const auto first = static_cast<std::uint32_t>(scan.points.size());
    for (int row = 0; row <= kRows; ++row)
      for (int i = 0; i < kRound; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kRound;
        scan.points.push_back({x + rx * std::sin(angle),
                               low + (high - low) * static_cast<float>(row) / static_cast<float>(kRows),
                               z + rz * std::cos(angle)});
      }
    const auto at = [&](int row, int i) { return first + static_cast<std::uint32_t>(row * kRound + i % kRound); };
    for (int row = 0; row < kRows; ++row)
      for (int i = 0; i < kRound; ++i) {
        scan.triangles.push_back({at(row, i), at(row, i + 1), at(row + 1, i + 1)});
        scan.triangles.push_back({at(row, i), at(row + 1, i + 1), at(row + 1, i)});
      }
    for (int i = 1; i + 1 < kRound; ++i) {
      scan.triangles.push_back({at(0, 0), at(0, i + 1), at(0, i)});
      scan.triangles.push_back({at(kRows, 0), at(kRows, i), at(kRows, i + 1)});
    }
  };
  for (const float x : {-95.0F, 95.0F}) {
    tube(x, 0, 40, 800, 60, 60);
    tube(x, 60, 0, 50, 45, 130);
  }
  tube(0, 0, 800, 1440, kTrunkWideMm, kTrunkDeepMm);
  tube(0, 0, 1440, kTallMm, 80, 95);
  return scan;
}

Scan moved(Scan scan, const std::function<Vec3f(Vec3f)>& move) {
  for (Vec3f& p : scan.points) p = move(p);
  return scan;
}

using Move = std::pair<const char*, Vec3f (*)(Vec3f)>;

class Axes : public testing::TestWithParam<Move> {};

TEST_P(Axes, APersonStandsOnTheFloorAndFacesTheCamera) {
  const Scan whole = figure();
  const auto stood = stand_scan(moved(whole, GetParam().second), {}, "a.ply");
  ASSERT_TRUE(stood) << stood.error().message;
  EXPECT_NEAR(stood->height_mm, kTallMm, 5);
  ASSERT_EQ(stood->points.size(), whole.points.size());
  // The trunk's middle lies on the axis; the feet of this figure lie before it.
  double worst = 0;
  for (std::size_t i = 0; i < whole.points.size(); ++i)
    worst = std::max(worst, static_cast<double>(norm(stood->points[i] - whole.points[i])));
  EXPECT_LT(worst, 12);
}

INSTANTIATE_TEST_SUITE_P(
    Scans, Axes,
    testing::Values(Move{"millimetres_y_up", [](Vec3f p) { return p; }},
                    Move{"metres_far_away",
                         [](Vec3f p) {
                           return Vec3f{p.x, p.y, p.z} * 0.001F + Vec3f{7, -3, 2};
                         }},
                    Move{"centimetres_z_up",
                         [](Vec3f p) {
                           return Vec3f{p.x, -p.z, p.y} * 0.1F;
                         }},
                    Move{"inches_x_up",
                         [](Vec3f p) {
                           return Vec3f{p.y, -p.x, p.z} * (1 / 25.4F);
                         }},
                    Move{"feet_y_down",
                         [](Vec3f p) {
                           return Vec3f{p.x, -p.y, -p.z} * (1 / 304.8F);
                         }},
                    Move{"decimetres_z_down",
                         [](Vec3f p) {
                           return Vec3f{p.x, p.z, -p.y} * 0.01F;
                         }},
                    Move{"faces_backwards",
                         [](Vec3f p) {
                           return Vec3f{-p.x, p.y, -p.z};
                         }},
                    Move{"faces_aside",
                         [](Vec3f p) {
                           return Vec3f{p.z, p.y, -p.x};
                         }},
                    Move{"turned_by_thirty_degrees",
                         [](Vec3f p) {
                           return Vec3f{0.866025F * p.x + 0.5F * p.z, p.y, -0.5F * p.x + 0.866025F * p.z};
                         }}),
    [](const testing::TestParamInfo<Move>& test) { return std::string(test.param.first); });

TEST(Scans, ABodyThatLeansIsStraightened) {
  const Scan whole = figure();
  const auto stood =
      stand_scan(moved(whole,
                       [](Vec3f p) {
                         return Vec3f{p.x, 0.9703F * p.y - 0.2419F * p.z, 0.2419F * p.y + 0.9703F * p.z};
                       }),
                 {}, "a.ply");
  ASSERT_TRUE(stood) << stood.error().message;
  EXPECT_TRUE(stood->straightened);
  EXPECT_NEAR(stood->height_mm, kTallMm, 12);
  double worst = 0;
  for (std::size_t i = 0; i < whole.points.size(); ++i)
    worst = std::max(worst, static_cast<double>(norm(stood->points[i] - whole.points[i])));
  EXPECT_LT(worst, 60);  // 2 degrees over the height: this figure's feet lie before its ankles
}

TEST(Scans, AFloorThatWasScannedIsLeftOut) {
  Scan scan = figure();
  const std::size_t body = scan.points.size();
  for (int x = -25; x <= 25; ++x)
    for (int z = -25; z <= 25; ++z)
      scan.points.push_back({40.0F * static_cast<float>(x), 0, 40.0F * static_cast<float>(z)});
  const auto stood = stand_scan(std::move(scan), {}, "a.ply");
  ASSERT_TRUE(stood) << stood.error().message;
  EXPECT_NEAR(stood->height_mm, kTallMm, 5);
  EXPECT_LE(stood->points.size(), body);
  float farthest = 0;
  for (const Vec3f p : stood->points) farthest = std::max(farthest, std::hypot(p.x, p.z));
  EXPECT_LT(farthest, 300);
}

TEST(Scans, DustAndPointsFarAwayAreLeftOut) {
  Scan scan = figure();
  const std::size_t body = scan.points.size();
  for (int i = 0; i < 3; ++i) scan.points.push_back({9e6F, 3e5F * static_cast<float>(i), -9e6F});
  scan.points.push_back({0, 9000, 0});
  scan.points.push_back({2500, 500, 0});
  const auto stood = stand_scan(std::move(scan), {}, "a.ply");
  ASSERT_TRUE(stood) << stood.error().message;
  EXPECT_EQ(stood->points.size(), body);
  EXPECT_NEAR(stood->height_mm, kTallMm, 5);
}

TEST(Scans, TrianglesThatLieOverOneAnotherAreRefused) {
  Scan scan = figure();
  const auto last = static_cast<std::uint32_t>(scan.points.size() - 1);
  for (int i = 0; i < 100'000; ++i) scan.triangles.push_back({0, 1, last});
  const auto stood = stand_scan(std::move(scan), {}, "a.ply");
  ASSERT_FALSE(stood);
  EXPECT_TRUE(contains(stood.error().message, "over one another")) << stood.error().message;
}

TEST(Scans, WhatIsNoPersonIsRefusedWithWhatToGive) {
  const auto tiny = stand_scan(moved(figure(), [](Vec3f p) { return p * 0.3F; }), {}, "toy.ply");
  ASSERT_FALSE(tiny);
  EXPECT_TRUE(contains(tiny.error().message, "toy.ply")) << tiny.error().message;
  EXPECT_TRUE(contains(tiny.error().message, "--unit")) << tiny.error().message;
  ScanOptions inches;
  inches.unit_mm = 25.4;
  const auto giant = stand_scan(figure(), inches, "a.ply");
  ASSERT_FALSE(giant);
  EXPECT_TRUE(contains(giant.error().message, "1200 to 2300")) << giant.error().message;
  ScanOptions up;
  up.up = "w";
  EXPECT_FALSE(stand_scan(figure(), up, "a.ply"));
  Scan few = figure();
  few.points.resize(100);
  few.triangles.clear();
  EXPECT_FALSE(stand_scan(std::move(few), {}, "a.ply"));
}

StandingScan standing(Scan scan) {
  auto stood = stand_scan(std::move(scan), {}, "a.ply");
  EXPECT_TRUE(stood);
  return std::move(*stood);
}

// A point of the picture in the axes of the camera at yaw 0.
Vec3f at_rest(const CameraPose& q, Vec3f p) {
  const Vec3f axis = {q.x, q.y, q.z};
  return p + cross(axis, cross(axis, p) + p * q.w) * 2 + q.position_mm;
}

class Looks : public testing::TestWithParam<bool> {
 protected:
  // Of the mesh, or of a cloud of as many points as a scanner gives.
  static StandingScan seen() {
    Scan scan = figure();
    if (!GetParam()) return standing(std::move(scan));
    Scan cloud;
    for (const ScanTriangle& t : scan.triangles)
      for (int i = 0; i < 24; ++i)
        for (int j = 0; i + j < 24; ++j) {
          const float b = (static_cast<float>(i) + 0.4F) / 24.4F, c = (static_cast<float>(j) + 0.3F) / 24.4F;
          cloud.points.push_back(scan.points[t[0]] * (1 - b - c) + scan.points[t[1]] * b + scan.points[t[2]] * c);
        }
    return standing(std::move(cloud));
  }
};

TEST_P(Looks, EveryPictureHasTheTrunkWhereItsPoseSaysItIs) {
  ScanCamera camera(seen());
  const Intrinsics k = ScanCamera::intrinsics();
  Picture picture(k.width, k.height);
  for (const float yaw : {0.0F, 90.0F, 200.0F, 360.0F}) {
    camera.render(yaw, picture.image());
    int trunk = 0;
    double worst = 0;
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        const auto z = static_cast<float>(picture.view().at(u, v));
        if (z == 0) continue;
        const Vec3f p = at_rest(ScanCamera::pose(yaw), unproject(k, static_cast<float>(u), static_cast<float>(v), z));
        const float height = 1000 - p.y;
        if (height < 900 || height > 1400) continue;
        ++trunk;
        // The axis stands 2400 mm before the camera at rest.
        const float r = std::hypot(p.x / kTrunkWideMm, (p.z - 2400) / kTrunkDeepMm);
        worst = std::max(worst, std::fabs(static_cast<double>(r) - 1));
      }
    EXPECT_GT(trunk, 4000) << yaw;
    EXPECT_LT(worst, GetParam() ? 0.12 : 0.05) << yaw;  // of 24 corners; the figure stands 5 mm off
  }
}

TEST_P(Looks, TheFloorLiesAtTheFeetAndNothingBehindThePerson) {
  ScanCamera camera(seen());
  const Intrinsics k = ScanCamera::intrinsics();
  Picture picture(k.width, k.height);
  camera.render(0, picture.image());
  int floor = 0;
  for (int v = 0; v < k.height; ++v) {
    const auto z = static_cast<float>(picture.view().at(40, v));
    if (z == 0) continue;
    ++floor;
    EXPECT_NEAR(1000 - unproject(k, 40, static_cast<float>(v), z).y, 0, 3);
  }
  EXPECT_GT(floor, 50);
  EXPECT_EQ(picture.view().at(k.width / 2, 5), 0);
}

INSTANTIATE_TEST_SUITE_P(Scans, Looks, testing::Bool(), [](const testing::TestParamInfo<bool>& test) {
  return std::string(test.param ? "cloud" : "mesh");
});

TEST(Scans, AHoleShowsNothingNotTheBackFromWithin) {
  Scan scan = figure();
  std::erase_if(scan.triangles, [&](const ScanTriangle& t) {
    const Vec3f p = (scan.points[t[0]] + scan.points[t[1]] + scan.points[t[2]]) * (1.0F / 3);
    return p.z > 60 && p.y > 1050 && p.y < 1150;
  });
  ScanCamera camera(standing(std::move(scan)));
  const Intrinsics k = ScanCamera::intrinsics();
  Picture picture(k.width, k.height);
  camera.render(0, picture.image());
  const auto row = [&](float height) {
    return static_cast<int>(std::lround(k.cy + k.fy * (1000 - height) / (2400 - kTrunkDeepMm)));
  };
  EXPECT_EQ(picture.view().at(k.width / 2, row(1100)), 0);
  EXPECT_NEAR(picture.view().at(k.width / 2, row(1250)), 2400 - kTrunkDeepMm, 8);
}

// Formats, written here as their texts have them.
class Files : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& bytes) {
    ASSERT_TRUE(write_file_atomically(folder_.path(name), bytes));
  }
  template <class T>
  static void add(std::string& bytes, T value, bool big = false) {
    std::array<char, sizeof(T)> piece{};
    std::memcpy(piece.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes += piece[big ? sizeof(T) - 1 - i : i];
  }
  // The same points, and as many triangles.
  void expect_figure(const std::string& name, bool triangles = true) {
    const Scan whole = figure();
    const auto scan = read_scan(folder_.path(name));
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->points.size(), whole.points.size());
    for (std::size_t i = 0; i < whole.points.size(); ++i)
      ASSERT_LT(norm(scan->points[i] - whole.points[i]), 0.01F) << i;
    EXPECT_EQ(scan->triangles, triangles ? whole.triangles : std::vector<ScanTriangle>());
  }
  // Cut anywhere, a file is refused in one line that names it.
  void expect_refused_when_cut(const std::string& name, const std::string& bytes, std::size_t least) {
    for (std::size_t size = least; size < bytes.size(); size += 1 + bytes.size() / 50) {
      put("cut-" + name, bytes.substr(0, size));
      const auto scan = read_scan(folder_.path("cut-" + name));
      ASSERT_FALSE(scan) << size << " of " << bytes.size();
      EXPECT_TRUE(contains(scan.error().message, "cut-" + name)) << scan.error().message;
      EXPECT_FALSE(contains(scan.error().message, "\n")) << scan.error().message;
    }
  }
  static std::string ply(const std::string& format, bool big) {
    const Scan scan = figure();
    std::string out = "ply\nformat " + format + " 1.0\ncomment made here\nelement vertex " +
                      std::to_string(scan.points.size()) +
                      "\nproperty uchar red\nproperty float x\nproperty double y\nproperty float z\nelement face " +
                      std::to_string(scan.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nproperty short flags\nend_header\n";
    for (const Vec3f p : scan.points) {
      add<std::uint8_t>(out, 7);
      add(out, p.x, big);
      add(out, static_cast<double>(p.y), big);
      add(out, p.z, big);
    }
    for (const ScanTriangle& t : scan.triangles) {
      add<std::uint8_t>(out, 3);
      for (const std::uint32_t corner : t) add(out, static_cast<std::int32_t>(corner), big);
      add<std::int16_t>(out, -1, big);
    }
    return out;
  }
  static std::string text_of(Vec3f p) {
    char text[80];
    std::snprintf(text, sizeof text, "%.4f %.4f %.4f", static_cast<double>(p.x), static_cast<double>(p.y),
                  static_cast<double>(p.z));
    return text;
  }
  TestFolder folder_;
};

TEST_F(Files, Ply) {
  for (const bool big : {false, true}) {
    const std::string bytes = ply(big ? "binary_big_endian" : "binary_little_endian", big);
    put("a.ply", bytes);
    expect_figure("a.ply");
    expect_refused_when_cut("a.ply", bytes, 0);
  }
  const Scan scan = figure();
  std::string text = "ply\r\nformat ascii 1.0\r\nelement vertex " + std::to_string(scan.points.size()) +
                     "\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\nelement face " +
                     std::to_string(scan.triangles.size()) +
                     "\r\nproperty list uchar uint vertex_index\r\nend_header\r\n";
  for (const Vec3f p : scan.points) text += text_of(p) + "\r\n";
  for (const ScanTriangle& t : scan.triangles)
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\r\n";
  put("b.PLY", text);
  expect_figure("b.PLY");
}

TEST_F(Files, PlyWithAFalseCornerIsRefused) {
  put("a.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
  const auto scan = read_scan(folder_.path("a.ply"));
  ASSERT_FALSE(scan);
  EXPECT_TRUE(contains(scan.error().message, "corner 3 of 3 points")) << scan.error().message;
}

TEST_F(Files, ACountThatTheFileCannotHoldTakesNoMemory) {
  put("a.ply",
      "ply\nformat binary_little_endian 1.0\nelement vertex 19000000\nproperty float x\nproperty float y\nproperty "
      "float z\nend_header\n");
  const auto scan = read_scan(folder_.path("a.ply"));
  ASSERT_FALSE(scan);
  EXPECT_TRUE(contains(scan.error().message, "does not fit")) << scan.error().message;
}

TEST_F(Files, ObjWithFacesOfFourAndNumbersFromTheEnd) {
  const Scan scan = figure();
  std::string text = "# made here\nmtllib a.mtl\no body\n";
  for (const Vec3f p : scan.points) text += "v " + text_of(p) + " 0.5 0.5 0.5\n";
  const auto count = static_cast<int>(scan.points.size());
  bool from_end = false;
  for (const ScanTriangle& t : scan.triangles) {
    text += "f";
    for (const std::uint32_t corner : t)
      text +=
          " " + std::to_string(from_end ? static_cast<int>(corner) - count : static_cast<int>(corner) + 1) + "/1/2";
    text += "\n";
    from_end = !from_end;
  }
  put("a.obj", text);
  expect_figure("a.obj");
  put("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const auto square = read_scan(folder_.path("b.obj"));
  ASSERT_TRUE(square);
  EXPECT_EQ(square->triangles, (std::vector<ScanTriangle>{{0, 1, 2}, {0, 2, 3}}));
  put("e.obj", "v -1.5e2 +0.25 1E-3\nv nan 1 2\nv 0 -nan(ind) INF\nv 0e400 1e9 0\nv .5 5. 3\n");
  const auto numbers = read_scan(folder_.path("e.obj"));
  ASSERT_TRUE(numbers);
  ASSERT_EQ(numbers->points.size(), 2U);
  EXPECT_LT(norm(numbers->points[0] - Vec3f{-150, 0.25F, 0.001F}), 1e-5F);
  EXPECT_LT(norm(numbers->points[1] - Vec3f{0.5F, 5, 3}), 1e-5F);
  for (const char* word : {"1.2.3", "+-1", "1e+-5", "e5", "1e", "--1", "0x10", "1,5"}) {
    put("f.obj", "v 0 0 " + std::string(word) + "\n");
    EXPECT_FALSE(read_scan(folder_.path("f.obj"))) << word;
  }
  put("c.obj", "v 0 0 zero\n");
  const auto broken = read_scan(folder_.path("c.obj"));
  ASSERT_FALSE(broken);
  EXPECT_TRUE(contains(broken.error().message, "line 1")) << broken.error().message;
  put("d.obj", "v 0 0 0\nf 1 2 3\n");
  EXPECT_FALSE(read_scan(folder_.path("d.obj")));
}

TEST_F(Files, Glb) {
  const Scan scan = figure();
  std::string bin;
  for (const Vec3f p : scan.points)
    for (const float x : {p.x, p.y, p.z}) add(bin, x * 0.001F);
  const std::size_t indices_at = bin.size();
  for (const ScanTriangle& t : scan.triangles)
    for (const std::uint32_t corner : t) add(bin, static_cast<std::uint16_t>(corner));
  while (bin.size() % 4 != 0) bin += '\0';
  // The node makes millimetres of metres.
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[1]}],"nodes":[{"mesh":0,"scale":[500,500,500]},)"
      R"({"children":[0],"matrix":[2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1]}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":0},"indices":1}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
      std::to_string(scan.points.size()) + R"(},{"bufferView":1,"componentType":5123,"type":"SCALAR","count":)" +
      std::to_string(3 * scan.triangles.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" +
      std::to_string(indices_at) + R"(},{"buffer":0,"byteOffset":)" + std::to_string(indices_at) +
      R"(,"byteLength":)" + std::to_string(bin.size() - indices_at) + R"(}],"buffers":[{"byteLength":)" +
      std::to_string(bin.size()) + "}]}";
  while (json.size() % 4 != 0) json += ' ';
  const auto glb = [&](const std::string& tree) {
    std::string out;
    add<std::uint32_t>(out, 0x46546C67);
    add<std::uint32_t>(out, 2);
    add(out, static_cast<std::uint32_t>(12 + 8 + tree.size() + 8 + bin.size()));
    add(out, static_cast<std::uint32_t>(tree.size()));
    add<std::uint32_t>(out, 0x4E4F534A);
    out += tree;
    add(out, static_cast<std::uint32_t>(bin.size()));
    add<std::uint32_t>(out, 0x004E4942);
    return out + bin;
  };
  put("a.glb", glb(json));
  expect_figure("a.glb");
  expect_refused_when_cut("a.glb", glb(json), 0);
  // Where a list belongs, an object.
  for (const char* key : {"scenes", "nodes", "meshes", "accessors", "bufferViews"}) {
    std::string other = json;
    const std::size_t at = other.find("\"" + std::string(key) + "\":[", key == std::string("nodes") ? 60 : 0);
    ASSERT_NE(at, std::string::npos) << key;
    other.replace(at, std::string(key).size() + 3, "\"" + std::string(key) + "\":{},\"x\":");
    other.resize((other.size() + 3) / 4 * 4, ' ');
    put("c.glb", glb(other));
    EXPECT_FALSE(read_scan(folder_.path("c.glb"))) << key;
  }
  std::string packed = json;
  packed.insert(1, R"("extensionsRequired":["KHR_draco_mesh_compression"],)");
  put("b.glb", glb(packed));
  const auto draco = read_scan(folder_.path("b.glb"));
  ASSERT_FALSE(draco);
  EXPECT_TRUE(contains(draco.error().message, "without compression")) << draco.error().message;
}

// Literal runs alone: what LZF makes of what it cannot shorten.
std::string lzf(const std::string& bytes) {
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    out += static_cast<char>(run.size() - 1);
    out += run;
  }
  return out;
}

TEST_F(Files, PcdInTextBinaryAndCompressed) {
  const Scan scan = figure();
  const std::string count = std::to_string(scan.points.size());
  const auto head = [&](const std::string& data) {
    return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH " + count +
           "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA " + data + "\n";
  };
  std::string text = head("ascii"), rows, fields;
  for (const Vec3f p : scan.points) {
    text += text_of(p) + " 7\n";
    for (const float x : {p.x, p.y, p.z}) add(rows, x);
    add<std::uint32_t>(rows, 7);
  }
  for (const Vec3f p : scan.points) add(fields, p.x);
  for (const Vec3f p : scan.points) add(fields, p.y);
  for (const Vec3f p : scan.points) add(fields, p.z);
  for (std::size_t i = 0; i < scan.points.size(); ++i) add<std::uint32_t>(fields, 7);
  put("a.pcd", text);
  expect_figure("a.pcd", false);
  put("b.pcd", head("binary") + rows);
  expect_figure("b.pcd", false);
  expect_refused_when_cut("b.pcd", head("binary") + rows, 0);
  std::string packed = head("binary_compressed");
  const std::string body = lzf(fields);
  add(packed, static_cast<std::uint32_t>(body.size()));
  add(packed, static_cast<std::uint32_t>(fields.size()));
  put("c.pcd", packed + body);
  expect_figure("c.pcd", false);
  expect_refused_when_cut("c.pcd", packed + body, 0);
}

TEST_F(Files, LzfCopiesWhatWasWritten) {
  // Four points with x = 1, y = 2, z = 3: a literal of four bytes, then a copy of twelve from four before.
  std::string body;
  for (const float x : {1.0F, 2.0F, 3.0F}) {
    body += '\3';
    add(body, x);
    body += '\xE0';  // a copy of 7 + the next + 2 bytes, at once
    body += '\3';
    body += '\3';  // from so many + 1 before
  }
  std::string bytes =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA "
      "binary_compressed\n";
  add(bytes, static_cast<std::uint32_t>(body.size()));
  add<std::uint32_t>(bytes, 48);
  put("a.pcd", bytes + body);
  const auto scan = read_scan(folder_.path("a.pcd"));
  ASSERT_TRUE(scan) << scan.error().message;
  ASSERT_EQ(scan->points.size(), 4U);
  for (const Vec3f p : scan->points) EXPECT_EQ(norm(p - Vec3f{1, 2, 3}), 0);
}

TEST_F(Files, AScanIsASourceThatGoesRoundOnce) {
  put("a.ply", ply("binary_little_endian", false));
  auto source = open_source(folder_.path("a.ply"));
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_TRUE(contains((*source)->info().name, "1700 mm")) << (*source)->info().name;
  const Intrinsics k = (*source)->info().intrinsics;
  Picture picture(k.width, k.height);
  ASSERT_TRUE((*source)->start());
  int frames = 0;
  float way_mm = 0;
  Vec3f last_mm;
  for (;;) {
    const auto frame = (*source)->next(picture.image(), 1000);
    if (!frame) {
      EXPECT_EQ(frame.error().code, ErrorCode::end_of_stream);
      break;
    }
    ASSERT_TRUE(frame->pose);
    if (frames > 0) way_mm += norm(frame->pose->position_mm - last_mm);
    last_mm = frame->pose->position_mm;
    ++frames;
  }
  EXPECT_EQ(frames, kScanFrontFrames + kScanRoundFrames + kScanEndFrames);
  EXPECT_NEAR(way_mm, 2 * std::numbers::pi_v<float> * 2400, 5);
  OpenOptions wrong;
  wrong.unit_mm = 10;
  EXPECT_FALSE(open_source(folder_.path("a.ply"), wrong));
  OpenOptions turned;
  turned.rotate_deg = 90;
  EXPECT_FALSE(open_source(folder_.path("a.ply"), turned));
}

}  // namespace
}  // namespace im2fit::hal
