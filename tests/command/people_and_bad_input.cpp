// What `pavo detect` and `pavo train` say to models, pictures and disks that are not as they should be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "drivers/models/model_file.h"
#include "tests/command/command.h"
#include "tests/people/pictures.h"

namespace pavo::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string pgm(const Image& image, int bytes_a_sample, bool colour) {
  std::string text = (colour ? "P6 " : "P5 ") + std::to_string(image.width()) + " " + std::to_string(image.height()) +
                     (bytes_a_sample == 2 ? " 65535\n" : " 255\n");
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      text.append(static_cast<std::size_t>(bytes_a_sample * (colour ? 3 : 1)), static_cast<char>(image.at(x, y)));
  return text;
}

/// A classifier that finds something everywhere, and pictures.
class Detect : public testing::Test {
 protected:
  Detect() {
    model_ = random_model(3);
    model_.threshold = 0.3f;
    folder_.write("model.txt", pedestrian_model_text(model_));
    folder_.write("plain.pgm", pgm(picture_, 1, false));
  }
  std::string at(const std::string& name) const { return folder_.file(name); }
  Called detect(const std::string& picture, const std::string& model = "model.txt") const {
    return pavo({"detect", at(picture), "--model", at(model)});
  }
  /// What it prints without the pictures' names.
  static std::string boxes(const std::string& csv) {
    std::string all;
    for (std::size_t line = csv.find('\n') + 1; line < csv.size(); line = csv.find('\n', line) + 1)
      all += csv.substr(csv.find(',', line), csv.find('\n', line) - csv.find(',', line)) + "\n";
    return all;
  }
  void refuses_model(const std::string& text, const std::string& part) const {
    folder_.write("wrong.txt", text);
    const Called called = detect("plain.pgm", "wrong.txt");
    EXPECT_EQ(called.status, 1);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("wrong.txt"), HasSubstr(part)));
    EXPECT_EQ(called.out, "") << "not even a header";
  }

  TemporaryFolder folder_;
  PedestrianModel model_;
  Image picture_ = textured(150, 200, 5);
};

TEST_F(Detect, DrawsNothingOverThePictures) {
  cv::imwrite(at("photo.png"), cv::Mat(200, 150, CV_8UC1, cv::Scalar(90)));
  const std::string before = bytes_of(at("photo.png"));
  const Called called = pavo({"detect", at("photo.png"), "--model", at("model.txt"), "--draw", at("")});
  EXPECT_EQ(called.status, 2);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("photo.png would be overwritten")));
  EXPECT_EQ(bytes_of(at("photo.png")), before);
}

TEST_F(Detect, ModelsThatAreNotWholeOrNotOursAreRefused) {
  const std::string good = pedestrian_model_text(model_);
  refuses_model(good.substr(0, good.size() / 2), "expected");
  refuses_model(good.substr(0, good.rfind("end")), "expected");
  refuses_model("pavo-pedestrian-model 2" + good.substr(good.find('\n')), "version");
  std::string nan = good;
  nan.replace(nan.find("bias ") + 5, 3, "nan");
  refuses_model(nan, "");
  refuses_model("", "");
}

TEST_F(Detect, DeepAndColouredPicturesAreGrayOnes) {
  const std::string plain = boxes(detect("plain.pgm").out);
  ASSERT_FALSE(plain.empty());
  folder_.write("deep.pgm", pgm(picture_, 2, false));
  folder_.write("coloured.ppm", pgm(picture_, 1, true));
  for (const char* name : {"deep.pgm", "coloured.ppm"}) {
    const Called called = detect(name);
    EXPECT_EQ(called.status, 0) << called.error;
    EXPECT_EQ(called.error, "");
    EXPECT_EQ(boxes(called.out), plain) << name;
  }
}

TEST_F(Detect, PicturesSmallerThanAWindowHoldNobody) {
  for (const auto& [w, h] : {std::pair(1, 1), {63, 128}, {64, 127}, {2000, 1}}) {
    folder_.write("small.pgm", pgm(Image(w, h), 1, false));
    const Called called = detect("small.pgm");
    EXPECT_EQ(called.status, 0) << called.error;
    EXPECT_EQ(called.out, "image,x,y,width,height,score\n");
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("smaller than a window of 64x128")));
  }
}

class Train : public Detect {
 protected:
  Train() {
    for (const char* name : {"people", "empty"}) std::filesystem::create_directory(at(name));
    for (int i = 0; i < 6; ++i) {
      Image crop = textured(70, 134, static_cast<unsigned>(i));
      for (int y = 20; y < 114; ++y)
        for (int x = 29; x < 41; ++x) crop.at(x, y) = 250;
      folder_.write("people/" + std::to_string(i) + ".pgm", pgm(crop, 1, false));
      folder_.write("empty/" + std::to_string(i) + ".pgm", pgm(textured(120, 150, 50 + unsigned(i)), 1, false));
    }
  }
  Called train(const std::string& before = ":") const {
    return pavo({"train", at("people"), at("empty"), "--out", at("model.txt"), "--random", "30", "--rounds", "1",
                 "--hold-out", "2", "--workers", "1"},
                before);
  }
};

TEST_F(Train, PositivesThatAreAllTooSmallAreNamedAndNoModelIsMade) {
  const std::string old = bytes_of(at("model.txt"));
  for (int i = 0; i < 6; ++i)
    folder_.write("people/" + std::to_string(i) + ".pgm", pgm(textured(60, 128, 1), 1, false));
  const Called called = train();
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(HasSubstr("60x128 pixels, expected at least 64x128: skipped\n"),
                                  HasSubstr("no positive picture could be used")));
  EXPECT_EQ(bytes_of(at("model.txt")), old);
}

TEST_F(Train, WhatCannotBeWrittenIsToldBeforeTheWorkBegins) {
  const Called called = pavo({"train", at("people"), at("empty"), "--out", at("nowhere/model.txt"), "--hold-out", "2"});
  EXPECT_EQ(called.status, 1);
  EXPECT_EQ(called.out, "");
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("nowhere/model.txt.training: cannot be written")));
}

TEST_F(Train, OnePictureOfAPersonIsNotEnough) {
  for (int i = 1; i < 6; ++i) std::filesystem::remove(at("people/" + std::to_string(i) + ".pgm"));
  const Called called = train();
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("one picture: expected at least 2")));
}

// A limit on the size of files fails as a full disk does.
TEST_F(Train, AFullDiskLeavesTheOldModel) {
  const std::string old = bytes_of(at("model.txt"));
  for (const char* blocks : {"8", "60"}) {  // of 512 bytes
    const Called called = train(std::string("trap '' XFSZ; ulimit -f ") + blocks);
    EXPECT_EQ(called.status, 1);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("File too large")));
    EXPECT_EQ(bytes_of(at("model.txt")), old);
  }
  EXPECT_EQ(train().status, 0) << "when there is room again";
  EXPECT_NE(bytes_of(at("model.txt")), old);
}

}  // namespace
}  // namespace pavo::test
