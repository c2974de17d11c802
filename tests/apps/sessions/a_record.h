// SPDX-License-Identifier: Apache-2.0
// A record with every field, and a folder for sessions.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

#include "apps/sessions/record.h"

namespace im2fit::test {

inline sessions::Record a_record() {
  sessions::Record record;
  record.id = "20260504-123000-abcdefgh";
  record.started_utc = "2026-05-04T12:30:00Z";
  record.person = "P017";
  record.consent = {"operator-de-1", "de",  std::string(64, 'a'), "2026-05-04T12:29:50Z",
                    "Shop",          "fit", "shop@x.example"};
  record.truth.height_mm = 1743;
  record.truth.weight_kg = 72.5;
  record.truth.age_years = 41;
  record.truth.gender = "female";
  record.truth.worn_size = "M";
  record.truth.clothing = "close";
  record.truth.tape["waist_girth"] = {812, 809.5};
  record.truth.tape["thigh_girth"] = {566, std::nullopt};
  record.notes = "hair up\nsecond tape by another person";
  record.camera = {"structured-light", "Kinect", 480, 640, 575.5, 575.25, 239.5, 319.5};
  record.site = "shop 3";
  record.versions = {"1.0.0", "0123abcd", "4567cdef", "89ab0123"};
  record.settings = {20, "back", "none", "bare", "auto", "-0.6,1.5,0.6,3"};
  return record;
}

class SessionFolder {
 public:
  SessionFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-sessions-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  SessionFolder(const SessionFolder&) = delete;
  SessionFolder& operator=(const SessionFolder&) = delete;
  ~SessionFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string root() const { return path_ + "/data/sessions"; }  // not made

 private:
  std::string path_;
};

}  // namespace im2fit::test
