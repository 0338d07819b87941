// OpenCV's own threads are off in these tests, as they are in the command: the thread sanitizer sees only half of what
// they do, and takes it for races.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace {

class WithoutThreadsOfOpenCv : public ::testing::Environment {
  void SetUp() override { cv::setNumThreads(1); }
};

const ::testing::Environment* const environment =
    ::testing::AddGlobalTestEnvironment(new WithoutThreadsOfOpenCv);  // owned by GoogleTest

}  // namespace
