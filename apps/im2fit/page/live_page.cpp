// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/page/live_page.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "apps/common/preview_input.h"
#include "engine/report/drawn_bones.h"

namespace im2fit::apps {
namespace {

constexpr auto kPicturePeriod = std::chrono::milliseconds(100);
constexpr int kPictureHeightPx = 480;

// To a tenth of a millimetre: the page needs no more.
template <class Values>
Json rounded(const Values& values) {
  Json list = Json::array();
  for (const float v : values) list.push_back(std::round(static_cast<double>(v) * 1e4) / 1e4);
  return list;
}
Json rounded(Vec3f v) {
  return rounded(std::array{v.x, v.y, v.z});
}

bool all_finite(const JointSet& joints) {
  return std::all_of(joints.position_mm.begin(), joints.position_mm.end(),
                     [](const Vec3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
}

}  // namespace

Result<std::unique_ptr<LivePage>> LivePage::open(const PageAddress& address, const std::string& body_path) {
  std::unique_ptr<LivePage> page(new LivePage);
  Board& board = page->board_;
  if (!body_path.empty())
    page->fitting_ = std::make_unique<FittingRoom>(body_path, [&board](int person) {
      board.publish("tryon", Json{{"event", "tryon"}, {"person", person}}.dump());
    });
  auto server = PageServer::open(address, board, page->fitting_.get());
  if (!server) return server.error();
  page->server_ = std::move(*server);
  return page;
}

void LivePage::begin(const Intrinsics& intrinsics, int frames_wanted) {
  intrinsics_ = intrinsics;
  Json bones = Json::array();
  for (const DrawnBone& bone : kDrawnBones)
    bones.push_back({static_cast<int>(bone.from), static_cast<int>(bone.to), static_cast<int>(bone.coloured_as)});
  board_.publish("hello", Json{{"event", "hello"},
                               {"frames_wanted", frames_wanted},
                               {"joints", kJointNames},
                               {"bones", bones},
                               {"segments", body::kSegmentNames}}
                              .dump());
}

void LivePage::see(const FrameSeen& frame) {
  if (server_->watchers() == 0) return;
  move(frame);
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < kPicturePeriod) return;
  drawn_ = now;
  draw(frame);
}

void LivePage::move(const FrameSeen& frame) {
  const EngineResult& result = frame.result;
  Json event = {{"event", "frame"}, {"frames_used", result.frames_used}, {"frames_back", result.frames_back}};
  if (result.has_joints && all_finite(result.display_joints)) {
    Json joints = Json::array();
    for (const Vec3f& p : standing_joints_m(result.display_joints, result.floor)) joints.push_back(rounded(p));
    event["joints"] = std::move(joints);
    const std::lock_guard lock(animator_mutex_);
    if (animator_) {
      const body::RigPose rig = animator_->follow(result.display_joints, result.floor);
      event["root"] = rounded(rig.root_m);
      for (const auto& rotation : rig.rotation) event["rotations"].push_back(rounded(rotation));
    }
  }
  board_.publish("frame", event.dump());
}

void LivePage::draw(const FrameSeen& frame) {
  const auto png = draw_preview(preview_of(frame, intrinsics_), kPictureHeightPx, false).png();
  if (!png) return;  // the next one may do
  const auto* bytes = reinterpret_cast<const char*>(png->data());
  board_.put("/picture.png", {"image/png", std::string(bytes, png->size())});
  board_.publish("picture", Json{{"event", "picture"}, {"number", ++pictures_}}.dump());
}

void LivePage::publish(const Json& event) {
  const std::string kind = event["event"];
  if (kind == "measured") {
    board_.put("/result.json", {"application/json", event["result"].dump(2) + "\n"});
    customer_.person = event["person"];
    if (fitting_) fitting_->welcome(customer_);
  }
  if (kind == "left") {
    const std::lock_guard lock(animator_mutex_);
    animator_.reset();  // the next person's joints are not theirs
  }
  std::string line = line_of(event);
  line.pop_back();
  board_.publish(kind, std::move(line));
}

Status LivePage::measured(const body::Avatar& avatar, std::span<const std::byte> glb) {
  auto animator = AvatarAnimator::create(avatar);
  if (!animator) return animator.error();
  board_.put("/avatar.glb",
             {"model/gltf-binary", std::string(reinterpret_cast<const char*>(glb.data()), glb.size())});
  const std::lock_guard lock(animator_mutex_);
  animator_ = *animator;
  return Ok{};
}

}  // namespace im2fit::apps
