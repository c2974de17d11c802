// SPDX-License-Identifier: Apache-2.0
#include "synth/virtual_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "synth/room.h"

namespace im2fit::synth {
namespace {

using body::Mat3f;

constexpr Vec3f kX{1, 0, 0};
constexpr Vec3f kY{0, 1, 0};
constexpr Vec3f kZ{0, 0, 1};
constexpr float kDrawn = 1e8F;            // angles above this are to be drawn
constexpr float kFitMarginShare = 0.02F;  // of the picture's width, free at every border
constexpr double kFramesPerSecond = 30;

enum Stream : std::uint64_t {
  kSceneStream = 0x5C01,
  kPoseStream = 0x5C02,
  kRoomStream = 0x5C03,
  kSwayStream = 0x5C04
};

struct Rigid {
  Mat3f rotation;
  Vec3f translation;
  Vec3f operator()(Vec3f p) const { return rotation * p + translation; }
};
Rigid operator*(const Rigid& a, const Rigid& b) {
  return {a.rotation * b.rotation, a(b.translation)};
}

Mat3f mounting(int rotate_deg) {
  switch (rotate_deg) {
    case 90:
      return {{0, 1, 0, -1, 0, 0, 0, 0, 1}};
    case 180:
      return {{-1, 0, 0, 0, -1, 0, 0, 0, 1}};
    case 270:
      return {{0, -1, 0, 1, 0, 0, 0, 0, 1}};
    default:
      return {};
  }
}

// World (y up, z towards the camera, origin on the floor under the person) to the upright camera.
struct CameraPlace {
  float distance_mm = 2300, height_mm = 1000, aside_mm = 0, pitch_deg = 0, roll_deg = 0;
  Mat3f rotation() const {
    const Mat3f level{{1, 0, 0, 0, -1, 0, 0, 0, -1}};
    return body::rotation_about(kZ, roll_deg) * body::rotation_about(kX, pitch_deg) * level;
  }
  Rigid world_to_upright() const {
    const Mat3f r = rotation();
    return {r, r * Vec3f{-aside_mm, -height_mm, -distance_mm}};
  }
};

// Slow sway about the ankles and a little turning: sums of three incommensurate waves, 0.1..0.6 Hz, so that any
// frame can be had without the ones before it. Sizes: 3.5 mm sideways and 5 mm back and forth at head height.
struct Sway {
  struct Wave {
    float hertz = 0, phase = 0, size = 0;
  };
  std::array<std::array<Wave, 3>, 3> waves;  // lean forwards, lean sideways, turn (degrees)

  explicit Sway(std::uint64_t seed) {
    Rng rng = Rng::for_item(seed, kSwayStream, 0);
    constexpr std::array<double, 3> kSize = {0.15, 0.10, 0.25};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        waves[i][j] = {static_cast<float>(rng.uniform(0.1, 0.6)), static_cast<float>(rng.uniform(0, 1)),
                       static_cast<float>(kSize[i] * rng.uniform(0.5, 1.0))};
  }
  float value(std::size_t axis, double seconds) const {
    double sum = 0;
    for (const Wave& w : waves[axis])
      sum += static_cast<double>(w.size) *
             std::sin(2 * std::numbers::pi * (static_cast<double>(w.hertz) * seconds + static_cast<double>(w.phase)));
    return static_cast<float>(sum);
  }
  Rigid at(std::uint64_t frame) const {
    const double t = static_cast<double>(frame) / kFramesPerSecond;
    return {body::rotation_about(kX, value(0, t)) * body::rotation_about(kZ, value(1, t)) *
                body::rotation_about(kY, value(2, t)),
            {}};
  }
};

// Crown, sides and back of the head; the face stays bare. By rest mesh and head bone.
std::vector<std::uint8_t> person_labels(const body::BodyModel& model, std::span<const Vec3f> rest,
                                        const body::Skeleton& skeleton) {
  const Vec3f low = skeleton.head[static_cast<std::size_t>(body::Segment::head)];
  float crown = low.y;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i)
    crown = std::max(crown, rest[i].y);
  const float height = crown - low.y;
  const auto hair = [&](Vec3f p) {
    const float up = (p.y - low.y) / height;
    const float back = (low.z - p.z) / height;
    return up > 0.78F || (up > 0.25F && back > -0.12F && up - 0.5F * (0.3F - back) > 0.1F);
  };
  std::vector<std::uint8_t> labels;
  labels.reserve(model.body_triangles().size());
  for (const Triangle& t : model.body_triangles()) {
    const Vec3f centre = (rest[static_cast<std::size_t>(t[0])] + rest[static_cast<std::size_t>(t[1])] +
                          rest[static_cast<std::size_t>(t[2])]) *
                         (1.0F / 3);
    labels.push_back(hair(centre) ? kHair : kPerson);
  }
  return labels;
}

}  // namespace

Intrinsics kinect_intrinsics(int width, int height) {
  const float f = kKinectFocalPx * static_cast<float>(width) / 640;
  return {width, height, f, f, (static_cast<float>(width) - 1) / 2, (static_cast<float>(height) - 1) / 2};
}

Intrinsics upright_intrinsics(const Intrinsics& k, int rotate_deg) {
  const float right = static_cast<float>(k.width - 1), bottom = static_cast<float>(k.height - 1);
  switch (rotate_deg) {
    case 90:
      return {k.height, k.width, k.fy, k.fx, bottom - k.cy, k.cx};
    case 180:
      return {k.width, k.height, k.fx, k.fy, right - k.cx, bottom - k.cy};
    case 270:
      return {k.height, k.width, k.fy, k.fx, k.cy, right - k.cx};
    default:
      return k;
  }
}

Vec3f upright_to_sensor(Vec3f p, int rotate_deg) {
  return mounting(rotate_deg) * p;
}

struct VirtualScene::Impl {
  Impl(const body::BodyModel& body_model, const SceneOptions& options, const SensorOptions& sensor_options,
       const Intrinsics& k, std::uint64_t scene_seed)
      : model(body_model),
        scene(options),
        intrinsics(k),
        seed(scene_seed),
        box_margin_px(sensor_options.box_margin_px),
        sway(scene_seed),
        room_view(k.width, k.height),
        view(k.width, k.height),
        sensor(sensor_options, k),
        mask(view.label.size()) {}

  void stage(const Subject& subject);
  void pose_person(const Subject& subject);
  void place_camera();
  void furnish();
  bool fits() const;
  void draw_background(const PixelBox& box);
  void ensure_background(const PixelBox& band);
  PixelBox draw_person(std::uint64_t index, const PixelBox& clip);
  PixelBox silhouette_box(std::uint64_t index) const;
  Rigid person_to_world(std::uint64_t index) const { return scene.sway ? sway.at(index) : Rigid{}; }
  Rigid world_to_sensor() const { return Rigid{mounting(scene.rotate_deg), {}} * camera.world_to_upright(); }

  const body::BodyModel& model;
  SceneOptions scene;
  Intrinsics intrinsics;
  std::uint64_t seed;
  int box_margin_px;
  Sway sway;
  std::vector<Vec3f> person;  // body vertices, world axes, without sway
  std::vector<std::uint8_t> labels;
  JointSet joints;  // world axes, without sway
  CameraPlace camera;
  Room room;
  std::vector<Vec3f> furniture;  // sensor axes
  std::vector<Plane> planes;     // sensor axes
  CleanView room_view, view;
  PixelBox room_done;   // where room_view has been drawn
  PixelBox person_box;  // of the frame rendered last
  bool view_ready = false;
  MeshRaster raster;
  DepthSensor sensor;
  std::vector<Vec3f> vertices;  // scratch: sensor axes
  std::vector<std::uint8_t> mask;
};

void VirtualScene::Impl::stage(const Subject& subject) {
  room_done = person_box = {};
  view_ready = false;
  pose_person(subject);
  place_camera();
  furnish();
}

void VirtualScene::Impl::pose_person(const Subject& subject) {
  Rng rng = Rng::for_item(seed, kPoseStream, 0);
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  morph_subject(model, subject, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model, rest);
  const float stature_m = subject.truth[measurement_index(Measurement::stature)] / 1000;
  const float mass_kg = subject.truth[measurement_index(Measurement::weight)];
  const float bmi = stature_m > 0 ? mass_kg / (stature_m * stature_m) : 24;
  const body::Pose pose = draw_pose(skeleton, scene.pose, rng, arm_spread_deg(bmi));
  std::vector<Vec3f> posed(rest.size());
  body::skin(model, rest, skeleton, pose, posed);
  joints = body::joints_of(model, posed);
  labels = person_labels(model, rest, skeleton);

  posed.resize(static_cast<std::size_t>(model.body_vertex_count()));
  const float drawn_yaw = draw_yaw_deg(scene.pose, rng);
  const float yaw = (scene.yaw_deg > kDrawn ? drawn_yaw : scene.yaw_deg) + (scene.back_view ? 180.0F : 0.0F);
  const Mat3f turn = body::rotation_about(kY, yaw);
  float lowest = 1e9F;
  for (const Vec3f& p : posed) lowest = std::min(lowest, p.y);
  const Vec3f hips = (joints[Joint::LH] + joints[Joint::RH]) * 0.5F;
  const auto to_world = [&](Vec3f p) { return turn * Vec3f{p.x - hips.x, p.y - lowest, p.z - hips.z}; };
  for (Vec3f& p : posed) p = to_world(p);
  for (Vec3f& p : joints.position_mm) p = to_world(p);
  person = std::move(posed);
}

// The whole person inside the picture with a margin, at every sway.
bool VirtualScene::Impl::fits() const {
  const Rigid to_sensor = world_to_sensor();
  const float margin = kFitMarginShare * static_cast<float>(intrinsics.width);
  for (const Vec3f& world : person) {
    const Vec3f p = to_sensor(world);
    if (p.z < kNearMm) return false;
    const float u = p.x * intrinsics.fx / p.z + intrinsics.cx;
    const float v = p.y * intrinsics.fy / p.z + intrinsics.cy;
    if (u < margin || v < margin || u > static_cast<float>(intrinsics.width - 1) - margin ||
        v > static_cast<float>(intrinsics.height - 1) - margin)
      return false;
  }
  return true;
}

void VirtualScene::Impl::place_camera() {
  Rng rng = Rng::for_item(seed, kSceneStream, 0);
  const bool portrait = scene.rotate_deg == 90 || scene.rotate_deg == 270;
  const auto draw = [&](double low, double high) { return static_cast<float>(rng.uniform(low, high)); };
  const float distance = portrait ? draw(2000, 2600) : draw(2400, 3200);
  const float height = draw(800, 1200);
  const float aside = std::clamp(static_cast<float>(rng.normal(0, 80)), -160.0F, 160.0F);
  const float aim = static_cast<float>(rng.normal(0, 1.2));
  camera.roll_deg = static_cast<float>(rng.normal(0, 0.7));
  camera.aside_mm = aside;
  camera.height_mm = scene.camera_height_mm > 0 ? scene.camera_height_mm : height;
  camera.distance_mm = scene.distance_mm > 0 ? scene.distance_mm : distance;
  float top = 0;
  for (const Vec3f& p : person) top = std::max(top, p.y);
  const auto aim_camera = [&] {
    const float middle = std::atan2(camera.height_mm - top / 2, camera.distance_mm) * 180 / std::numbers::pi_v<float>;
    camera.pitch_deg = scene.pitch_deg > kDrawn ? middle + aim : scene.pitch_deg;
  };
  aim_camera();
  constexpr float kDistanceMaxMm = 4500;
  while (scene.distance_mm <= 0 && camera.distance_mm < kDistanceMaxMm && !fits()) {
    camera.distance_mm *= 1.03F;
    aim_camera();
  }
}

void VirtualScene::Impl::furnish() {
  Rng rng = Rng::for_item(seed, kRoomStream, 0);
  Standing standing{300, 150};
  for (const Vec3f& p : person) {
    standing.half_width_mm = std::max(standing.half_width_mm, std::fabs(p.x));
    standing.behind_mm = std::max(standing.behind_mm, -p.z);
  }
  const float drawn = static_cast<float>(rng.uniform(450, 2500));
  RoomOptions options{scene.floor, scene.wall, scene.wall_distance_mm > 0 ? scene.wall_distance_mm : drawn,
                      scene.furniture_count};
  // A drawn wall stands behind the person, whatever the pose; a given one is taken at its word.
  if (scene.wall_distance_mm <= 0) options.wall_distance_mm = std::max(drawn, standing.behind_mm + 150);
  room = draw_room_plan(options, standing, rng);

  const Rigid to_sensor = world_to_sensor();
  planes.clear();
  furniture.clear();
  for (const Wall& wall : room.walls) {
    // n.x = o in the world is (Rn).y = o + (Rn).t for y = Rx + t.
    const Vec3f normal = to_sensor.rotation * wall.normal;
    const float distance = wall.offset_mm + dot(normal, to_sensor.translation);
    if (distance > 0) planes.push_back({normal, distance});
  }
  furniture.reserve(room.furniture.vertices.size());
  for (const Vec3f& p : room.furniture.vertices) furniture.push_back(to_sensor(p));
}

void VirtualScene::Impl::draw_background(const PixelBox& box) {
  draw_room(planes, intrinsics, box, room_view);
  static constexpr std::array<std::uint8_t, 1> kLabels = {kFurniture};
  raster.draw(furniture, room.furniture.triangles, kLabels, true, intrinsics, box, room_view);
}

// Some rows more than asked for: the next frame's box will have moved a little.
void VirtualScene::Impl::ensure_background(const PixelBox& band) {
  if (!room_done.empty() && band.v0 >= room_done.v0 && band.v1 <= room_done.v1) return;
  constexpr int kSpareRows = 16;
  const PixelBox more = {0, band.v0 - kSpareRows, intrinsics.width, band.v1 + kSpareRows};
  room_done = bounding(room_done, intersect(whole(intrinsics.width, intrinsics.height), more));
  draw_background(room_done);
}

PixelBox VirtualScene::Impl::silhouette_box(std::uint64_t index) const {
  const Rigid to_sensor = world_to_sensor() * person_to_world(index);
  float u0 = 1e9F, v0 = 1e9F, u1 = -1e9F, v1 = -1e9F;
  for (const Vec3f& world : person) {
    const Vec3f p = to_sensor(world);
    if (p.z < kNearMm) continue;
    const float u = p.x * intrinsics.fx / p.z + intrinsics.cx;
    const float v = p.y * intrinsics.fy / p.z + intrinsics.cy;
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
  const PixelBox frame = whole(intrinsics.width, intrinsics.height);
  if (u0 > u1) return {};
  const auto inside = [](float x) { return static_cast<int>(std::clamp(x, -1.0F, 4096.0F)); };
  return intersect(frame, {inside(u0), inside(v0), inside(u1) + 2, inside(v1) + 2});
}

PixelBox VirtualScene::Impl::draw_person(std::uint64_t index, const PixelBox& clip) {
  const Rigid to_sensor = world_to_sensor() * person_to_world(index);
  vertices.resize(person.size());
  for (std::size_t i = 0; i < person.size(); ++i) vertices[i] = to_sensor(person[i]);
  return raster.draw(vertices, model.body_triangles(), labels, true, intrinsics, clip, view);
}

VirtualScene::VirtualScene(const body::BodyModel& model, const Subject& subject, const SceneOptions& scene,
                           const SensorOptions& sensor, const Intrinsics& intrinsics, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(model, scene, sensor, intrinsics, seed)) {
  impl_->stage(subject);
}
VirtualScene::~VirtualScene() = default;
VirtualScene::VirtualScene(VirtualScene&&) noexcept = default;

void VirtualScene::restage(const Subject& subject, const SceneOptions& scene, std::uint64_t seed) {
  impl_->scene = scene;
  impl_->seed = seed;
  impl_->sway = Sway(seed);
  impl_->stage(subject);
}

void VirtualScene::render(std::uint64_t index, DepthImage out) {
  Impl& s = *impl_;
  const PixelBox frame = whole(s.intrinsics.width, s.intrinsics.height);
  const bool boxed = s.box_margin_px >= 0;
  PixelBox wanted = frame;
  if (boxed) {
    wanted = intersect(frame, grown(s.silhouette_box(index), s.box_margin_px));
    for (int v = 0; v < out.height; ++v) std::fill_n(out.row(v), out.width, std::uint16_t{0});
    std::fill(s.mask.begin(), s.mask.end(), std::uint8_t{0});
  }
  // Rows of the box whole, and some above and below: the shadow looks along the row, the edges across it.
  const PixelBox band = intersect(frame, {0, wanted.v0 - 4, s.intrinsics.width, wanted.v1 + 4});
  if (!s.view_ready || s.scene.sway || boxed) {
    s.ensure_background(band);
    PixelBox changed = band;
    if (s.view_ready && !boxed) {
      changed = intersect(frame, grown(bounding(s.person_box, s.silhouette_box(index)), 2));
      changed = intersect(frame, {0, changed.v0 - 4, s.intrinsics.width, changed.v1 + 4});
    }
    copy_box(s.room_view, changed, s.view);
    s.person_box = s.draw_person(index, band);
    s.sensor.prepare(s.view, boxed ? wanted : changed);
    s.view_ready = true;
  }
  s.sensor.expose(s.view, wanted, s.seed, index, out, s.mask.data());
}

const Intrinsics& VirtualScene::intrinsics() const {
  return impl_->intrinsics;
}

JointSet VirtualScene::joints(std::uint64_t index) const {
  const Rigid to_upright = impl_->camera.world_to_upright() * impl_->person_to_world(index);
  JointSet out = impl_->joints;
  for (Vec3f& p : out.position_mm) p = to_upright(p);
  return out;
}

FloorPlane VirtualScene::floor() const {
  return {true, impl_->camera.rotation() * kY, impl_->camera.height_mm};
}

void VirtualScene::person_mesh(std::uint64_t index, std::span<Vec3f> out) const {
  const Rigid to_upright = impl_->camera.world_to_upright() * impl_->person_to_world(index);
  for (std::size_t i = 0; i < impl_->person.size(); ++i) out[i] = to_upright(impl_->person[i]);
}

void VirtualScene::person_mask(MaskImage out) const {
  for (int v = 0; v < out.height; ++v) std::copy_n(&impl_->mask[impl_->view.at(0, v)], out.width, out.row(v));
}

PixelBox VirtualScene::person_box() const {
  return impl_->person_box;
}
float VirtualScene::distance_mm() const {
  return impl_->camera.distance_mm;
}

}  // namespace im2fit::synth
