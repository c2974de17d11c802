// SPDX-License-Identifier: Apache-2.0
#include "report/motion_recording.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "body/export/figure.h"
#include "body/person_axes.h"
#include "core/file.h"
#include "report/result_json.h"

namespace im2fit {
namespace {

constexpr std::size_t kFramesMax = 60 * 60 * 30;
constexpr double kPeriodS = 1.0 / 30;  // of a source without a clock
// The last pose is held over a longer absence; a tracker's flicker is bridged.
constexpr double kHeldAfterS = 0.5;
constexpr double kHeldUntilS = 1e-3;  // before the pose that follows an absence

bool finite(const JointSet& joints) {
  for (const Vec3f& p : joints.position_mm)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return false;
  return true;
}

}  // namespace

std::string MotionRecording::fault_of(const std::string& path) {
  const bool known = path.ends_with(".csv") || path.ends_with(".bvh") || path.ends_with(".glb");
  return known ? "" : path + ": motion is written as .csv, .bvh or .glb";
}

void MotionRecording::see(const FrameSeen& frame) {
  if (seen_++ == 0) first_ns_ = frame.info.host_ns;
  if (frames_.size() == kFramesMax) {
    ++left_out_;
    return;
  }
  const EngineResult& r = frame.result;
  Frame kept;
  kept.sequence = frame.info.sequence;
  // A clock that stands or steps back says nothing: the nominal period.
  kept.time_s = static_cast<double>(frame.info.host_ns - first_ns_) * 1e-9;
  if (!frames_.empty() && kept.time_s <= frames_.back().time_s) kept.time_s = frames_.back().time_s + kPeriodS;
  if (r.has_joints && finite(r.joints)) {
    kept.user = r.user;
    kept.view = r.view;
    kept.joints = r.joints;
    kept.inferred = r.joints_inferred;
    kept.floor = r.floor;
  }
  frames_.push_back(kept);
}

// A row a frame; of a frame in which no person is followed, the columns after `view` are empty.
std::string MotionRecording::csv() const {
  std::string text = "frame,time_s,user,view";
  for (const std::string_view name : kJointNames)
    text += fmt::format(",{0}_x_mm,{0}_y_mm,{0}_z_mm,{0}_confidence,{0}_inferred", name);
  text += '\n';
  for (const Frame& f : frames_) {
    fmt::format_to(std::back_inserter(text), "{},{:.6f},{},{}", f.sequence, f.time_s, f.user, name_of(f.view));
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vec3f& p = f.joints.position_mm[j];
      if (f.user == 0)
        text += ",,,,,";
      else
        fmt::format_to(std::back_inserter(text), ",{:.1f},{:.1f},{:.1f},{:.3f},{}", p.x, p.y, p.z,
                       f.joints.confidence[j], (f.inferred & joint_bit(j)) != 0 ? 1 : 0);
    }
    text += '\n';
  }
  return text;
}

// Who was followed for most frames; 0: no person.
int MotionRecording::main_user() const {
  std::map<int, std::size_t> counts;
  for (const Frame& f : frames_)
    if (f.user != 0) ++counts[f.user];
  int user = 0;
  for (const auto& [id, count] : counts)
    if (user == 0 || count > counts[user]) user = id;
  return user;
}

JointFlags MotionRecording::hardly_seen() const {
  const int user = main_user();
  std::size_t frames = 0;
  std::array<std::size_t, kJointCount> inferred{};
  for (const Frame& f : frames_) {
    if (user == 0 || f.user != user) continue;
    ++frames;
    for (std::size_t j = 0; j < kJointCount; ++j) inferred[j] += (f.inferred & joint_bit(j)) != 0 ? 1 : 0;
  }
  JointFlags out = 0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (2 * inferred[j] > frames) out |= joint_bit(j);
  return out;
}

Result<std::vector<body::PoseKey>> MotionRecording::keys(const body::Avatar& avatar) const {
  const int user = main_user();
  if (user == 0) return Error{ErrorCode::not_found, "no person was followed: there is no motion"};
  const auto figure = body::make_figure(avatar);
  if (!figure) return figure.error();
  std::vector<body::PoseKey> keys;
  body::PersonAxes axes;  // of the first frame, so that a person who walks moves
  double first_s = 0;
  for (const Frame& f : frames_) {
    if (f.user != user) continue;
    if (keys.empty()) {
      axes = body::PersonAxes(f.joints, f.floor);
      first_s = f.time_s;
    }
    const double time_s = f.time_s - first_s;
    if (!keys.empty() && time_s - keys.back().time_s > kHeldAfterS)
      keys.push_back({time_s - kHeldUntilS, keys.back().pose});
    keys.push_back({time_s, body::on_lower_sole(figure->skeleton, figure->floor_rest,
                                                body::pose_from_joints(figure->skeleton, axes.to_mesh(f.joints)))});
  }
  return keys;
}

Status MotionRecording::write(const std::string& path, const body::Avatar& avatar) const {
  if (path.ends_with(".csv")) return write_file_atomically(path, csv(), Readable::by_owner);
  const auto poses = keys(avatar);
  if (!poses) return Error{poses.error().code, path + ": " + poses.error().message};
  if (path.ends_with(".bvh")) return body::write_bvh(avatar, *poses, path);
  body::Avatar standing = avatar;
  standing.pose = poses->front().pose;
  return body::write_glb(standing, *poses, path);
}

}  // namespace im2fit
