// SPDX-License-Identifier: Apache-2.0
#include "train/camera/virtual_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "train/camera/camera_place.h"
#include "train/render/room.h"

namespace im2fit::lab {
namespace {

constexpr std::size_t kSubjectsKept = 32;  // bystanders that come again

enum Stream : std::uint64_t { kRoomStream = 0x5C03, kOthersStream = 0x5C06 };

hal::CameraPose camera_pose_of(const Rigid& r) {
  const auto& m = r.rotation.m;
  // Of the largest of the four, by which the others are divided.
  const std::array<float, 4> squares = {1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8],
                                        1 + m[0] + m[4] + m[8]};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const float root = std::sqrt(squares[largest]), half = 0.5F * root, by = 0.5F / root;
  switch (largest) {
    case 0:
      return {half, (m[1] + m[3]) * by, (m[2] + m[6]) * by, (m[7] - m[5]) * by, r.translation};
    case 1:
      return {(m[1] + m[3]) * by, half, (m[5] + m[7]) * by, (m[2] - m[6]) * by, r.translation};
    case 2:
      return {(m[2] + m[6]) * by, (m[5] + m[7]) * by, half, (m[3] - m[1]) * by, r.translation};
    default:
      return {(m[7] - m[5]) * by, (m[2] - m[6]) * by, (m[3] - m[1]) * by, half, r.translation};
  }
}

}  // namespace

struct VirtualScene::Impl {
  Impl(const body::BodyModel& body_model, const SceneOptions& options, const SensorOptions& sensor_options,
       const Intrinsics& k, std::uint64_t scene_seed)
      : model(body_model),
        scene(options),
        intrinsics(k),
        seed(scene_seed),
        box_margin_px(sensor_options.box_margin_px),
        room_view(k.width, k.height),
        view(k.width, k.height),
        sensor(sensor_options, k),
        mask(view.label.size()) {}

  void stage(const Subject& subject, std::span<const Vec3f> rest);
  void stage_others();
  struct Known {
    Bystander who;
    Subject subject;
    std::vector<Vec3f> rest;
  };
  const Known& known_of(const Bystander& other);
  Tailor* tailor_for(Clothing clothing, bool hair);
  void furnish();
  Standing standing() const;
  bool shown(std::size_t who) const { return who > 0 || scene.person; }
  bool moves() const;
  void draw_background(const PixelBox& box, CleanView& into);
  void ensure_background(const PixelBox& band);
  PixelBox draw_person(std::size_t who, std::uint64_t index, const PixelBox& clip);
  PixelBox silhouette_box(std::size_t who, std::uint64_t index);
  PixelBox everyones_box(std::uint64_t index);
  Rigid person_to_upright(std::size_t who, std::uint64_t index) const {
    return camera.world_to_upright() * people[who].placed(index);
  }
  Rigid world_to_sensor() const { return Rigid{mounting(scene.rotate_deg), {}} * camera.world_to_upright(); }

  const body::BodyModel& model;
  SceneOptions scene;
  Intrinsics intrinsics;
  std::uint64_t seed;
  int box_margin_px;
  std::vector<ScenePerson> people;  // [0] the main person; those past the scene's are kept for the next
  std::size_t people_count = 1;
  std::unique_ptr<Tailor> tailor;
  std::vector<Known> known;
  CameraPlace camera;
  Room room;
  std::vector<Vec3f> furniture;  // sensor axes
  std::vector<Plane> planes;     // sensor axes
  CleanView room_view, view;
  PixelBox room_done;   // where room_view has been drawn
  PixelBox person_box;  // of the frame rendered last
  PixelBox people_box;  // likewise, everyone's
  bool view_ready = false;
  MeshRaster raster;
  DepthSensor sensor;
  std::vector<Vec3f> vertices;  // scratch: sensor axes
  std::vector<std::uint8_t> mask;
};

void VirtualScene::Impl::stage(const Subject& subject, std::span<const Vec3f> rest) {
  room_done = person_box = people_box = {};
  view_ready = false;
  people_count = 1 + std::min(scene.others.size(), kBystandersMax);
  while (people.size() < people_count) people.emplace_back(model);
  PersonPlan plan{scene.pose, scene.clothing,  scene.hair,       scene.outfit_seed,
                  {},         scene.back_view, scene.sway,       scene.walk,
                  scene.turn, scene.dresser,   scene.step_round, scene.plate.height_mm};
  if (scene.yaw_deg <= kDrawnDeg) plan.yaw_deg = scene.yaw_deg;
  people[0].stage(subject, rest, plan, seed, 0, tailor_for(scene.clothing, scene.hair));
  vertices.assign(people[0].surface().begin(), people[0].surface().end());
  for (Vec3f& p : vertices) p.y += scene.plate.height_mm;
  camera = place_camera(scene, vertices, intrinsics, seed);
  stage_others();
  furnish();
}

Tailor* VirtualScene::Impl::tailor_for(Clothing clothing, bool hair) {
  if (clothing == Clothing::none && !hair) return nullptr;
  if (tailor == nullptr) tailor = std::make_unique<Tailor>(model);
  return tailor.get();
}

const VirtualScene::Impl::Known& VirtualScene::Impl::known_of(const Bystander& other) {
  for (const Known& k : known)
    if (k.who.family == other.family && k.who.subject_seed == other.subject_seed &&
        k.who.subject_index == other.subject_index)
      return k;
  if (known.size() >= kSubjectsKept) known.erase(known.begin());
  Known& added = known.emplace_back();
  added.who = other;
  added.subject = draw_subject(model, other.family, other.subject_seed, other.subject_index, added.rest);
  return added;
}

void VirtualScene::Impl::stage_others() {
  for (std::size_t who = 1; who < people_count; ++who) {
    const Bystander& other = scene.others[who - 1];
    const bool sways = scene.sway && !other.still;
    PersonPlan plan{other.pose, other.clothing, other.hair, 0, {}, false, sways, other.path, {}, {}, {}};
    if (other.yaw_deg <= kDrawnDeg) plan.yaw_deg = other.yaw_deg;
    const std::uint64_t own_seed = Rng::for_item(seed, kOthersStream, who).next();
    const Known& is = known_of(other);
    people[who].stage(is.subject, is.rest, plan, own_seed, who, tailor_for(other.clothing, other.hair));
  }
}

bool VirtualScene::Impl::moves() const {
  for (std::size_t who = 0; who < people_count; ++who)
    if (shown(who) && people[who].moves()) return true;
  return false;
}

Standing VirtualScene::Impl::standing() const {
  Standing out;
  out.half_width_mm = 300;
  out.behind_mm = 150;
  out.legs_left_mm = out.legs_back_mm = 1e9F;
  out.legs_right_mm = -1e9F;
  for (const Vec3f& p : people[0].surface()) {
    out.half_width_mm = std::max(out.half_width_mm, std::fabs(p.x));
    out.behind_mm = std::max(out.behind_mm, -p.z);
    if (p.y > kLegsTopMm) continue;
    out.legs_left_mm = std::min(out.legs_left_mm, p.x);
    out.legs_right_mm = std::max(out.legs_right_mm, p.x);
    out.legs_back_mm = std::min(out.legs_back_mm, p.z);
  }
  return out;
}

void VirtualScene::Impl::furnish() {
  Rng rng = Rng::for_item(seed, kRoomStream, 0);
  Standing place = standing();
  WorldMesh seats;
  for (std::size_t who = 0; who < people_count; ++who) {
    const Seat* seat = people[who].seat();
    if (seat == nullptr || !shown(who)) continue;
    Rng seat_rng = Rng::for_item(seed, kRoomStream, 1 + who);
    draw_seat(*seat, seat_rng, seats);
    if (who > 0) continue;
    for (const Vec3f& p : seats.vertices) {
      place.half_width_mm = std::max(place.half_width_mm, std::fabs(p.x));
      place.behind_mm = std::max(place.behind_mm, -p.z);
    }
  }
  constexpr int kSpots = 8;  // of a path
  const auto keep_free = [&](const FloorPath& path) {
    for (int i = 0; i <= kSpots; ++i) {
      const float t = static_cast<float>(i) / kSpots;
      place.others.push_back({path.from_x_mm + t * (path.to_x_mm - path.from_x_mm), 0,
                              path.from_z_mm + t * (path.to_z_mm - path.from_z_mm)});
    }
  };
  for (std::size_t who = 1; who < people_count; ++who) {
    const FloorPath& path = scene.others[who - 1].path;
    keep_free(path.frame_count > 0 ? path
                                   : FloorPath{path.from_x_mm, path.from_z_mm, path.from_x_mm, path.from_z_mm});
  }
  if (scene.walk.frame_count > 0) keep_free(scene.walk);
  const float drawn = static_cast<float>(rng.uniform(450, 2500));
  RoomOptions options{scene.floor,
                      scene.wall,
                      scene.wall_distance_mm > 0 ? scene.wall_distance_mm : drawn,
                      scene.furniture_count,
                      scene.furniture_touching,
                      scene.decoy_count,
                      !scene.person};
  // A drawn wall stands behind everyone, whatever the pose; a given one is taken at its word.
  if (scene.wall_distance_mm <= 0) {
    options.wall_distance_mm = std::max(drawn, place.behind_mm + 150);
    // Walls are turned by a few degrees: a tenth of the sideways distance on top.
    for (const Vec3f& spot : place.others)
      options.wall_distance_mm =
          std::max(options.wall_distance_mm, kOthersClearMm - spot.z + 0.1F * std::fabs(spot.x));
  }
  room = draw_room_plan(options, place, rng);
  append(seats, room.furniture);
  const FloorPlate& plate = scene.plate;
  if (plate.height_mm > 0)
    add_box(room.furniture, {0, plate.height_mm / 2, 0}, {plate.side_mm, plate.height_mm, plate.side_mm});

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

void VirtualScene::Impl::draw_background(const PixelBox& box, CleanView& into) {
  draw_room(planes, intrinsics, box, into);
  static constexpr std::array<std::uint8_t, 1> kLabels = {kFurniture};
  raster.draw(furniture, room.furniture.triangles, kLabels, true, intrinsics, box, into);
}

// Some rows more than requested: the next frame's box will have moved a little.
void VirtualScene::Impl::ensure_background(const PixelBox& band) {
  if (!room_done.empty() && band.v0 >= room_done.v0 && band.v1 <= room_done.v1) return;
  constexpr int kSpareRows = 16;
  const PixelBox more = {0, band.v0 - kSpareRows, intrinsics.width, band.v1 + kSpareRows};
  room_done = bounding(room_done, intersect(whole(intrinsics.width, intrinsics.height), more));
  draw_background(room_done, room_view);
}

PixelBox VirtualScene::Impl::silhouette_box(std::size_t who, std::uint64_t index) {
  if (!shown(who)) return {};
  people[who].choose_frame(index);
  const Rigid to_sensor = world_to_sensor() * people[who].placed(index);
  float u0 = 1e9F, v0 = 1e9F, u1 = -1e9F, v1 = -1e9F;
  for (const Vec3f& own : people[who].surface()) {
    const Vec3f p = to_sensor(own);
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

PixelBox VirtualScene::Impl::everyones_box(std::uint64_t index) {
  PixelBox box;
  for (std::size_t who = 0; who < people_count; ++who) box = bounding(box, silhouette_box(who, index));
  return box;
}

PixelBox VirtualScene::Impl::draw_person(std::size_t who, std::uint64_t index, const PixelBox& clip) {
  ScenePerson& person = people[who];
  person.choose_frame(index);
  const Rigid to_sensor = world_to_sensor() * person.placed(index);
  const auto surface = person.surface();
  vertices.resize(surface.size());
  for (std::size_t i = 0; i < surface.size(); ++i) vertices[i] = to_sensor(surface[i]);
  PixelBox box = raster.draw(vertices, person.closed_triangles(), person.labels(), true, intrinsics, clip, view);
  if (!person.open_triangles().empty()) {
    const std::array<std::uint8_t, 1> label = {label_of(who, false)};
    box = bounding(box, raster.draw(vertices, person.open_triangles(), label, false, intrinsics, clip, view));
  }
  return box;
}

VirtualScene::VirtualScene(const body::BodyModel& model, const Subject& subject, const SceneOptions& scene,
                           const SensorOptions& sensor, const Intrinsics& intrinsics, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(model, scene, sensor, intrinsics, seed)) {
  impl_->stage(subject, {});
}
VirtualScene::~VirtualScene() = default;
VirtualScene::VirtualScene(VirtualScene&&) noexcept = default;

void VirtualScene::restage(const Subject& subject, const SceneOptions& scene, std::uint64_t seed) {
  impl_->scene = scene;
  impl_->seed = seed;
  impl_->stage(subject, {});
}

void VirtualScene::restage(const Subject& subject, const SceneOptions& scene, const SensorOptions& sensor,
                           std::uint64_t seed, std::span<const Vec3f> rest) {
  impl_->sensor.change(sensor);
  impl_->box_margin_px = sensor.box_margin_px;
  impl_->scene = scene;
  impl_->seed = seed;
  impl_->stage(subject, rest);
}

void VirtualScene::render(std::uint64_t index, DepthImage out) {
  Impl& s = *impl_;
  const PixelBox frame = whole(s.intrinsics.width, s.intrinsics.height);
  const bool boxed = s.box_margin_px >= 0;
  PixelBox wanted = frame;
  if (boxed) {
    wanted = intersect(frame, grown(s.silhouette_box(0, index), s.box_margin_px));
    for (int v = 0; v < out.height; ++v) std::fill_n(out.row(v), out.width, std::uint16_t{0});
    std::fill(s.mask.begin(), s.mask.end(), std::uint8_t{0});
  }
  // Rows of the box whole, and some above and below: the shadow needs the row, the edges the rows beside it.
  const PixelBox band = intersect(frame, {0, wanted.v0 - 4, s.intrinsics.width, wanted.v1 + 4});
  if (!s.view_ready || s.moves() || boxed) {
    PixelBox changed = band;
    if (!boxed && !s.moves()) {  // it is drawn once
      s.draw_background(band, s.view);
    } else {
      s.ensure_background(band);
      if (s.view_ready && !boxed) {
        changed = intersect(frame, grown(bounding(s.people_box, s.everyones_box(index)), 2));
        changed = intersect(frame, {0, changed.v0 - 4, s.intrinsics.width, changed.v1 + 4});
      }
      copy_box(s.room_view, changed, s.view);
    }
    s.person_box = s.shown(0) ? s.draw_person(0, index, band) : PixelBox{};
    s.people_box = s.person_box;
    for (std::size_t who = 1; who < s.people_count; ++who)
      s.people_box = bounding(s.people_box, s.draw_person(who, index, band));
    s.sensor.prepare(s.view, boxed ? wanted : changed);
    s.view_ready = true;
  }
  s.sensor.expose(s.view, wanted, s.seed, index, out, s.mask.data());
}

void VirtualScene::render_part(std::uint64_t index, const PixelBox& box, DepthImage out) {
  impl_->sensor.expose(impl_->view, box, impl_->seed, index, out, nullptr);
}

const Intrinsics& VirtualScene::intrinsics() const {
  return impl_->intrinsics;
}

std::size_t VirtualScene::people_count() const {
  return impl_->people_count;
}

JointSet VirtualScene::joints(std::uint64_t index, std::size_t who) const {
  if (who >= impl_->people_count || !impl_->shown(who)) return {};
  impl_->people[who].choose_frame(index);
  const Rigid to_upright = impl_->person_to_upright(who, index);
  JointSet out = impl_->people[who].joints();
  for (Vec3f& p : out.position_mm) p = to_upright(p);
  return out;
}

hal::CameraPose VirtualScene::camera_pose(std::uint64_t index) const {
  if (!impl_->scene.step_round.camera) return {};
  const Rigid to_camera = impl_->camera.world_to_upright();
  const auto inverse = [](const Rigid& r) {
    const body::Mat3f back = transpose(r.rotation);
    return Rigid{back, back * (r.translation * -1.0F)};
  };
  return camera_pose_of(to_camera * inverse(impl_->people[0].carried(index)) * inverse(to_camera));
}

FloorPlane VirtualScene::floor() const {
  return {true, impl_->camera.rotation() * kAxisY, impl_->camera.height_mm};
}

void VirtualScene::person_mesh(std::uint64_t index, std::span<Vec3f> out, std::size_t who) const {
  if (who >= impl_->people_count) return;
  impl_->people[who].choose_frame(index);
  const Rigid to_upright = impl_->person_to_upright(who, index);
  const auto& body = impl_->people[who].body();
  for (std::size_t i = 0; i < body.size(); ++i) out[i] = to_upright(body[i]);
}

VirtualScene::Surface VirtualScene::person_surface(std::uint64_t index, std::size_t who) const {
  if (who >= impl_->people_count) return {};
  ScenePerson& person = impl_->people[who];
  person.choose_frame(index);
  const Rigid to_upright = impl_->person_to_upright(who, index);
  Surface out;
  for (const Vec3f& p : person.surface()) out.vertices.push_back(to_upright(p));
  out.triangles.assign(person.closed_triangles().begin(), person.closed_triangles().end());
  out.triangles.insert(out.triangles.end(), person.open_triangles().begin(), person.open_triangles().end());
  return out;
}

void VirtualScene::person_mask(MaskImage out, std::size_t who) const {
  const std::uint8_t wanted = mask_value(label_of(who, false));
  const std::uint8_t mixed = mixed_mask_value(label_of(who, false));
  for (int v = 0; v < out.height; ++v) {
    const std::uint8_t* from = &impl_->mask[impl_->view.at(0, v)];
    for (int u = 0; u < out.width; ++u) out.row(v)[u] = from[u] == wanted || from[u] == mixed ? 255 : 0;
  }
}

void VirtualScene::mixed_mask(MaskImage out) const {
  const std::uint8_t mixed = mixed_mask_value(label_of(0, false));
  for (int v = 0; v < out.height; ++v) {
    const std::uint8_t* from = &impl_->mask[impl_->view.at(0, v)];
    for (int u = 0; u < out.width; ++u) out.row(v)[u] = from[u] == mixed ? 255 : 0;
  }
}

PixelBox VirtualScene::person_box() const {
  return impl_->person_box;
}
float VirtualScene::distance_mm() const {
  return impl_->camera.distance_mm;
}

}  // namespace im2fit::lab
