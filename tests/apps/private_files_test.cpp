// SPDX-License-Identifier: Apache-2.0
// Every file the programs write of a person, with the umask most systems have: readable by its owner alone. Files of
// `serve` are tested in serve/serve_test.cpp, those of im2fitd in daemon/daemon_recording_test.cpp.
#include "private_files.h"

#include <algorithm>
#include <set>

#include "measured_clip.h"

namespace im2fit {
namespace {

using testing::IsEmpty;
using testing::IsSupersetOf;

class PrivateFiles : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() {
    const test::UsualUmask umask;
    render({"--frames", "8", "--paper-files"});
  }
  // Runs one of the programs, which must succeed, and returns the names of new files in the test's folder.
  std::set<std::string> written_by(std::vector<std::string> command) {
    const test::UsualUmask umask;
    const std::set<std::string> before = test::all_files_in(own_.path());
    const auto run = test::run_program(command);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::set<std::string> added = test::all_files_in(own_.path());
    for (const std::string& name : before) added.erase(name);
    return added;
  }
  std::vector<std::string> readable_by_others() const { return test::readable_by_others(own_.path()); }
  static std::vector<std::string> with_data(std::vector<std::string> command) {
    for (const std::string& word : {std::string("--body"), test::body_path(), std::string("--tracker"),
                                    test::tracker_path(), std::string("--index"), test::index_path()})
      command.push_back(word);
    return command;
  }
  test::TestFolder own_;
};

TEST_F(PrivateFiles, OfARenderedPersonAndTheirTruth) {
  EXPECT_THAT(test::all_files_in(clip()), IsSupersetOf({"truth.json", "camera.yaml", "000000.png", "sample.obj",
                                                        "sample.skel", "sample.bvh", "sample.txt"}));
  EXPECT_THAT(test::readable_by_others(clip()), IsEmpty());
  const auto truth = written_by(
      {test::kLab, "render", "--truth-only", "--out", own_.path("truth.json"), "--body", test::body_path()});
  EXPECT_THAT(truth, IsSupersetOf({"truth.json"}));
  EXPECT_THAT(readable_by_others(), IsEmpty());
}

TEST_F(PrivateFiles, OfAMeasurementItsMotionAndAGarmentTriedOn) {
  const std::string out = own_.path("out");
  const auto written = written_by(
      with_data({test::kProgram, "measure", clip(), "--frames", "5", "--out", out, "--motion", own_.path("m.csv")}));
  EXPECT_THAT(written, IsSupersetOf({"m.csv"}));
  EXPECT_THAT(test::all_files_in(out), IsSupersetOf({"result.json", "avatar.glb", "avatar.obj", "avatar.mtl",
                                                     "avatar_skin.png", "avatar.bvh", "overlay.png"}));
  for (const std::string picture : {"t.png", "t.glb"})
    EXPECT_THAT(written_by({test::kProgram, "try", "t_shirt", "--result", out + "/result.json", "--body",
                            test::body_path(), "--out", own_.path(picture)}),
                IsSupersetOf({picture}));
  EXPECT_THAT(readable_by_others(), IsEmpty());
}

TEST_F(PrivateFiles, OfARecording) {
  const auto folder =
      written_by({test::kProgram, "record", clip(), "--frames", "0", "--out", own_.path("r"), "--motion",
                  own_.path("m.bvh"), "--body", test::body_path(), "--tracker", test::tracker_path()});
  EXPECT_THAT(folder, IsSupersetOf({"m.bvh", "r/camera.yaml", "r/000000.png", "r/000007.png", "r/timestamps.csv"}));
#if IM2FIT_TEST_ONI
  EXPECT_THAT(written_by({test::kProgram, "record", clip(), "--frames", "0", "--out", own_.path("r.oni")}),
              IsSupersetOf({"r.oni", "r.oni.yaml"}));
#endif
  EXPECT_THAT(readable_by_others(), IsEmpty());
}

TEST_F(PrivateFiles, OfPeopleWhoComeAndGo) {
  const auto written = written_by(
      with_data({test::kProgram, "live", clip(), "--frames", "5", "--count", "1", "--out", own_.path("out"),
                 "--overlay", own_.path("pictures"), "--overlay-every", "4", "--motion", own_.path("m.glb")}));
  EXPECT_THAT(written, IsSupersetOf({"out/result.json", "out/avatar.glb", "m.glb"}));
  EXPECT_TRUE(
      std::any_of(written.begin(), written.end(), [](const auto& name) { return name.starts_with("pictures/"); }));
  EXPECT_THAT(readable_by_others(), IsEmpty());
}

}  // namespace
}  // namespace im2fit
