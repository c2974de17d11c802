// SPDX-License-Identifier: Apache-2.0
// Two threads and three rings:
//
//   push() --input--> SENSE --sensed--> FIT --free--> push()
//
// SENSE finds people, mask, joints and pose; FIT runs the session, accumulates frames and measures. SENSE takes
// nothing from FIT for the frames of a session, so thread timing cannot change a result.
//
// A slot index is in exactly one ring or hand. `processed_` counts the frames that have left FIT; when it equals
// `pushed_` no frame is in the pipeline, both stages sleep, and the producer may use their state (finish, reset).
#include "engine/engine.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "engine/arrival.h"
#include "engine/fit_stage.h"
#include "engine/frame_pool.h"
#include "engine/frame_stages.h"
#include "engine/rest.h"
#include "engine/snapshot.h"
#include "engine/spsc_ring.h"
#include "hal/steady_view.h"

namespace im2fit {
namespace {

// A longer live queue only delays guidance: the oldest waiting frame is dropped in favour of the new one.
constexpr std::uint64_t kLiveQueueMax = 2;
// Polling interval of wait_idle(): a thirtieth of a frame's time at 30 Hz.
constexpr std::chrono::milliseconds kIdlePoll{1};

constexpr std::uint32_t kSpare = std::numeric_limits<std::uint32_t>::max();  // no slot of the pool

const Error& full_ring() {
  static const Error error{ErrorCode::invalid_argument, "a ring of the engine is full: a fault of this program"};
  return error;
}

// With EngineSettings::rest: the gate, and the detection and mask of the frame sensed last, which stand in for those
// of the frames repeated while nothing moves.
struct Rest {
  Rest(int width, int height)
      : gate(width, height), mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}
  void keep(const FrameSlot& slot) {
    detection = slot.detection;
    empty = detection.user_count == 0 && !detection.person.found && (detection.guidance & kThereButNotFound) == 0;
    std::memcpy(mask.data(), slot.mask.pixels, mask.size());
  }
  void repeat(FrameSlot& slot) const {
    slot.detection = detection;
    std::memcpy(slot.mask.pixels, mask.data(), mask.size());
  }
  RestGate gate;
  Detection detection;
  bool empty = false;
  std::vector<std::uint8_t> mask;
};

class PipelineEngine final : public Engine {
 public:
  PipelineEngine(const EngineSettings& settings, std::unique_ptr<FrameStages> stages)
      : settings_(settings),
        intrinsics_(settings.intrinsics),
        stages_(std::move(stages)),
        pool_(settings.pool_frames, settings.width, settings.height),
        input_(pool_.slot_count()),
        sensed_(pool_.slot_count()),
        free_(pool_.slot_count()),
        fit_(settings, *stages_),
        snapshot_(fit_.result()) {
    if (settings.live)
      spare_pixels_.resize(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height));
    if (settings.rest) rest_.emplace(settings.width, settings.height);
    to_go_.store(fit_.frames_to_go_min(), std::memory_order_relaxed);
    for (std::uint32_t slot = 0; slot < pool_.slot_count(); ++slot) put(free_, slot);
    people().select(settings.user);
    people().set_region(settings.region);
  }

  // Once, before the first frame. Error: a thread cannot be started; the destructor ends the one that was.
  Status start() {
    if (settings_.single_thread) return Ok{};
    try {
      sense_thread_ = std::thread([this] { sense_loop(); });
      fit_thread_ = std::thread([this] { fit_loop(); });
    } catch (const std::system_error& error) {
      return Error{ErrorCode::io, std::string("the engine's two threads cannot be started (") + error.what() +
                                      "); end other programs, raise the limit on processes (ulimit -u), or measure "
                                      "on a single thread"};
    }
    return Ok{};
  }

  ~PipelineEngine() override {
    stop_.store(true, std::memory_order_release);
    sense_event_.signal();
    fit_event_.signal();
    if (sense_thread_.joinable()) sense_thread_.join();
    if (fit_thread_.joinable()) fit_thread_.join();
  }

  Status push(DepthView depth, const hal::FrameInfo& info) override {
    if (finished_) return after_finish();
    if (depth.pixels == nullptr || depth.width != settings_.width || depth.height != settings_.height)
      return Error{ErrorCode::invalid_argument, "frame is " + std::to_string(depth.width) + "x" +
                                                    std::to_string(depth.height) + ", the engine was made for " +
                                                    std::to_string(settings_.width) + "x" +
                                                    std::to_string(settings_.height)};
    const auto place = acquire();
    if (!place) return place.error();
    copy_depth(depth, *place);
    return commit(info);
  }

  Result<DepthImage> acquire() override {
    if (finished_) return after_finish();
    if (auto sound = fault(); !sound) return sound.error();
    if (!in_hand_) take_place();
    return *in_hand_ == kSpare ? spare() : pool_[*in_hand_].depth;
  }

  Status commit(const hal::FrameInfo& info) override {
    if (!in_hand_) return Error{ErrorCode::invalid_argument, "commit() without acquire()"};
    if (auto sound = fault(); !sound) return sound;
    arrival_.count(info, counts_);
    if (*in_hand_ == kSpare && !leave_spare()) return Ok{};
    const std::uint32_t index = *in_hand_;
    in_hand_.reset();
    if (is_live() && input_.size_seen_by_producer() >= kLiveQueueMax) take_back();
    FrameSlot& slot = pool_[index];
    slot.info = info;
    slot.counts = counts_;
    if (settings_.single_thread) {
      sense(slot);
      fit(slot);
      put(free_, index);
      return Ok{};
    }
    ++pushed_;
    put(input_, index);
    sense_event_.signal();
    if (!is_live()) wait_while_enough();
    return Ok{};
  }

  Status use_intrinsics(const Intrinsics& intrinsics) override {
    if (intrinsics.width != settings_.width || intrinsics.height != settings_.height)
      return Error{ErrorCode::invalid_argument, "intrinsics of another size than the engine's frames"};
    if (auto ok = hal::check_intrinsics(intrinsics, "the frame's intrinsics"); !ok) return ok;
    drain();
    intrinsics_ = intrinsics;
    fit_.use_intrinsics(intrinsics);
    return Ok{};
  }

  bool wait_idle(int timeout_ms) override {
    const auto began = std::chrono::steady_clock::now();
    while (processed_.load(std::memory_order_acquire) != pushed_) {
      if (timeout_ms >= 0 && std::chrono::steady_clock::now() - began >= std::chrono::milliseconds(timeout_ms))
        return false;
      std::this_thread::sleep_for(kIdlePoll);
    }
    return true;
  }

  void finish() override {
    if (finished_) return;
    finished_ = true;
    drain();
    fit_.end(counts_);
    fault_.store(fit_.fault(), std::memory_order_relaxed);
    snapshot_.publish(fit_.result());
  }

  Status fault() const override {
    if (const Error* found = fault_.load(std::memory_order_acquire)) return *found;
    return Ok{};
  }

  EngineResult result() const override {
    const EngineResult result = snapshot_.read();
    for (const SessionFacts& known : known_.read())
      if (known.session == result.session) return with_known(result, known.facts);
    return with_known(result, {});
  }

  Status set_known(const KnownFacts& facts, std::uint32_t session) override {
    if (auto ok = check_known(facts); !ok) return ok;
    // A measured person keeps theirs while the next person's are set.
    if (known_now_[0].session != session) known_now_[1] = known_now_[0];
    known_now_[0] = {facts, session};
    known_.publish(known_now_);
    return Ok{};
  }

  void reset() override {
    drain();
    stages_->reset_sense();
    if (steady_) steady_->forget();
    reset_clock();
    fit_.reset();
    known_now_ = {};  // sessions count from 0 again
    known_.publish(known_now_);
    begin_again();
  }

  void next_person() override {
    drain();
    if (settings_.one_after_another && fit_.leaving()) {
      if (settings_.live) reset_clock();  // the time spent reading the answer is not a frame gap
      finished_ = false;
      return;
    }
    if (!fit_.over()) people().release();
    if (steady_) steady_->forget();
    reset_clock();  // frames were not processed meanwhile: not a frame gap
    fit_.next_person();
    begin_again();
  }

  ImageView<const std::uint16_t> fused_depth_q4() const override {
    return finished_ && fit_.result().frames_used > 0 ? stages_->fused_depth_q4() : ImageView<const std::uint16_t>{};
  }
  MaskView fused_mask() const override {
    return finished_ && fit_.result().frames_used > 0 ? stages_->fused_mask() : MaskView{};
  }

  void select_user(int user) override {
    drain();
    if (people().requested() == user) return;
    people().select(user);
    fit_.begin_next();
    begin_again();
  }

  Status set_region(const std::optional<FloorRegion>& region) override {
    if (auto ok = check_region(region); !ok) return ok;
    drain();
    people().set_region(region);
    return Ok{};
  }

 private:
  PersonTracker& people() {
    return stages_->people();
  }  // SENSE's, or the producer's while no frame is in the pipeline

  void begin_again() {
    over_.store(false, std::memory_order_relaxed);
    to_go_.store(fit_.frames_to_go_min(), std::memory_order_relaxed);
    fault_.store(nullptr, std::memory_order_relaxed);
    counts_ = {};
    arrival_.reset();
    finished_ = false;
    for (std::uint32_t slot = 0; slot < pool_.slot_count(); ++slot) pool_[slot].leaving = false;
    if (rest_) rest_->gate.wake();
    snapshot_.publish(fit_.result());
  }

  void reset_clock() {
    clock_.reset();
    periods_.reset();
    since_processed_s_ = 0;
  }

  static Error after_finish() {
    return {ErrorCode::invalid_argument, "frame pushed after finish(): call reset() first"};
  }
  bool is_live() const { return settings_.live && !settings_.single_thread; }
  DepthImage spare() { return {spare_pixels_.data(), settings_.width, settings_.height}; }

  // A ring has as many places as there are slots, and a slot is in one ring or hand. So a full ring is a bug of the
  // engine: it is reported, and no slot is lost silently.
  void put(SpscRing& ring, std::uint32_t index) {
    if (!ring.try_push(index)) fault_.store(&full_ring(), std::memory_order_release);
  }

  // A free slot for the frame that comes next. Live, when there is none: the spare place, since one may be free by
  // the time the frame is there.
  void take_place() {
    for (std::uint32_t index = 0;;) {
      const std::uint32_t ticket = producer_event_.ticket();
      if (free_.try_pop(index)) {
        in_hand_ = index;
        return;
      }
      if (is_live()) {
        in_hand_ = kSpare;
        return;
      }
      producer_event_.wait(ticket);
    }
  }

  // Moves the frame from the spare place into a slot: a free one, else that of the oldest frame not yet begun. False:
  // the frame is given up.
  bool leave_spare() {
    std::uint32_t index = 0;
    in_hand_.reset();
    if (free_.try_pop(index))
      in_hand_ = index;
    else
      take_back();
    if (!in_hand_) {
      ++counts_.dropped;
      return false;
    }
    copy_depth(spare(), pool_[*in_hand_].depth);
    return true;
  }

  // Gives up the oldest frame not yet begun; its slot is in the producer's hand, for the next frame.
  void take_back() {
    std::uint32_t index = 0;
    if (!input_.take_back_oldest(index)) return;
    ++counts_.dropped;
    --pushed_;
    in_hand_ = index;
  }

  // Waits while the frames in the pipeline may be all that the session needs: another one would be read in vain.
  void wait_while_enough() {
    for (;;) {
      const std::uint32_t ticket = producer_event_.ticket();
      // A frame counts as in the pipeline until after it is counted in to_go_: never too few are taken to be needed.
      const std::uint64_t inside = pushed_ - processed_.load(std::memory_order_acquire);
      const int to_go = to_go_.load(std::memory_order_acquire);
      if (inside == 0 || to_go == 0 || inside < static_cast<std::uint64_t>(to_go)) return;
      producer_event_.wait(ticket);
    }
  }

  // Waits until every frame pushed has come out of FIT.
  void drain() {
    for (;;) {
      const std::uint32_t ticket = producer_event_.ticket();
      if (processed_.load(std::memory_order_acquire) == pushed_) return;
      producer_event_.wait(ticket);
    }
  }

  // Of a camera that tells where it is: the frame becomes one of the view, and its pose the view's.
  void steady(FrameSlot& slot, float seconds) {
    if (!steady_) {
      steady_.emplace();
      steady_->prepare(settings_.width, settings_.height);
      steady_->follow_walks(settings_.turn == Turn::walk);
    }
    if (steady_->take(*slot.info.pose, seconds)) steady_->run(intrinsics_, slot.depth);
    if (slot.info.down) slot.info.down = steady_->in_view(*slot.info.down);
    slot.info.pose = steady_->pose();
  }

  void sense(FrameSlot& slot) {
    slot.sensed = settings_.one_after_another || !over_.load(std::memory_order_relaxed);
    slot.passed = false;
    if (!slot.sensed) return;
    float seconds = clock_.step(slot.info.host_ns);
    slot.after_frame_gap = seconds > kFrameGapSecondsMax;
    if (slot.after_frame_gap) {
      stages_->reset_sense();
      if (steady_) steady_->forget();
      if (rest_) rest_->gate.wake();
      since_processed_s_ = 0;
      seconds = kFramePeriodS;
    }
    if (slot.info.pose)
      steady(slot, seconds);
    else if (steady_)
      steady_->forget();  // where it is now is not known
    if (slot.info.down) stages_->set_down(*slot.info.down);
    since_processed_s_ += seconds;
    const RestStep step =
        rest_ ? rest_->gate.step(slot.depth, seconds, rest_->empty || slot.leaving) : RestStep::sense;
    slot.passed = step == RestStep::pass;
    if (slot.passed) return;
    slot.seconds = since_processed_s_;
    slot.periods = periods_.step(since_processed_s_);
    since_processed_s_ = 0;
    if (step == RestStep::repeat) {
      rest_->repeat(slot);
    } else {
      stages_->restore_edges(slot.depth, intrinsics_);
      // The frames passed looked like the frame sensed last: movement since then took one frame's time.
      slot.detection = stages_->sense(slot.depth, intrinsics_, slot.mask, seconds);
      if (rest_) rest_->keep(slot);
    }
    const Person& person = slot.detection.person;
    people().hold(person.found ? person.id : 0, slot.detection.guidance == 0, slot.periods);
  }

  void fit(FrameSlot& slot) {
    if (slot.sensed && !fit_.over()) process(slot);
    slot.leaving = fit_.leaving();
  }

  void process(const FrameSlot& slot) {
    if (slot.passed)
      fit_.pass(slot);
    else
      fit_.process(slot);
    if (fit_.fault() != nullptr) fault_.store(fit_.fault(), std::memory_order_release);
    if (fit_.over()) over_.store(true, std::memory_order_relaxed);
    snapshot_.publish(fit_.result());
    // After it: a producer that need not wait reads that the person is measured.
    to_go_.store(fit_.frames_to_go_min(), std::memory_order_release);
    if (!settings_.watch || slot.passed) return;
    const Detection& detection = slot.detection;
    settings_.watch({slot.depth, slot.mask, slot.info,
                     std::span(detection.users).first(static_cast<std::size_t>(detection.user_count)),
                     fit_.result()});
  }

  void sense_loop() {
    for (;;) {
      const std::uint32_t ticket = sense_event_.ticket();
      if (stop_.load(std::memory_order_acquire)) return;
      std::uint32_t index = 0;
      if (!input_.try_pop(index)) {
        sense_event_.wait(ticket);
        continue;
      }
      sense(pool_[index]);
      put(sensed_, index);
      fit_event_.signal();
    }
  }

  void fit_loop() {
    for (;;) {
      const std::uint32_t ticket = fit_event_.ticket();
      if (stop_.load(std::memory_order_acquire)) return;
      std::uint32_t index = 0;
      if (!sensed_.try_pop(index)) {
        fit_event_.wait(ticket);
        continue;
      }
      fit(pool_[index]);
      put(free_, index);
      processed_.fetch_add(1, std::memory_order_release);
      producer_event_.signal();
    }
  }

  const EngineSettings settings_;
  Intrinsics intrinsics_;  // both stages', or the producer's while no frame is in the pipeline
  const std::unique_ptr<FrameStages> stages_;
  FramePool pool_;
  SpscRing input_;
  SpscRing sensed_;
  SpscRing free_;
  // SENSE's, or the producer's while no frame is in the pipeline.
  FrameClock clock_;
  PeriodCounter periods_;
  float since_processed_s_ = 0;  // since the frame before that was not only counted
  std::optional<Rest> rest_;
  std::optional<hal::SteadyView> steady_;  // from the first pose on
  // FIT's, or the producer's while no frame is in the pipeline.
  FitStage fit_;
  struct SessionFacts {
    KnownFacts facts;
    std::uint32_t session = 0;
  };
  using LatestFacts = std::array<SessionFacts, 2>;  // the latest first; of two sessions
  LatestFacts known_now_{};                         // the producer's
  Snapshot<LatestFacts> known_;
  Snapshot<EngineResult> snapshot_;

  // The producer's.
  bool finished_ = false;
  std::uint64_t pushed_ = 0;
  ArrivalCounts counts_;
  ArrivalCounter arrival_;
  std::optional<std::uint32_t> in_hand_;  // the slot, or kSpare, that acquire() gave
  std::vector<std::uint16_t> spare_pixels_;

  std::atomic<std::uint64_t> processed_{0};
  std::atomic<bool> over_{false};  // FIT to SENSE: the session is over, frames need no reading
  std::atomic<int> to_go_{0};      // FIT to the producer: frames_to_go_min()
  // FIT to the producer: its fault, which stands still while the session is over.
  std::atomic<const Error*> fault_{nullptr};
  std::atomic<bool> stop_{false};
  Event producer_event_;
  Event sense_event_;
  Event fit_event_;
  std::thread sense_thread_;
  std::thread fit_thread_;
};

}  // namespace

Result<std::unique_ptr<Engine>> create_engine(const EngineSettings& settings, std::unique_ptr<FrameStages> stages) {
  if (auto ok = check_settings(settings); !ok) return ok.error();
  auto engine = std::make_unique<PipelineEngine>(settings, std::move(stages));
  if (auto started = engine->start(); !started) return started.error();
  return std::unique_ptr<Engine>(std::move(engine));
}

}  // namespace im2fit
