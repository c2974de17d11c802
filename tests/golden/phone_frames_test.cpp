// SPDX-License-Identifier: Apache-2.0
// The golden clip as phones deliver frames (im2fit_frame): in every format, turned, with padded rows, through a lens
// that the frames name. The library's answer must not depend on it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "capi/include/im2fit/im2fit.h"
#include "core/file.h"
#include "perception/observe/observe.h"
#include "tests/golden/golden_run.h"

namespace im2fit::golden {
namespace {

struct Said {
  std::string json;
  im2fit_result result{};
};

// A frame with the memory behind it.
struct PhoneFrame {
  im2fit_frame frame{};
  std::vector<std::uint16_t> samples;
  std::vector<float> metres;
  std::vector<std::uint8_t> confidence;
};

class PhoneFrames : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto data = Data::load(IM2FIT_GOLDEN_DATA);
    if (data) data_ = new Data(std::move(*data));
  }
  static void TearDownTestSuite() {
    delete data_;
    data_ = nullptr;
  }
  void SetUp() override { ASSERT_NE(data_, nullptr); }

  static im2fit_settings settings() {
    const Intrinsics& k = data_->intrinsics();
    im2fit_settings s;
    im2fit_settings_init(&s, sizeof s);
    static const std::string tracker = std::string(IM2FIT_GOLDEN_DATA) + "/tracker.i2t";
    static const std::string index = std::string(IM2FIT_GOLDEN_DATA) + "/index.i2f";
    s.tracker_path = tracker.c_str();
    s.index_path = index.c_str();
    s.width = k.width;
    s.height = k.height;
    s.fx = k.fx;
    s.fy = k.fy;
    s.cx = k.cx;
    s.cy = k.cy;
    s.frames_wanted = kFramesWanted;
    return s;
  }

  static PhoneFrame upright(std::size_t number) {
    PhoneFrame f;
    im2fit_frame_init(&f.frame, sizeof f.frame);
    f.samples = data_->frames()[number];
    f.frame.width = data_->intrinsics().width;
    f.frame.height = data_->intrinsics().height;
    f.frame.sequence = number;
    f.frame.time_ns = static_cast<std::int64_t>(number) * 33333333;
    return f;
  }

  using Change = std::function<void(PhoneFrame&, std::size_t)>;
  static Said said(const im2fit_settings& settings, const Change& change) {
    Said said;
    im2fit_handle* handle = nullptr;
    EXPECT_EQ(im2fit_open(&settings, &handle), IM2FIT_OK) << im2fit_last_error(nullptr);
    if (handle == nullptr) return said;
    for (std::size_t i = 0; i < data_->frames().size(); ++i) {
      PhoneFrame f = upright(i);
      change(f, i);
      if (f.frame.pixels == nullptr) f.frame.pixels = f.samples.data();
      EXPECT_EQ(im2fit_push_frame(handle, &f.frame), IM2FIT_OK) << im2fit_last_error(handle);
    }
    EXPECT_EQ(im2fit_finish(handle), IM2FIT_OK);
    EXPECT_EQ(im2fit_poll(handle, &said.result, sizeof said.result), IM2FIT_OK);
    std::size_t length = 0;
    EXPECT_EQ(im2fit_result_json(handle, nullptr, 0, &length), IM2FIT_ERROR_TOO_SMALL);
    said.json.resize(length + 1);
    EXPECT_EQ(im2fit_result_json(handle, said.json.data(), length, &length), IM2FIT_ERROR_TOO_SMALL);
    EXPECT_EQ(im2fit_result_json(handle, said.json.data(), length + 1, &length), IM2FIT_OK);
    EXPECT_EQ(std::strlen(said.json.c_str()), length);
    said.json.resize(length);
    im2fit_close(handle);
    return said;
  }
  static void nothing(PhoneFrame& /*frame*/, std::size_t /*number*/) {}
  static const Said& reference() {
    static const Said once = said(settings(), nothing);
    return once;
  }

  static Data* data_;
};
Data* PhoneFrames::data_ = nullptr;

TEST_F(PhoneFrames, SayWhatPushedFramesSay) {
  const im2fit_settings s = settings();
  im2fit_handle* handle = nullptr;
  ASSERT_EQ(im2fit_open(&s, &handle), IM2FIT_OK);
  for (std::size_t i = 0; i < data_->frames().size(); ++i)
    ASSERT_EQ(im2fit_push(handle, data_->frames()[i].data(), s.width, s.height, 0, i,
                          static_cast<std::int64_t>(i) * 33333333),
              IM2FIT_OK);
  ASSERT_EQ(im2fit_wait(handle, 60000), IM2FIT_OK);
  ASSERT_EQ(im2fit_finish(handle), IM2FIT_OK);
  std::string json(1U << 20, ' ');
  std::size_t length = 0;
  ASSERT_EQ(im2fit_result_json(handle, json.data(), json.size(), &length), IM2FIT_OK);
  json.resize(length);
  im2fit_close(handle);
  EXPECT_EQ(first_difference(reference().json, json), "");
  EXPECT_EQ(reference().result.measured, 1);
  EXPECT_NE(json.find("\"MEASURED\""), std::string::npos);
}

TEST_F(PhoneFrames, InDepth16AreTheSame) {
  std::mt19937 generator(7);
  const auto random = [&] { return static_cast<unsigned>(generator()); };
  const Said found = said(settings(), [&](PhoneFrame& f, std::size_t) {
    f.frame.format = IM2FIT_FORMAT_DEPTH16;
    f.frame.confidence_min = 4;
    for (std::uint16_t& sample : f.samples) {
      ASSERT_LT(sample, 1U << 13);
      const bool sure = sample != 0;
      // What has no data is any distance, unsure: fields 1 to 4 are 0 to 3 sevenths. Sure are 0 and 5 to 7.
      const unsigned field = sure ? (random() % 4 == 0 ? 0U : 5U + random() % 3) : 1U + random() % 4;
      sample = static_cast<std::uint16_t>((sure ? sample : random() & 0x1FFFU) | field << 13);
    }
  });
  EXPECT_EQ(first_difference(reference().json, found.json), "");
}

TEST_F(PhoneFrames, InMetresAreTheSame) {
  const float lacking[] = {0, -1, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                           80};
  const Said found = said(settings(), [&](PhoneFrame& f, std::size_t) {
    f.frame.format = IM2FIT_FORMAT_F32;
    for (const std::uint16_t sample : f.samples)
      f.metres.push_back(sample != 0 ? static_cast<float>(sample) / 1000.0F : lacking[f.metres.size() % 5]);
    f.frame.pixels = f.metres.data();
  });
  EXPECT_EQ(first_difference(reference().json, found.json), "");
}

TEST_F(PhoneFrames, WithPaddedRowsAndConfidenceAreTheSame) {
  const Said found = said(settings(), [&](PhoneFrame& f, std::size_t) {
    const std::size_t width = static_cast<std::size_t>(f.frame.width),
                      height = static_cast<std::size_t>(f.frame.height);
    std::vector<std::uint16_t> padded((width + 5) * height, 1234);
    f.confidence.assign((width + 3) * height, 0);
    for (std::size_t v = 0; v < height; ++v)
      for (std::size_t u = 0; u < width; ++u) {
        const std::uint16_t sample = f.samples[v * width + u];
        padded[v * (width + 5) + u] = sample != 0 ? sample : 777;  // not to be believed
        f.confidence[v * (width + 3) + u] = sample != 0 ? 2 : 1;
      }
    f.samples = padded;
    f.frame.row_bytes = 2 * (width + 5);
    f.frame.confidence = f.confidence.data();
    f.frame.confidence_row_bytes = width + 3;
    f.frame.confidence_min = 2;
  });
  EXPECT_EQ(first_difference(reference().json, found.json), "");
}

// As the camera hung: the library turns back the frames that were turned before.
TEST_F(PhoneFrames, TurnedByTheLibraryAreTheSame) {
  const Intrinsics& k = data_->intrinsics();
  for (const int deg : {90, 180, 270}) {
    const int back = 360 - deg;
    const Said found = said(settings(), [&](PhoneFrame& f, std::size_t) {
      const Intrinsics hung = hal::rotate_upright(k, back);
      std::vector<std::uint16_t> turned(f.samples.size());
      hal::rotate_upright(DepthView(f.samples.data(), k.width, k.height), back,
                          DepthImage(turned.data(), hung.width, hung.height));
      f.samples = turned;
      f.frame.width = hung.width;
      f.frame.height = hung.height;
      f.frame.rotate_deg = deg;
      f.frame.fx = hung.fx;
      f.frame.fy = hung.fy;
      f.frame.cx = hung.cx;
      f.frame.cy = hung.cy;
    });
    EXPECT_EQ(first_difference(reference().json, found.json), "") << deg;
  }
}

// A lens given with the frames outweighs the lens that the handle was opened with. One that breathes costs little.
TEST_F(PhoneFrames, AToldLensIsUsed) {
  const Intrinsics& k = data_->intrinsics();
  im2fit_settings wrong = settings();
  wrong.fx *= 1.01F;
  wrong.fy *= 1.01F;
  const auto tell = [&](float scale) {
    return [&k, scale](PhoneFrame& f, std::size_t number) {
      const float breath = number % 2 == 0 ? 1.0F : scale;
      f.frame.fx = k.fx * breath;
      f.frame.fy = k.fy * breath;
      f.frame.cx = k.cx;
      f.frame.cy = k.cy;
    };
  };
  const float truth_mm = reference().result.measurements[IM2FIT_STATURE].value;
  const float untold_mm = said(wrong, nothing).result.measurements[IM2FIT_STATURE].value;
  const float told_mm = said(wrong, tell(1)).result.measurements[IM2FIT_STATURE].value;
  RecordProperty("untold_mm", std::to_string(untold_mm - truth_mm));
  EXPECT_GT(std::abs(untold_mm - truth_mm), 5.0F) << "the test's lens makes no difference";
  EXPECT_LT(std::abs(told_mm - truth_mm), 1.0F);
  EXPECT_EQ(first_difference(reference().json, said(wrong, tell(1)).json), "");
}

// A pinhole's picture through the lens: the pixel at (u, v) sees the ray that the lens' formula brings there,
// found by Newton's method without derivatives (each step subtracts the formula's error).
std::vector<std::uint16_t> through_lens(const std::vector<std::uint16_t>& depth, const Intrinsics& k,
                                        const im2fit_frame& lens) {
  const double fx = double{k.fx}, fy = double{k.fy}, cx = double{k.cx}, cy = double{k.cy};
  std::vector<std::uint16_t> out(depth.size());
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const double seen_x = (u - cx) / fx, seen_y = (v - cy) / fy;
      double x = seen_x, y = seen_y;
      for (int i = 0; i < 20; ++i) {
        const double r2 = x * x + y * y;
        const double radial = r2 * (double{lens.k1} + r2 * (double{lens.k2} + r2 * double{lens.k3}));
        const double added_x = x * radial + 2 * double{lens.p1} * x * y + double{lens.p2} * (r2 + 2 * x * x);
        const double added_y = y * radial + double{lens.p1} * (r2 + 2 * y * y) + 2 * double{lens.p2} * x * y;
        x = seen_x - added_x;
        y = seen_y - added_y;
      }
      const auto from_u = std::lround(x * fx + cx), from_v = std::lround(y * fy + cy);
      if (from_u < 0 || from_u >= k.width || from_v < 0 || from_v >= k.height) continue;
      out[static_cast<std::size_t>(v * k.width + u)] = depth[static_cast<std::size_t>(from_v * k.width + from_u)];
    }
  return out;
}

// A lens that shifts a person's head and feet by 2 % costs centimetres. Given with the frames, it costs only what a
// sample's place costs. Turned by the library it is the same to the bit.
TEST_F(PhoneFrames, AToldDistortionIsUndone) {
  const Intrinsics& k = data_->intrinsics();
  const auto bend = [&](bool told, int deg) {
    return [&, told, deg](PhoneFrame& f, std::size_t) {
      f.frame.k1 = 0.09F;
      f.frame.k2 = -0.03F;
      f.frame.k3 = 0.005F;
      f.frame.p1 = 0.001F;
      f.frame.p2 = -0.0007F;
      f.samples = through_lens(f.samples, k, f.frame);
      if (!told) f.frame.k1 = f.frame.k2 = f.frame.k3 = f.frame.p1 = f.frame.p2 = 0;
      if (deg == 0) return;
      // The camera hangs head down: its axes point the other way, and so do the tangential terms.
      std::vector<std::uint16_t> turned(f.samples.size());
      hal::rotate_upright(DepthView(f.samples.data(), k.width, k.height), deg,
                          DepthImage(turned.data(), k.width, k.height));
      f.samples = turned;
      f.frame.rotate_deg = deg;
      f.frame.p1 = -f.frame.p1;
      f.frame.p2 = -f.frame.p2;
    };
  };
  const Said told = said(settings(), bend(true, 0)), untold = said(settings(), bend(false, 0));
  ASSERT_EQ(told.result.measured, 1);
  const auto off_mm = [&](const Said& found, int id) {
    return std::abs(found.result.measurements[id].value - reference().result.measurements[id].value);
  };
  RecordProperty("stature_mm", std::to_string(off_mm(told, IM2FIT_STATURE)));
  RecordProperty("untold_stature_mm", std::to_string(off_mm(untold, IM2FIT_STATURE)));
  RecordProperty("waist_mm", std::to_string(off_mm(told, IM2FIT_WAIST_GIRTH)));
  EXPECT_LT(off_mm(told, IM2FIT_STATURE), 3.0F);
  EXPECT_LT(off_mm(told, IM2FIT_WAIST_GIRTH), 6.0F);
  EXPECT_GT(off_mm(untold, IM2FIT_STATURE), 10.0F) << "the test's lens makes no difference";
  EXPECT_EQ(first_difference(told.json, said(settings(), bend(true, 180)).json), "");
}

// The mean of pixels with data within `reach_px`, as phones' drivers blend edges.
std::vector<std::uint16_t> blended(const std::vector<std::uint16_t>& depth, const Intrinsics& k, int reach_px) {
  std::vector<std::uint16_t> out(depth.size());
  const DepthView from(depth.data(), k.width, k.height);
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      if (from.at(u, v) == 0) continue;
      int sum_mm = 0, count = 0;
      for (int y = std::max(0, v - reach_px); y <= std::min(k.height - 1, v + reach_px); ++y)
        for (int x = std::max(0, u - reach_px); x <= std::min(k.width - 1, u + reach_px); ++x) {
          sum_mm += from.at(x, y);
          count += from.at(x, y) != 0 ? 1 : 0;
        }
      out[static_cast<std::size_t>(v * k.width + u)] = static_cast<std::uint16_t>(sum_mm / count);
    }
  return out;
}

// A blend of 3x3 pixels takes a pixel off either side of everything; after it is put back the answer to the sharp
// frames and this one agree within their intervals, of which this one is wider. A blend as wide as a hand is refused.
TEST_F(PhoneFrames, BlendedEdgesArePutBackOrRefused) {
  const Intrinsics& k = data_->intrinsics();
  const auto blend = [&](int reach_px) {
    return [&k, reach_px](PhoneFrame& f, std::size_t) { f.samples = blended(f.samples, k, reach_px); };
  };
  const im2fit_result sharp = reference().result, found = said(settings(), blend(1)).result;
  ASSERT_EQ(found.measured, 1);
  for (const int id : {IM2FIT_STATURE, IM2FIT_CHEST_GIRTH, IM2FIT_WAIST_GIRTH, IM2FIT_HIP_GIRTH}) {
    const im2fit_estimate &before = sharp.measurements[id], &now = found.measurements[id];
    RecordProperty(im2fit_measurement_name(id), std::to_string(now.value - before.value));
    EXPECT_LE(now.low, before.high) << im2fit_measurement_name(id);
    EXPECT_GE(now.high, before.low) << im2fit_measurement_name(id);
    EXPECT_GE(now.high - now.low, before.high - before.low) << im2fit_measurement_name(id);
  }
  const Said refused = said(settings(), blend(6));
  EXPECT_EQ(refused.result.measured, 0);
  EXPECT_NE(refused.result.guidance_seen & IM2FIT_GUIDANCE_TOO_NOISY, 0U) << refused.json;
}

// The person of the clip alone, without room and floor, as a camera on the same spot sees it that looks down by
// `pitch_deg`: turned about its own centre, a picture needs no more than other rays.
struct TiltedClip {
  static constexpr int kWidth = 320, kHeight = 560;
  explicit TiltedClip(double pitch_deg)
      : c(static_cast<float>(std::cos(pitch_deg * std::numbers::pi / 180))),
        s(static_cast<float>(std::sin(pitch_deg * std::numbers::pi / 180))) {}

  std::vector<std::uint16_t> seen(const std::vector<std::uint16_t>& depth, const std::vector<std::uint8_t>& mask,
                                  const Intrinsics& k) const {
    std::vector<std::uint16_t> out(std::size_t{kWidth} * kHeight);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const float x = (static_cast<float>(u) - 0.5F * (kWidth - 1)) / k.fx,
                    y = (static_cast<float>(v) - 0.5F * (kHeight - 1)) / k.fy;
        const float level_y = c * y + s, level_z = c - s * y;  // the same ray in the level camera's axes
        const int from_u = static_cast<int>(std::lround(k.cx + k.fx * x / level_z)),
                  from_v = static_cast<int>(std::lround(k.cy + k.fy * level_y / level_z));
        if (from_u < 0 || from_u >= k.width || from_v < 0 || from_v >= k.height) continue;
        const auto from = static_cast<std::size_t>(from_v * k.width + from_u);
        if (mask[from] == 0) continue;
        out[static_cast<std::size_t>(v * kWidth + u)] =
            static_cast<std::uint16_t>(static_cast<float>(depth[from]) / level_z + 0.5F);
      }
    return out;
  }
  float c, s;
};

TEST_F(PhoneFrames, GravityRightsATiltedCameraWhereNoFloorIsSeen) {
  const Intrinsics& k = data_->intrinsics();
  const TiltedClip tilted(20);
  im2fit_settings s = settings();
  s.width = TiltedClip::kWidth;
  s.height = TiltedClip::kHeight;
  s.cx = 0.5F * (TiltedClip::kWidth - 1);
  s.cy = 0.5F * (TiltedClip::kHeight - 1);
  PersonDetector sensor(k.width, k.height, data_->tracker());
  FloorPlane floor;
  std::vector<std::vector<std::uint16_t>> frames;
  for (const auto& depth : data_->frames()) {
    std::vector<std::uint8_t> mask(depth.size());
    const Detection found =
        sensor.sense({depth.data(), k.width, k.height}, k, MaskImage(mask.data(), k.width, k.height));
    ASSERT_TRUE(found.person.found && found.person.floor.known);
    floor = found.person.floor;
    frames.push_back(tilted.seen(depth, mask, k));
  }
  const Vec3f up = floor.up;
  const Vec3f down = {-up.x, -(tilted.c * up.y - tilted.s * up.z), -(tilted.s * up.y + tilted.c * up.z)};
  const auto frame = [&](bool told) {
    return [&, told](PhoneFrame& f, std::size_t number) {
      f.samples = frames[number];
      f.frame.width = TiltedClip::kWidth;
      f.frame.height = TiltedClip::kHeight;
      if (!told) return;
      f.frame.down_x = 9.81F * down.x;
      f.frame.down_y = 9.81F * down.y;
      f.frame.down_z = 9.81F * down.z;
    };
  };
  const Said untold = said(s, frame(false)), told = said(s, frame(true));
  EXPECT_EQ(untold.result.measured, 0);
  EXPECT_NE(untold.result.guidance_seen & IM2FIT_GUIDANCE_NOT_UPRIGHT, 0U) << untold.json;
  ASSERT_EQ(told.result.measured, 1) << told.json;
  const float stature_mm = told.result.measurements[IM2FIT_STATURE].value,
              truth_mm = reference().result.measurements[IM2FIT_STATURE].value;
  RecordProperty("stature_mm", std::to_string(stature_mm - truth_mm));
  EXPECT_NEAR(stature_mm, truth_mm, 25);
}

TEST_F(PhoneFrames, GravityIsADirection) {
  const im2fit_settings s = settings();
  im2fit_handle* handle = nullptr;
  ASSERT_EQ(im2fit_open(&s, &handle), IM2FIT_OK);
  const auto status = [&](float x, float y, float z) {
    PhoneFrame f = upright(0);
    f.frame.pixels = f.samples.data();
    f.frame.down_x = x;
    f.frame.down_y = y;
    f.frame.down_z = z;
    return im2fit_push_frame(handle, &f.frame);
  };
  EXPECT_EQ(status(0, 9.81F, 0), IM2FIT_OK);
  EXPECT_EQ(status(0, 0, 0), IM2FIT_OK) << "not known";
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, 1e-5F, 1e9F}) {
    EXPECT_EQ(status(0, bad, 0), IM2FIT_ERROR_INVALID_ARGUMENT) << bad;
    EXPECT_NE(std::strstr(im2fit_last_error(handle), "down_x"), nullptr) << im2fit_last_error(handle);
  }
  // A caller of the header before gravity.
  PhoneFrame old = upright(1);
  old.frame.pixels = old.samples.data();
  old.frame.struct_size = offsetof(im2fit_frame, down_x);
  old.frame.down_x = nan;
  EXPECT_EQ(im2fit_push_frame(handle, &old.frame), IM2FIT_OK) << im2fit_last_error(handle);
  im2fit_close(handle);
}

// Models from memory and from inside another file say what models by path say.
TEST_F(PhoneFrames, ModelsNeedNoPath) {
  const im2fit_settings by_path = settings();
  const auto tracker = read_file(by_path.tracker_path);
  const auto index = read_file(by_path.index_path);
  ASSERT_TRUE(tracker && index);
  im2fit_settings s = by_path;
  s.tracker_path = s.index_path = nullptr;
  s.tracker_data.kind = IM2FIT_DATA_MEMORY;
  s.tracker_data.bytes = tracker->data();
  s.tracker_data.size = tracker->size();
  // At an odd place, as an asset in an APK.
  const std::string path = testing::TempDir() + "/phone_frames_asset";
  std::vector<std::byte> asset(4099, std::byte{9});
  asset.insert(asset.end(), index->begin(), index->end());
  asset.resize(asset.size() + 77, std::byte{9});
  ASSERT_TRUE(write_file_atomically(path, asset));
  s.index_data.kind = IM2FIT_DATA_FD;
  s.index_data.fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  s.index_data.offset = 4099;
  s.index_data.size = index->size();
  ASSERT_GE(s.index_data.fd, 0);
  const Said found = said(s, nothing);
  EXPECT_EQ(first_difference(reference().json, found.json), "");
  im2fit_handle* handle = nullptr;
  s.index_data.size += 1000;
  EXPECT_EQ(im2fit_open(&s, &handle), IM2FIT_ERROR_CORRUPT);
  EXPECT_NE(std::strstr(im2fit_last_error(nullptr), "settings.index_data ends after"), nullptr)
      << im2fit_last_error(nullptr);
  ::close(s.index_data.fd);
  ::unlink(path.c_str());
}

}  // namespace
}  // namespace im2fit::golden
