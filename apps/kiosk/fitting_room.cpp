// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/fitting_room.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "body/export/export.h"
#include "garment/drape/outfit.h"
#include "garment/drape/wear.h"
#include "person/dressing.h"

namespace im2fit::apps {
namespace {

constexpr float kEaseMapTightStrain = 0.08F;  // jersey is cut to be worn at less
constexpr float kEaseMapLooseMm = 40;
using Colour = std::array<float, 3>;
// One hue from dark to light, linear, and none of the verdicts' colours: nothing on a person's body is a warning.
// web/tryon.css has them in sRGB.
constexpr Colour kTight = {0.105F, 0.023F, 0.156F}, kGood = {0.451F, 0.283F, 0.552F},
                 kLoose = {0.880F, 0.831F, 0.905F};
constexpr float kLyingMm = 10;  // off the skin: what lies on it has its own thickness and small folds
// About 80 mm: cloth is stretched most at a point, as over a breast, and what a size does is told by the region.
constexpr int kSmoothPasses = 60;

Colour mixed(const Colour& a, const Colour& b, float share) {
  Colour c{};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = a[i] + (b[i] - a[i]) * share;
  return c;
}

// A linear colour a vertex of the garment: dark where the cloth around is stretched by kEaseMapTightStrain or more,
// between where it lies on the body unstretched, light where it stands kEaseMapLooseMm or more off the skin.
std::vector<Colour> ease_map(const body::Outfit& outfit, std::size_t index) {
  const body::Cloth& cloth = outfit.cloth(index);
  const auto& constraints = cloth.constraints();
  const std::size_t count = cloth.mesh().vertex_count();
  std::vector<float> ease(count, 0), sum(count), edges(count, 0);  // -1 tight, 0, 1 loose
  for (std::size_t e = 0; e < constraints.edges.size(); ++e) {
    const auto a = static_cast<std::size_t>(constraints.edges[e][0]),
               b = static_cast<std::size_t>(constraints.edges[e][1]);
    const float strain = norm(cloth.position(a) - cloth.position(b)) / constraints.edge_mm[e] - 1;
    for (const std::size_t v : {a, b}) {
      ease[v] += strain;
      edges[v] += 1;
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    const float strain = edges[v] > 0 ? ease[v] / edges[v] : 0;
    const body::SkinPlace& place = cloth.contacts()[v];
    float off = kEaseMapLooseMm;
    if (place.triangle >= 0)
      off = dot(cloth.position(v) - outfit.skin().at(place, true), outfit.skin().facing(place, true));
    ease[v] = std::clamp((off - kLyingMm) / (kEaseMapLooseMm - kLyingMm), 0.0F, 1.0F) -
              std::clamp(strain / kEaseMapTightStrain, 0.0F, 1.0F);
  }
  for (int pass = 0; pass < kSmoothPasses; ++pass) {
    std::fill(sum.begin(), sum.end(), 0.0F);
    for (const auto& edge : constraints.edges) {
      sum[static_cast<std::size_t>(edge[0])] += ease[static_cast<std::size_t>(edge[1])];
      sum[static_cast<std::size_t>(edge[1])] += ease[static_cast<std::size_t>(edge[0])];
    }
    for (std::size_t v = 0; v < count; ++v)
      if (edges[v] > 0) ease[v] = (ease[v] + sum[v] / edges[v]) / 2;
  }
  std::vector<Colour> colours;
  colours.reserve(count);
  for (const float e : ease) colours.push_back(e < 0 ? mixed(kGood, kTight, -e) : mixed(kGood, kLoose, e));
  return colours;
}

constexpr unsigned kOk = 200, kAccepted = 202, kBadRequest = 400, kNotFound = 404, kFailed = 500;

Error refused(std::string why) {
  return Error{ErrorCode::invalid_argument, std::move(why)};
}

}  // namespace

FittingRoom::FittingRoom(std::string body_path, std::function<void(const std::string&)> ready,
                         std::function<void(std::uint32_t)> moved)
    : body_path_(std::move(body_path)),
      ready_(std::move(ready)),
      live_(std::move(moved)),
      thread_([this] { work(); }) {}

FittingRoom::~FittingRoom() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  news_.notify_all();
  thread_.join();
}

void FittingRoom::welcome(Customer customer) {
  const std::lock_guard lock(mutex_);
  customer_ = std::move(customer);
  ++visit_;
  waiting_.reset();
  made_.clear();
  live_.wear("", nullptr);
}

void FittingRoom::forget() {
  const std::lock_guard lock(mutex_);
  customer_.reset();
  ++visit_;
  waiting_.reset();
  made_.clear();
  live_.wear("", nullptr);
}

// Words of a customer alone: the fits say which garments and sizes there are.
Result<FittingRoom::Wish> FittingRoom::wish_of(std::span<const std::pair<std::string, std::string>> query) const {
  std::map<std::string, std::string> fields;
  for (const auto& [name, value] : query) {
    const bool known = name == "visit" || name == "top" || name == "top_size" || name == "bottom" ||
                       name == "bottom_size" || name == "colours";
    if (!known) return refused("unknown field");
    if (!fields.insert({name, value}).second) return refused(name + " is given twice");
  }
  Wish wish;
  wish.name = fields["visit"];
  const auto wear = [&](const std::string& part, body::Hang hang) -> Status {
    const auto garment = fields.find(part), size = fields.find(part + "_size");
    if (garment == fields.end() && size == fields.end()) return Ok{};
    if (garment == fields.end() || size == fields.end())
      return refused(part + " and " + part + "_size must be given together");
    const auto fit = std::find_if(customer_->fits.begin(), customer_->fits.end(),
                                  [&](const GarmentFit& f) { return f.garment == garment->second; });
    const body::GarmentPattern* pattern =
        fit == customer_->fits.end() ? nullptr : builtin_wardrobe().garment(fit->garment);
    if (pattern == nullptr || pattern->hang != hang) return refused("no " + part + " has this name");
    const auto row =
        std::find_if(fit->sizes.begin(), fit->sizes.end(), [&](const SizeFit& s) { return s.size == size->second; });
    if (row == fit->sizes.end()) return refused(fit->chart + " has no size of this name");
    wish.pieces.push_back({fit->garment, row->chest_mm});
    wish.name += "/" + fit->garment + "/" + row->size;
    return Ok{};
  };
  if (auto worn = wear("bottom", body::Hang::waist); !worn) return worn.error();
  if (auto worn = wear("top", body::Hang::shoulders); !worn) return worn.error();
  if (const auto colours = fields.find("colours"); colours != fields.end()) {
    if (colours->second != "ease") return refused("colours must be ease or left out");
    wish.ease = true;
    wish.name += "/ease";
  }
  return wish;
}

std::optional<PageAnswer> FittingRoom::read_wish(std::span<const std::pair<std::string, std::string>> query,
                                                 Wish& wish) const {
  const auto visit =
      std::find_if(query.begin(), query.end(), [](const auto& field) { return field.first == "visit"; });
  if (visit == query.end()) return PageAnswer{kBadRequest, nullptr, "visit is missing"};
  if (!customer_ || customer_->visit != visit->second)
    return PageAnswer{kNotFound, nullptr, "no measured person has this visit id, or the result was deleted"};
  auto read = wish_of(query);
  if (!read) return PageAnswer{kBadRequest, nullptr, read.error().message};
  wish = std::move(*read);
  return std::nullopt;
}

PageAnswer FittingRoom::ask(std::span<const std::pair<std::string, std::string>> query) {
  const std::lock_guard lock(mutex_);
  Wish wish;
  if (auto refusal = read_wish(query, wish)) return *refusal;
  const auto found = std::find_if(made_.begin(), made_.end(), [&](const Made& m) { return m.name == wish.name; });
  if (found != made_.end()) {
    made_.splice(made_.begin(), made_, found);
    live_.wear(found->name, found->clothes);
    return found->answer;
  }
  if (making_ != wish.name) {
    waiting_ = std::move(wish);
    news_.notify_all();
  }
  return {kAccepted, nullptr, "the picture is being made; request it again"};
}

PageAnswer FittingRoom::ask_cloth(std::span<const std::pair<std::string, std::string>> query) {
  const std::lock_guard lock(mutex_);
  Wish wish;
  if (auto refusal = read_wish(query, wish)) return *refusal;
  const auto found = std::find_if(made_.begin(), made_.end(), [&](const Made& m) { return m.name == wish.name; });
  if (found == made_.end() || !found->clothes) return {kNotFound, nullptr, "no moving clothes have this name"};
  return live_.ask(wish.name);
}

void FittingRoom::work() {
  for (std::unique_lock lock(mutex_);;) {
    news_.wait(lock, [&] { return closing_ || waiting_; });
    if (closing_) return;
    const Wish wish = std::move(*waiting_);
    waiting_.reset();
    making_ = wish.name;
    const Customer customer = *customer_;
    const std::uint64_t visit = visit_;
    lock.unlock();
    auto made = make(customer, wish);
    lock.lock();
    making_.clear();
    if (visit != visit_) continue;  // they have gone meanwhile
    made_.push_front(made ? std::move(*made) : Made{wish.name, {kFailed, nullptr, made.error().message}, nullptr});
    if (made_.size() > kKept) made_.pop_back();
    lock.unlock();
    ready_(customer.visit);
    lock.lock();
  }
}

Result<FittingRoom::Made> FittingRoom::make(const Customer& customer, const Wish& wish) {
  if (!model_) {
    auto model = body::BodyModel::load(body_path_);
    if (!model) return model.error();
    model_ = std::make_unique<body::BodyModel>(std::move(*model));
  }
  body::Avatar avatar{model_.get(), customer.params, customer.pose};
  std::unique_ptr<body::Outfit> outfit;
  if (!wish.pieces.empty()) {
    std::vector<Worn> worn;
    for (const Piece& piece : wish.pieces)
      worn.push_back({builtin_wardrobe().garment(piece.garment), piece.chest_mm});
    auto dressed = dress(builtin_wardrobe(), *model_, customer.params, customer.pose, customer.woman, worn, true);
    if (!dressed) return dressed.error();
    outfit = std::move(*dressed);
    std::vector<body::ClothLook> looks;
    for (std::size_t i = 0; i < worn.size(); ++i) {
      body::ClothLook look{worn[i].pattern->id, worn[i].pattern->colour, {}};
      if (wish.ease) look.vertex_colours = ease_map(*outfit, i);
      looks.push_back(std::move(look));
    }
    body::wear(avatar, *outfit, looks, body::ClothMotion::moves);
  }
  const auto glb = body::glb_of(avatar);
  if (!glb) return glb.error();
  Made made{wish.name, {kOk, nullptr, ""}, nullptr};
  made.answer.file = std::make_shared<const PageFile>(
      PageFile{"model/gltf-binary", std::string(reinterpret_cast<const char*>(glb->data()), glb->size())});
  if (outfit) {
    std::vector<Vec3f> rest(static_cast<std::size_t>(model_->vertex_count()));
    model_->morph(customer.params, rest);
    made.clothes =
        std::make_shared<body::MovingClothes>(*model_, std::move(outfit), body::rest_skeleton(*model_, rest));
  }
  return made;
}

}  // namespace im2fit::apps
