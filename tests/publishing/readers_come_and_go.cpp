// Readers that listen, that are slow, that are not there, that vanish: whoever publishes never waits.
#include <gmock/gmock.h>

#include <filesystem>

#include "drivers/publishing/publisher.h"
#include "tests/publishing/sockets.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

class UnixPublisher : public ::testing::Test {
 protected:
  TemporaryFolder folder;
  const std::string path = folder.file("poses");
  std::unique_ptr<Publisher> publisher = open_publisher("unix:" + path);
};

TEST_F(UnixPublisher, GivesEveryReaderEveryLineSinceItCame) {
  publisher->publish("nobody\n");
  const OwnedDescriptor first = connected_to(path);
  publisher->publish("one\n");
  const OwnedDescriptor second = connected_to(path);
  publisher->publish("two\n");
  EXPECT_THAT(lines_in(received(first)), ElementsAre("one", "two"));
  EXPECT_THAT(lines_in(received(second)), ElementsAre("two"));
  const PublishCounts& c = publisher->counts();
  EXPECT_EQ(c.lines, 3u);
  EXPECT_EQ(c.sent, 3u);
  EXPECT_EQ(c.lost, 0u);
  EXPECT_EQ(c.unread, 1u);
  EXPECT_EQ(c.readers, 2u);
}

TEST_F(UnixPublisher, LosesLinesOfASlowReaderAndNeverHalfOfOne) {
  const OwnedDescriptor slow = connected_to(path), quick = connected_to(path);
  constexpr int kLines = 10000;
  const std::string dots(200, '.');
  std::string got_quick, got_slow;
  for (int i = 0; i < kLines; ++i) {
    publisher->publish("line " + std::to_string(i) + dots + "\n");
    got_quick += received(quick);
    if (i == kLines / 2) got_slow += received(slow);  // it wakes up for a moment
  }
  got_slow += received(slow);
  publisher->publish("what was begun comes first\n");
  got_slow += received(slow);
  EXPECT_EQ(lines_in(got_quick).size(), static_cast<std::size_t>(kLines));
  std::vector<std::string> lines = lines_in(got_slow);
  EXPECT_LT(lines.size(), static_cast<std::size_t>(kLines));
  EXPECT_EQ(lines.back(), "what was begun comes first");
  lines.pop_back();
  EXPECT_GT(publisher->counts().lost, 0u);
  EXPECT_EQ(publisher->counts().lost + publisher->counts().sent, 2u * (kLines + 1));
  int last = -1;
  for (const std::string& line : lines) {
    ASSERT_EQ(line.substr(0, 5), "line ") << line;
    ASSERT_EQ(line.substr(line.find('.')), dots) << line;
    EXPECT_GT(std::stoi(line.substr(5)), last);
    last = std::stoi(line.substr(5));
  }
  EXPECT_GT(last, kLines / 2);
}

TEST_F(UnixPublisher, SurvivesAReaderThatVanishes) {
  {
    const OwnedDescriptor reader = connected_to(path);
    publisher->publish("one\n");
    EXPECT_EQ(publisher->counts().readers, 1u);
  }
  publisher->publish("two\n");
  publisher->publish("three\n");
  EXPECT_EQ(publisher->counts().readers, 0u);
  EXPECT_GE(publisher->counts().lost + publisher->counts().unread, 2u);
  const OwnedDescriptor again = connected_to(path);
  publisher->publish("four\n");
  EXPECT_THAT(lines_in(received(again)), ElementsAre("four"));
  EXPECT_EQ(publisher->counts().connected, 2u);
}

TEST_F(UnixPublisher, RemovesItsFileAndReplacesAnAbandonedOne) {
  publisher.reset();
  EXPECT_FALSE(fs::exists(path));
  {
    const sockaddr_un address = address_of(path);
    const OwnedDescriptor dead(::socket(AF_UNIX, SOCK_STREAM, 0));
    ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ASSERT_TRUE(fs::exists(path)) << "as a killed process leaves it";
  publisher = open_publisher("unix:" + path);
  EXPECT_TRUE(connected_to(path));
}

TEST_F(UnixPublisher, RefusesAPathThatIsTaken) {
  EXPECT_THAT(complaint([&] { open_publisher("unix:" + path); }), HasSubstr("another process serves it"));
  EXPECT_TRUE(connected_to(path)) << "the first one still serves";
  const std::string file = folder.write("file", "mine");
  EXPECT_THAT(complaint([&] { open_publisher("unix:" + file); }), HasSubstr("no socket"));
  EXPECT_EQ(bytes_of(file), "mine");
  EXPECT_THAT(complaint([&] { open_publisher("unix:" + folder.file(std::string(120, 'x'))); }), HasSubstr("longer"));
  EXPECT_THAT(complaint([&] { open_publisher("unix:" + folder.file("no/such/folder")); }), HasSubstr("cannot be made"));
}

TEST_F(UnixPublisher, RefusesALineThatMayNotPassWhole) {
  EXPECT_THROW(publisher->publish(std::string(kLongestLine + 1, 'x')), std::invalid_argument);
}

TEST(Publisher, RefusesOtherTargets) {
  for (const char* where : {"", "unix", "unix:", "udp:", "udp:host", "udp::5", "udp:host:0", "udp:host:65536",
                            "udp:host:port", "udp:1:2:3", "tcp:host:5", "/tmp/x"}) {
    EXPECT_THAT(invalid_publish_target(where), HasSubstr("must be -")) << where;
    EXPECT_THAT(complaint([&] { open_publisher(where); }), HasSubstr("--publish")) << where;
  }
  for (const char* where : {"-", "unix:x", "udp:localhost:5", "udp:[::1]:65535"})
    EXPECT_EQ(invalid_publish_target(where), "") << where;
  EXPECT_THAT(complaint([&] { open_publisher("udp:no.such.host.invalid:5"); }), HasSubstr("no such host"));
}

/// Bound to a port of the loopback.
OwnedDescriptor bound_datagrams(int& port) {
  OwnedDescriptor made(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(::bind(made.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(::getsockname(made.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  port = ntohs(address.sin_port);
  return made;
}

TEST(UdpPublisher, SendsADatagramALine) {
  int port = 0;
  const OwnedDescriptor reader = bound_datagrams(port);
  const auto publisher = open_publisher("udp:127.0.0.1:" + std::to_string(port));
  publisher->publish("one\n");
  publisher->publish("two\n");
  EXPECT_THAT(lines_in(received(reader)), ElementsAre("one", "two"));
  EXPECT_EQ(publisher->counts().sent, 2u);
}

TEST(UdpPublisher, CountsWhatNobodyTakes) {
  int port = 0;
  { bound_datagrams(port); }
  const auto publisher = open_publisher("udp:127.0.0.1:" + std::to_string(port));
  for (int i = 0; i < 10; ++i) publisher->publish("x\n");
  EXPECT_EQ(publisher->counts().sent + publisher->counts().lost, 10u);
  EXPECT_GT(publisher->counts().lost, 0u) << "the refusals come back";
}

}  // namespace
}  // namespace pavo::test
