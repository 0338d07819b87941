// Where the tests are built with sanitizers, so is the command, and what it leaks is its exit status.
#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

TEST(Sanitizers, AreInTheCommandAsInTheTests) {
  Pavo waiting({"record", kVivid, "--out", "/tmp/waiting", "--size", "320x180", "--rate", "10"}, "/tmp/waiting.log");
  ASSERT_TRUE(eventually([] { return text_of("/tmp/waiting/mav0/cam0/data.csv").find(".png") != std::string::npos; }))
      << text_of("/tmp/waiting.log");
  const bool sanitized = text_of("/proc/" + waiting.pid() + "/maps").find("libasan") != std::string::npos;
  EXPECT_EQ(sanitized, kSanitized);
  waiting.send(SIGINT);
  EXPECT_EQ(waiting.wait(), 0) << text_of("/tmp/waiting.log");
}

TEST(Sanitizers, FindALeakHere) {
  if (!kSanitized) GTEST_SKIP() << "this build has no LeakSanitizer";
  const std::string told = "/tmp/leaks.log";
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open(told.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644), 2);
    static char* volatile kept = nullptr;  // the last one of them
    for (int n = 0; n < 10; ++n) {
      kept = new char[1000];
      *kept = 1;
    }
    std::exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_NE(WEXITSTATUS(status), 0);
  EXPECT_THAT(text_of(told), ::testing::HasSubstr("LeakSanitizer: detected memory leaks"));
}

}  // namespace
}  // namespace pavo::v4l2::test
