// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/site_people.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/text.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

using nlohmann::json;

constexpr char kSimulated[] = "simulated";  // the consent's version of people who are none
constexpr std::size_t kResultBytesMax = std::size_t{16} << 20;

lab::TapeReadings readings_of(const sessions::PersonTruth& truth, std::size_t m) {
  lab::TapeReadings readings;
  const auto reading = sessions::reading_of(truth, std::string(kMeasurementTable[m].id));
  if (!reading) return readings;
  readings.first = reading->first;
  if (reading->second) readings.second = *reading->second;
  return readings;
}

// "" or what is wrong with the answer of measurement `m`. One absurd number would outweigh all people of a study.
std::string read_estimate(const json& values, std::size_t m, index::IntervalEstimate& estimate) {
  const std::string id(kMeasurementTable[m].id);
  if (!values.contains(id) || !values[id].at("value").is_number()) return "has no " + id;
  const json& e = values[id];
  const double value = e.at("value").get<double>();
  const double low = e.at("interval").at(0).get<double>(), high = e.at("interval").at(1).get<double>();
  const sessions::Range range =
      static_cast<Measurement>(m) == Measurement::weight ? sessions::kWeightKg : sessions::kTapeMm;
  for (const double number : {value, low, high})
    if (!(number >= range.least && number <= range.most))
      return fmt::format("{} has {}, expected {} to {}", id, number, range.least, range.most);
  if (low > high) return fmt::format("the interval of {} is reversed: {} to {}", id, low, high);
  estimate = {static_cast<float>(value), static_cast<float>(low), static_cast<float>(high)};
  return "";
}

// What result.json answers, into `person`. "" or why it cannot.
std::string read_answer(const std::string& path, lab::SitePerson& person) {
  const auto read = read_json(path, kResultBytesMax);
  if (!read) return read.error().message;
  const json& result = *read;
  try {
    if (result.at("schema") != "im2fit.result/1") return "result.json is of another schema";
    if (result.at("state") != "MEASURED") return "not measured: " + excerpt(result.at("state").get<std::string>());
    const json& values = result.contains("calibration_site") ? result["calibration_site"].at("uncorrected")
                                                             : result.at("measurements");
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      if (const std::string fault = read_estimate(values, m, person.answer[m]); !fault.empty())
        return "result.json: " + fault;
    person.female = result.at("sex").at("female").get<double>();
    if (!(person.female >= 0 && person.female <= 1))
      return fmt::format("result.json: sex.female is {}, expected 0 to 1", person.female);
    person.camera = printable(result.at("source").at("name").get<std::string>());
    if (result.contains("size")) person.answered_size = excerpt(result["size"].at("best").get<std::string>());
    return "";
  } catch (const json::exception& wrong) {
    return std::string("result.json: ") + wrong.what();
  }
}

}  // namespace

Result<SitePeople> site_people(const std::string& root) {
  const auto listed = sessions::list(root);
  if (!listed) return listed.error();
  if (listed->empty())
    return Error{ErrorCode::not_found,
                 root + ": no sessions there; record some with im2fit serve --operator, or im2fit-lab simulate-site"};
  SitePeople all;
  std::set<std::string> sites, indexes;
  for (const sessions::Listed& one : *listed) {
    if (!one.damage.empty()) {
      all.left_out.push_back(one.id + ": " + one.damage);
      continue;
    }
    const sessions::Record& record = one.record;
    lab::SitePerson person;
    person.person = record.person.empty() ? record.id : record.person;
    if (!record.truth.gender.empty()) person.woman = record.truth.gender == "female";
    person.clothing = record.truth.clothing;
    person.worn_size = record.truth.worn_size;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) person.tape[m] = readings_of(record.truth, m);
    if (const std::string fault = read_answer(root + "/" + one.id + "/" + sessions::kResultFile, person);
        !fault.empty()) {
      all.left_out.push_back(one.id + ": " + fault);
      continue;
    }
    sites.insert(record.site);
    if (!record.versions.index.empty()) indexes.insert(record.versions.index);
    all.synthetic = all.synthetic || record.consent.version == kSimulated;
    all.people.push_back(std::move(person));
  }
  if (sites.size() == 1) all.site = *sites.begin();
  all.indexes.assign(indexes.begin(), indexes.end());
  return all;
}

Result<int> write_sessions(const std::string& root, const std::vector<lab::SimulatedVisit>& visits,
                           const std::string& site, const sessions::Versions& versions) {
  int written = 0;
  for (const lab::SimulatedVisit& visit : visits) {
    if (!visit.measured) continue;
    auto session = sessions::NewSession::begin(root);
    if (!session) return session.error();
    if (auto ok = session->write(sessions::kResultFile, visit.result_json); !ok) return ok.error();
    sessions::Record record;
    record.started_utc = sessions::utc_now();
    record.person = visit.person.person;
    // The consent text is empty, because there is no person: SHA-256 of the empty text.
    record.consent = {kSimulated, "en", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
                      record.started_utc};
    record.truth.age_years = visit.age_years;
    record.truth.gender = *visit.person.woman ? "female" : "male";
    record.truth.worn_size = visit.person.worn_size;
    record.truth.clothing = visit.person.clothing;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const lab::TapeReadings& tape = visit.person.tape[m];
      if (static_cast<Measurement>(m) == Measurement::weight)
        record.truth.weight_kg = tape.mean();
      else
        record.truth.tape[std::string(kMeasurementTable[m].id)] = {tape.first, tape.second};
    }
    record.truth.height_mm = visit.person.tape[measurement_index(Measurement::stature)].mean();
    const Intrinsics& k = visit.intrinsics;
    record.camera = {"structured-light",
                     visit.person.camera,
                     k.width,
                     k.height,
                     static_cast<double>(k.fx),
                     static_cast<double>(k.fy),
                     static_cast<double>(k.cx),
                     static_cast<double>(k.cy)};
    record.notes = "a simulated person";
    record.site = site;
    record.versions = versions;
    if (auto ok = session->finish(std::move(record)); !ok) return ok.error();
    ++written;
  }
  return written;
}

}  // namespace im2fit::apps
