// SPDX-License-Identifier: Apache-2.0
// `im2fit-lab eval` as a shell starts it, and the page it writes.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "depth_folder.h"
#include "evaluation/measurements/full_report.h"
#include "index/format.h"
#include "measure_run.h"
#include "well_formed.h"

namespace im2fit {
namespace {

using Words = std::vector<std::string>;

test::Run eval(const Words& words) {
  Words command = {test::kLab,           "eval",    "--body",           test::body_path(), "--joint-model",
                   test::tracker_path(), "--index", test::index_path(), "--no-raw"};
  command.insert(command.end(), words.begin(), words.end());
  test::RunOptions options;
  options.timeout_s = 300;
  return test::run_program(command, options);
}

// HTML is not XML: its head and its elements without an end.
std::string html_fault(const std::string& html) {
  const std::string head = "<!doctype html>\n";
  if (html.rfind(head, 0) != 0) return "no doctype";
  return test::xml_fault(std::string_view(html).substr(head.size()), {"meta", "br"});
}

// A page that needs a network requests something by address.
void expect_self_contained(const std::string& html) {
  for (const char* word : {"http:", "https:", "src=", "@import", "url(", "<script", "<link"})
    EXPECT_EQ(html.find(word), std::string::npos) << word;
}

TEST(WellFormed, SeesWhatIsNot) {
  EXPECT_EQ(test::xml_fault("<a x=\"1\"><!-- & --><b/>t &lt; u</a>"), "");
  for (const char* text : {"<a><b></a></b>", "<a>", "</a>", "<a x=1/>", "<a x=\"1\" x=\"2\"/>", "<a>a & b</a>",
                           "<a x=\"&\"/>", "<a", "a < b"})
    EXPECT_NE(test::xml_fault(text), "") << text;
}

TEST(Eval, WrongWordsExitWithTwoAndOneLine) {
  const Words table[] = {{"--condition", "foggy"},
                         {"--conditions", "noise,foggy"},
                         {"--conditions", "noise", "--all"},
                         {"--frames", "0"},
                         {"--family", "twins"},
                         {"--ansur-ends", "1.5"},
                         {"--icp", "0"},
                         {"--icp", "2", "--icp-references", "x.json"}};
  for (const Words& words : table) {
    const test::Run run = eval(words);
    EXPECT_EQ(run.exit_code, 2) << words.back();
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  }
}

TEST(Eval, FamilyWithoutItsSurveySaysWhereItBelongs) {
  IM2FIT_NEED_DATA();
  const test::Run run = eval({"--family", "modifiers,ansur", "--ansur", "/no/such/folder", "--subjects", "1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  EXPECT_NE(run.err.find("/no/such/folder"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("--ansur"), std::string::npos) << run.err;
}

TEST(Eval, WhatAFamilyCannotShowIsRefusedBeforeAnybodyIsMeasured) {
  for (const char* condition : {"clothed", "garments+both", "heavy"}) {
    const test::Run run = eval({"--family", "modifiers,other", "--conditions", std::string("noise,") + condition});
    EXPECT_EQ(run.exit_code, 1) << condition;
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
    EXPECT_NE(run.err.find(condition), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("family other"), std::string::npos) << run.err;
  }
}

TEST(Eval, FamilyWithoutItsMeshSaysWhereItBelongs) {
  IM2FIT_NEED_DATA();
  const test::Run run = eval({"--family", "other", "--other", "/no/such/folder", "--subjects", "1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  EXPECT_NE(run.err.find("/no/such/folder"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("--other"), std::string::npos) << run.err;
}

TEST(Eval, WritesEverythingOnAnyNumberOfThreads) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const Words tiny = {
      "--conditions", "frames5+320,clothed+frames5+320", "--subjects", "2", "--twice", "--json", "--commit",
      "abc1234"};
  Words alone = tiny, together = tiny;
  alone.insert(alone.end(), {"--threads", "1", "--html", folder.path("page.html"), "--csv", folder.path("all.csv"),
                             "--people", folder.path("people.csv"), "--figures", folder.path("figures"), "--out",
                             folder.path("all.json"), "--icp", "1"});
  together.insert(together.end(), {"--threads", "3", "--icp", "1"});
  const test::Run one = eval(alone), three = eval(together);
  ASSERT_EQ(one.exit_code, 0) << one.err;
  ASSERT_EQ(three.exit_code, 0) << three.err;
  EXPECT_EQ(one.out, three.out);
  EXPECT_EQ(one.out, test::read_text(folder.path("all.json")));
  const auto json = nlohmann::json::parse(one.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << one.out;
  EXPECT_EQ(json.at("schema"), "im2fit.evaluation-set/1");
  ASSERT_EQ(json.at("conditions").size(), 2U);
  EXPECT_EQ(json.at("conditions").at(1).at("condition"), "clothed+frames5+320");
  EXPECT_EQ(json.at("conditions").at(0).at("subjects"), 2);
  EXPECT_EQ(json.at("conditions").at(0).at("family"), "modifiers");
  const auto& with = json.at("conditions").at(1).at("measured_with");
  EXPECT_EQ(with.at("index_format"), index::kVersion);
  EXPECT_GT(with.at("index_models").get<int>(), 0);
  EXPECT_EQ(with.at("seed"), lab::EvaluationOptions{}.seed);
  EXPECT_EQ(with.at("commit"), "abc1234");
  EXPECT_EQ(json.at("conditions").at(0).at("groups").size(), 2U);  // a man and a woman: a third of one each

  const std::string page = test::read_text(folder.path("page.html"));
  EXPECT_EQ(html_fault(page), "");
  expect_self_contained(page);
  int pictures = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder.path("figures"))) {
    EXPECT_EQ(test::xml_fault(test::read_text(file.path())), "") << file.path();
    ++pictures;
  }
  EXPECT_GE(pictures, 8);
  const std::string csv = test::read_text(folder.path("all.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * static_cast<int>(kMeasurementCount));
  const std::string people = test::read_text(folder.path("people.csv"));
  EXPECT_EQ(std::count(people.begin(), people.end(), '\n'), 1 + 2 * 2 * static_cast<int>(kMeasurementCount));
}

// The pose that guidance asks of people whose arms rest on the body when they hang.
TEST(Eval, HeavyPeopleWithTheirArmsOutAreMeasured) {
  IM2FIT_NEED_DATA();
  const test::Run run = eval({"--conditions", "heavy+arms_out+frames5,heavy+arms_out+frames5+clothed", "--subjects",
                              "6", "--no-raw", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << run.out;
  for (const auto& condition : json.at("conditions")) {
    EXPECT_EQ(condition.at("measured"), 6);
    EXPECT_EQ(condition.at("lifted_arms"), 0) << "they are out already";
  }
}

// No person measured, hostile names: still a page.
TEST(EvalPage, StandsWithoutData) {
  lab::FullReport report;
  report.provenance = "<b> & \"quotes\"";
  report.runs.push_back({{"no&body", "<nobody>", {}}, std::vector<lab::Outcome>(3), {}});
  report.runs[0].report = lab::report_of(report.runs[0].outcomes, "no&body", "<nobody>");
  const std::string page = lab::html_of(report);
  EXPECT_EQ(html_fault(page), "");
  expect_self_contained(page);
  EXPECT_NE(page.find("3 of 3 not measured"), std::string::npos);
  for (const lab::Figure& figure : lab::figures_of(report)) EXPECT_EQ(test::xml_fault(figure.picture.file()), "");
}

TEST(EvalPage, ShowsTheMachinesFiguresItIsGiven) {
  lab::FullReport report;
  report.runs.push_back({{"noise", "", {}}, {}, {}});
  report.runtime = {{"a.i2f", 1000, 0.01, 0.02, 3, 9, 20}, {"b.i2f", 50'000, 0.02, 0.04, 3, 9, 20}};
  report.references = {{"im2fit", {{1000, 0.01, 0.02}, {5e6, 0.16, 0.35}}},
                       {"brute force, 501 float", {{1000, 0.02, 0.04}}}};
  report.icp = {{"ours, point to plane", "a man", {40, 20, 12}}, {"PCL", "a man", {40, 30, 25}}};
  const std::string page = lab::html_of(report);
  EXPECT_EQ(html_fault(page), "");
  EXPECT_NE(page.find("id=\"runtime\""), std::string::npos);
  EXPECT_NE(page.find("12.0 mm (ours, point to plane), 25.0 mm (PCL)"), std::string::npos);
}

TEST(IcpFile, ComesBackAsWritten) {
  const test::TestFolder folder;
  const std::vector<lab::IcpCurve> curves = {{"PCL", "a woman", {30.5, 20.25}}, {"ours", "a man", {}}};
  std::ofstream(folder.path("icp.json")) << lab::icp_json_of(curves);
  const auto read = lab::read_icp_curves(folder.path("icp.json"));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].method, "PCL");
  EXPECT_EQ((*read)[0].error_mm, (std::vector<double>{30.5, 20.25}));
  for (const char* text :
       {"", "[]", "{\"schema\":\"im2fit.icp/1\"}",
        "{\"schema\":\"im2fit.icp/1\",\"curves\":[{\"method\":1,\"who\":\"a\",\"error_mm\":[]}]}",
        "{\"schema\":\"im2fit.icp/1\",\"curves\":[{\"method\":\"a\",\"who\":\"b\",\"error_mm\":[\"x\"]}]}"}) {
    std::ofstream(folder.path("bad.json")) << text;
    EXPECT_FALSE(lab::read_icp_curves(folder.path("bad.json"))) << text;
  }
}

}  // namespace
}  // namespace im2fit
