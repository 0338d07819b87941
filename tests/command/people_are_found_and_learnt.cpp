#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/command/command.h"
#include "tests/people/pictures.h"

namespace pavo::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// Pictures with a bar where a person would be, and pictures without.
class Pictures : public testing::Test {
 protected:
  Pictures() {
    for (const char* name : {"people", "empty", "nothing"}) std::filesystem::create_directories(folder_.file(name));
    for (int i = 0; i < 14; ++i) {
      Image crop = textured(70, 134, static_cast<unsigned>(i));
      for (int y = 20; y < 114; ++y)
        for (int x = 29; x < 41; ++x) crop.at(x, y) = 250;
      write("people/p" + std::to_string(10 + i) + ".pgm", crop);
      if (i < 9) write("empty/n" + std::to_string(i) + ".pgm", textured(150, 160, 100 + static_cast<unsigned>(i)));
    }
  }
  void write(const std::string& name, const Image& image) const {
    std::string text = "P5 " + std::to_string(image.width()) + " " + std::to_string(image.height()) + " 255\n";
    for (int y = 0; y < image.height(); ++y)
      text.append(reinterpret_cast<const char*>(image.row(y)), static_cast<std::size_t>(image.width()));
    folder_.write(name, text);
  }
  std::string at(const std::string& name) const { return folder_.file(name); }
  Words train(const Words& more = {}) const {
    Words words{"train",    at("people"), at("empty"),  "--out", at("model.txt"), "--random", "60",
                "--rounds", "2",          "--hold-out", "3",     "--workers",     "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  TemporaryFolder folder_;
};

TEST_F(Pictures, WhatIsLearntIsFound) {
  const Called trained = pavo(train());
  ASSERT_EQ(trained.status, 0) << trained.error;
  EXPECT_EQ(trained.error, "");
  EXPECT_THAT(trained.out, HasSubstr("round 0: "));
  EXPECT_FALSE(std::filesystem::exists(at("model.txt.training")));
  const std::string first = bytes_of(at("model.txt"));
  EXPECT_THAT(first, StartsWith("pavo-pedestrian-model 1\n# trained by pavo train: seed 1"));
  ASSERT_EQ(pavo(train({"--workers", "1"})).status, 2) << "an option given twice is a wrong call";
  ASSERT_EQ(pavo(train()).status, 0);
  EXPECT_EQ(bytes_of(at("model.txt")), first) << "the same again";

  const Called found = pavo({"detect", at("people"), "--model", at("model.txt"), "--threshold", "0.05", "--json"});
  ASSERT_EQ(found.status, 0) << found.error;
  const nlohmann::json pictures = nlohmann::json::parse(found.out);
  ASSERT_EQ(pictures.size(), 14u);
  int people = 0;
  for (const auto& p : pictures) people += static_cast<int>(p["people"].size());
  EXPECT_GE(people, 10);
}

TEST_F(Pictures, DetectPrintsAndDraws) {
  write("people/tiny.pgm", Image(1, 1));
  folder_.write("people/notes.txt", "not a picture");
  const Called called = pavo({"detect", at("people"), at("empty/n0.pgm"), "--threshold", "0", "--draw", at("drawn")});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, StartsWith("image,x,y,width,height,score\np10.pgm,"));
  EXPECT_THAT(called.out, HasSubstr("\nn0.pgm,"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(at("drawn")), {}), 16);
}

TEST_F(Pictures, AFolderMayKeepThemInImages) {
  write("set/images/one.pgm", textured(80, 160, 1));
  folder_.write("set/truth.csv", "image,x,y,width,height,ignore\n");
  const Called called = pavo({"detect", at("set"), "--json"});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, HasSubstr("one.pgm"));

  write("set/own.pgm", textured(80, 160, 2));  // its own come first
  const Called own = pavo({"detect", at("set"), "--json"});
  ASSERT_EQ(own.status, 0) << own.error;
  EXPECT_THAT(own.out, testing::AllOf(HasSubstr("own.pgm"), testing::Not(HasSubstr("one.pgm"))));
}

TEST_F(Pictures, WhatCannotBeReadIsNamedAndTheRestDone) {
  folder_.write("empty/broken.pgm", "P5 100 100 255\nshort");
  const Called called = pavo({"detect", at("empty")});
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, testing::AllOf(IsOneLine(), HasSubstr("broken.pgm")));
  EXPECT_THAT(called.out, StartsWith("image,"));

  write("people/a_small.pgm", textured(40, 60, 1));
  const Called trained = pavo(train());
  EXPECT_EQ(trained.status, 0);
  EXPECT_THAT(trained.error, HasSubstr("a_small.pgm: 40x60 pixels, expected at least 64x128: skipped\n"));
  EXPECT_THAT(trained.error, HasSubstr("broken.pgm"));
  EXPECT_THAT(trained.out, HasSubstr("2 pictures could not be used"));
}

TEST_F(Pictures, WrongCallsAndEmptyFolders) {
  const auto fails = [](const Words& words, const std::string& part) {
    const Called called = pavo(words);
    EXPECT_NE(called.status, 0);
    EXPECT_THAT(called.error, testing::AllOf(IsOneLine(), HasSubstr(part)));
  };
  fails({"detect", at("nothing")}, "no picture in it");
  fails({"detect", at("missing")}, "no such file");
  fails({"detect", at("people"), "--model", at("people/p10.pgm")}, "neither a pavo model");
  fails({"detect", at("people"), "--threshold", "2"}, "--threshold");
  fails({"train", at("nothing"), at("empty"), "--out", at("m")}, "no picture in it");
  fails({"train", at("people"), at("empty"), "--out", at("m"), "--hold-out", "9"}, "--hold-out");
  folder_.write("model.txt.training", "pavo-training 1\nanother\n");
  fails(train(), "other pictures or options");
}

TEST_F(Pictures, AFolderOfCorruptNegativesIsAnError) {
  for (int i = 0; i < 9; ++i) folder_.write("empty/n" + std::to_string(i) + ".pgm", "P5 9 9 255\n");
  const Called called = pavo(train());
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, HasSubstr("no negative picture could be used"));
  EXPECT_FALSE(std::filesystem::exists(at("model.txt")));
}

}  // namespace
}  // namespace pavo::test
