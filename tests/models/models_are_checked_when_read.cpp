#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/objdetect.hpp>
#include <sstream>
#include <stdexcept>

#include "drivers/models/model_file.h"
#include "stages/people/hog.h"
#include "stages/people/scan_hog.h"

namespace pavo {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

PedestrianModel example() {
  PedestrianModel model;
  for (std::size_t i = 0; i < PedestrianModel::kWeights; ++i)
    model.weights.push_back(std::sin(static_cast<float>(i)) / 3);
  model.features = {HogTone::linear, 12.5f, 0.3f, 0.07f};
  model.bias = -0.1f;
  model.slope = 1.0 / 3;
  model.offset = -2e-5;
  model.threshold = 0.62f;
  return model;
}

void expect_equal(const PedestrianModel& a, const PedestrianModel& b) {
  EXPECT_EQ(a.features.tone, b.features.tone);
  EXPECT_EQ(a.features.epsilon, b.features.epsilon);
  EXPECT_EQ(a.features.clip, b.features.clip);
  EXPECT_EQ(a.features.fade, b.features.fade);
  EXPECT_EQ(a.bias, b.bias);
  EXPECT_EQ(a.slope, b.slope);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.threshold, b.threshold);
  EXPECT_EQ(a.weights, b.weights);
}

/// The message of the error, which must be one line that names the file.
std::string error_of(const std::string& text) {
  try {
    parse_pedestrian_model(text, "m.txt");
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("m.txt:"), Not(HasSubstr("\n"))));
    return e.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

TEST(ModelFile, IsReadAsItWasWritten) {
  const std::string text = pedestrian_model_text(example(), "made by a test\nin two lines");
  EXPECT_THAT(text, HasSubstr("# made by a test\n# in two lines\n"));
  expect_equal(parse_pedestrian_model(text, "m.txt"), example());
  std::string windows = text;
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) windows.replace(at, 1, "\r\n");
  expect_equal(parse_pedestrian_model(windows, "m.txt"), example());
}

TEST(ModelFile, EveryTruncationIsNoticed) {
  const std::string text = pedestrian_model_text(example());
  for (std::size_t length = 0; length + 5 < text.size(); length += 97) EXPECT_NE(error_of(text.substr(0, length)), "");
  EXPECT_THAT(error_of(text.substr(0, text.size() - 4)), HasSubstr("not whole"));
}

TEST(ModelFile, SaysWhatIsWrongAndWhere) {
  const std::string text = pedestrian_model_text(example());
  EXPECT_THAT(error_of(replaced(text, "model 1", "model 2")), AllOf(HasSubstr("m.txt:1:"), HasSubstr("version '2'")));
  EXPECT_THAT(error_of(replaced(text, "linear", "log")), AllOf(HasSubstr("m.txt:2:"), HasSubstr("square_root")));
  EXPECT_THAT(error_of(replaced(text, "12.5", "0")), HasSubstr("epsilon must be positive"));
  EXPECT_THAT(error_of(replaced(text, "-0.1", "nan")), HasSubstr("finite"));
  EXPECT_THAT(error_of(replaced(text, "-0.1", "1e99")), HasSubstr("out of range"));
  EXPECT_THAT(error_of(replaced(text, "-0.1", "minus")), HasSubstr("expected a number, found 'minus'"));
  EXPECT_THAT(error_of(replaced(text, "-0.1", "")), HasSubstr("end of the line"));
  EXPECT_THAT(error_of(replaced(text, "calibration 0", "calibration -0")), HasSubstr("slope"));
  EXPECT_THAT(error_of(replaced(text, "0.62", "1.62")), HasSubstr("probability"));
  EXPECT_THAT(error_of(replaced(text, "3780", "3781")), HasSubstr("3780 weights"));
  EXPECT_THAT(error_of(text + "more\n"), HasSubstr("behind the end"));
  const std::size_t last = text.rfind(' ');
  EXPECT_THAT(error_of(text.substr(0, last) + "\nend\n"), HasSubstr("36 weights"));
  EXPECT_THAT(error_of("P5 12 12 255 \x01\x02"), HasSubstr("neither a pavo model"));
  EXPECT_THAT(error_of("\n\n"), HasSubstr("empty"));
}

TEST(ModelFile, OpenCvsLayoutIsReadInItsOrder) {
  const std::vector<float> theirs = cv::HOGDescriptor::getDefaultPeopleDetector();
  std::ostringstream text;
  text.precision(9);
  for (std::size_t i = 0; i < theirs.size(); ++i) text << theirs[i] << (i % 7 == 6 ? "\n" : ", ");
  const PedestrianModel model = parse_pedestrian_model(text.str(), "cv.txt");
  EXPECT_EQ(model.bias, theirs.back());
  EXPECT_EQ(model.weights[0], theirs[0]);
  EXPECT_EQ(model.weights[hog::descriptor_index(0, 0, 1, 0, 3)], theirs[9 + 3]);   // the cell below comes second
  EXPECT_EQ(model.weights[hog::descriptor_index(1, 0, 0, 0, 5)], theirs[36 + 5]);  // the block below comes second
  EXPECT_EQ(model.weights[hog::descriptor_index(0, 1, 0, 0, 0)], theirs[15 * 36]);
  EXPECT_NO_THROW(ScanPeopleHog{model});

  EXPECT_THAT(error_of("1 2 3"), HasSubstr("3780, or 3781"));
  EXPECT_THAT(error_of(text.str() + " 1"), HasSubstr("more than"));
  EXPECT_THAT(error_of("1 2 x"), HasSubstr("expected a number"));
}

class ModelOnDisk : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("pavo_models_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(ModelOnDisk, IsReplacedAsAWhole) {
  const auto file = folder_ / "model.txt";
  write_pedestrian_model(example(), file);
  PedestrianModel other = example();
  other.bias = 7;
  write_pedestrian_model(other, file);
  expect_equal(read_pedestrian_model(file), other);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "nothing is left behind";
}

TEST_F(ModelOnDisk, AFullDiskLeavesTheOldOne) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const auto file = folder_ / "model.txt";
  write_pedestrian_model(example(), file);
  PedestrianModel other = example();
  other.bias = 7;
  std::filesystem::create_symlink("/dev/full", folder_ / "model.txt.part");  // where the new one is written first
  EXPECT_THROW(write_pedestrian_model(other, file), std::runtime_error);
  expect_equal(read_pedestrian_model(file), example());
}

TEST_F(ModelOnDisk, WhatCannotBeReadOrWrittenIsNamed) {
  EXPECT_THROW(read_pedestrian_model(folder_ / "none.txt"), std::runtime_error);
  EXPECT_THROW(read_pedestrian_model(folder_), std::runtime_error);
  EXPECT_THROW(write_pedestrian_model(example(), folder_ / "no" / "such" / "folder.txt"), std::runtime_error);
}

TEST(DefaultModel, IsPartOfTheProgram) {
  const PedestrianModel model = default_pedestrian_model();
  EXPECT_NO_THROW(ScanPeopleHog{model});
  EXPECT_GT(model.threshold, 0.0f);
  EXPECT_LT(model.threshold, 1.0f);
}

}  // namespace
}  // namespace pavo
