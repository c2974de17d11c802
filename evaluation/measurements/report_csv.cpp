// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cmath>

#include "evaluation/measurements/report.h"

namespace im2fit::lab {
namespace {

// Empty where there is none, so that every reader of CSV takes it as missing.
std::string cell(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "";
}

}  // namespace

std::string csv_of(const std::vector<ConditionRun>& runs) {
  std::string csv =
      "family,condition,measurement,unit,people,bias,mae,sd,p95,max,iso_20685_limit,mean_low,mean_high,coverage_95,"
      "interval_width,agreement_low,agreement_high,tem,tem_percent,reliability,mae_nearest,mae_raw_nearest,"
      "mae_paper\n";
  for (const ConditionRun& run : runs)
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const MeasurementReport& r = run.report.measurements[m];
      const ErrorStatistics& s = r.of(Estimator::ours);
      csv += fmt::format("{},{},{},{},{}", run.report.family, run.report.condition, kMeasurementTable[m].id,
                         kMeasurementTable[m].unit, s.count);
      const double none = std::nan("");
      const double limit = iso_20685_limit_mm(static_cast<Measurement>(m));
      const bool again = r.repeatability.pairs > 0;
      for (const double value :
           {s.bias, s.mae, s.sd, s.p95, s.max, limit > 0 ? limit : none, s.mean_low, s.mean_high, r.coverage(),
            r.interval_width, r.agreement.low, r.agreement.high, again ? r.repeatability.tem : none,
            again ? r.repeatability.percent : none, again ? r.repeatability.reliability : none})
        csv += "," + cell(s.count > 0 ? value : none);
      for (const Estimator estimator : {Estimator::nearest, Estimator::raw, Estimator::paper})
        csv += "," + cell(r.of(estimator).count > 0 ? r.of(estimator).mae : none);
      csv += "\n";
    }
  return csv;
}

std::string people_csv_of(const std::vector<ConditionRun>& runs) {
  std::string csv =
      "family,condition,person,woman,measured,measurement,truth,value,low,high,again,nearest,raw_nearest,paper,"
      "dressed,clothing_probability\n";
  const auto precise = [](double value) { return std::isfinite(value) ? fmt::format("{:.2f}", value) : ""; };
  for (const ConditionRun& run : runs)
    for (std::size_t i = 0; i < run.outcomes.size(); ++i)
      for (std::size_t m = 0; m < kMeasurementCount; ++m) {
        const Outcome& o = run.outcomes[i];
        csv += fmt::format("{},{},{},{},{},{},{}", name_of(o.family), run.report.condition, i, o.woman ? 1 : 0,
                           o.measured ? 1 : 0, kMeasurementTable[m].id, precise(o.truth[m]));
        const index::IntervalEstimate& e = o.answer.measurements[m];
        const double none = std::nan("");
        for (const double value :
             {static_cast<double>(e.value), static_cast<double>(e.low), static_cast<double>(e.high),
              o.measured_again ? static_cast<double>(o.again[m]) : none, value_of(o, Estimator::nearest, m),
              value_of(o, Estimator::raw, m), value_of(o, Estimator::paper, m)})
          csv += "," + (o.measured ? precise(value) : "");
        csv += fmt::format(",{},{}\n", o.dressed ? 1 : 0,
                           o.measured ? cell(static_cast<double>(o.answer.clothing.probability)) : "");
      }
  return csv;
}

}  // namespace im2fit::lab
